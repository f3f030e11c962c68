"""Rare shares (`verify --rare`) against a closed form and OpenTURNS' subset simulation, on a model in C."""

import csv
import json
import subprocess

import numpy as np
import openturns as ot
import pytest
from functions import pack
from scipy import integrate, special
from test_acceptance import PROGRAM

NOMINAL, TOLERANCE = 16, 1
STUDY = f"""fmu = "functions.fmu"
[parameters.x1]
distribution = "normal"
mean = 0
deviation = 1
[parameters.x2]
distribution = "normal"
mean = 0
deviation = 1
[criteria.P]
variable = "product"
nominal = {NOMINAL}
tolerance = {TOLERANCE}
"""


# Shorter ones are in orchestrator/tests/cli/rare.rs.
pytestmark = pytest.mark.long


@pytest.fixture(scope="module")
def found(tmp_path_factory):
    folder = tmp_path_factory.mktemp("rare")
    pack(folder, 2, "product")
    (folder / "study.toml").write_text(STUDY)
    call = [PROGRAM, "verify", "study.toml", "--rare", "--points", "100000", "--output", "out"]
    subprocess.run(call, cwd=folder, check=True, capture_output=True)
    with (folder / "out" / "rare.csv").open() as file:
        rows = list(csv.DictReader(file))
    return json.loads((folder / "out" / "rare.json").read_text()), rows


def exact():
    """The product of two standard normal numbers has the density K0(|z|) / pi."""
    low, high = NOMINAL - TOLERANCE, NOMINAL + TOLERANCE
    return integrate.quad(lambda z: special.k0(z) / np.pi, low, high, epsrel=1e-10, epsabs=0)[0]


def test_the_share_is_the_closed_form(found):
    result, _ = found
    # Four standard errors.
    assert result["relative_error"] < 0.06
    assert abs(np.log(result["share"] / exact())) < 4 * result["relative_error"]


def test_both_regions_are_found_and_are_equal(found):
    result, rows = found
    assert len(result["regions"]) == 2
    weights = np.array([float(row["weight"]) for row in rows])
    positive = np.array([float(row["x1"]) > 0 for row in rows])
    assert abs(weights[positive].sum() / weights.sum() - 0.5) < 0.1
    products = np.array([float(row["x1"]) * float(row["x2"]) for row in rows])
    assert np.all(np.abs(products - NOMINAL) <= TOLERANCE)


def test_openturns_agrees(found):
    result, _ = found
    ot.RandomGenerator.SetSeed(1)
    inputs = ot.RandomVector(ot.Normal(2))
    function = ot.SymbolicFunction(["a", "b"], [f"abs(a * b - {NOMINAL}) / {TOLERANCE} - 1"])
    event = ot.ThresholdEvent(ot.CompositeRandomVector(function, inputs), ot.Less(), 0)
    search = ot.SubsetSampling(event)
    search.setMaximumOuterSampling(20000)
    search.setBlockSize(1)
    search.run()
    theirs = search.getResult()
    error = theirs.getCoefficientOfVariation()
    assert error < 0.5
    assert abs(np.log(result["share"] / theirs.getProbabilityEstimate())) < 4 * error
