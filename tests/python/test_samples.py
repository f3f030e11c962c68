"""Parameters from a posterior's sample, through the Python package, against numpy and the exact posterior."""

import numpy as np
import pytest
from functions import pack
from scipy.stats import norm

from fmu_orchestrator import OrchestratorError, Study

FIT = """fmu = "functions.fmu"
[identify.free.x1]
min = 0.5
max = 2
[identify.free.x2]
min = 0.5
max = 2
[identify.measured.P]
variable = "product"
value = 1
accuracy = 0.1
"""
STUDY = """fmu = "functions.fmu"
[design]
method = "latin-hypercube"
points = 1000
[parameters.x1]
distribution = "sample"
file = "fit/posterior.csv"
[parameters.x3]
distribution = "normal"
mean = 0.5
deviation = 0.2
[parameters.x2]
distribution = "sample"
file = "fit/posterior.csv"
[criteria.P]
variable = "product"
nominal = 1
tolerance = 0.25
[criteria.L]
variable = "linear"
nominal = 4.5
tolerance = 0.9
"""


def good(x1, x2, x3):
    return (abs(x1 * x2 - 1) <= 0.25) & (abs(x1 + 2 * x2 + 3 * x3 - 4.5) <= 0.9)


@pytest.fixture(scope="module")
def study(tmp_path_factory):
    folder = tmp_path_factory.mktemp("samples")
    pack(folder, 3, "product", "linear")
    (folder / "fit.toml").write_text(FIT)
    Study.load(folder / "fit.toml").identify(posterior=1000, output=folder / "fit", progress=False, isolation="none")
    (folder / "study.toml").write_text(STUDY)
    return Study.load(folder / "study.toml")


def test_the_share_is_that_of_the_sample_and_of_the_posterior(study, tmp_path):
    found = study.verify(output=tmp_path, progress=False, isolation="none")
    rows = np.loadtxt(study.path.parent / "fit" / "posterior.csv", delimiter=",", skiprows=2, usecols=(1, 2))
    points = found.points.to_numpy(["x1", "x2", "x3"])
    # A Latin hypercube of as many points as rows takes each of them once.
    assert sorted(map(tuple, points[:, :2])) == sorted(map(tuple, rows))
    assert found.summary["verified"] == good(*points.T).sum()
    # Each row with all of x3.
    levels = norm.ppf((np.arange(200) + 0.5) / 200) * 0.2 + 0.5
    of_sample = good(rows[:, :1], rows[:, 1:], levels).mean()
    share = found.summary["verified_fraction"]
    assert abs(share - of_sample) < 0.04, (share, of_sample)
    # The posterior by its density; the sample is worth about half of its rows.
    places = 0.5 + 1.5 * (np.arange(300) + 0.5) / 300
    one, other = np.meshgrid(places, places)
    density = np.exp(-0.5 * ((one * other - 1) / 0.1) ** 2)
    exact = np.mean([(density * good(one, other, level)).sum() for level in levels[::4]]) / density.sum()
    assert abs(of_sample - exact) < 4 * np.sqrt(exact * (1 - exact) / 400), (of_sample, exact)


def test_what_moves_one_parameter_alone_is_refused(study, tmp_path):
    for refused in ({"morris": 8}, {"base": 8}):
        with pytest.raises(OrchestratorError, match="x1, x2 are drawn together from a sample"):
            study.sensitivity(**refused, output=tmp_path)
