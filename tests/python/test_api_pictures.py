"""Pictures of results, what a notebook shows, and the units of tables."""

import subprocess
import sys
import xml.etree.ElementTree

import matplotlib.figure
import numpy as np
import pandas
import pytest
from functions import pack
from python_package import ENVIRONMENT, PAPER

from fmu_orchestrator import Identification, OrchestratorError, Study, Verification
from fmu_orchestrator._html import COLOURS, verification
from fmu_orchestrator._html import headline as headline_of
from fmu_orchestrator._plot import limits, points
from fmu_orchestrator._table import Table


def labels(figure):
    return [(axes.get_xlabel(), axes.get_ylabel()) for axes in figure.axes]


def test_the_cloud_and_the_histograms(verified):
    figure = verified.plot()
    cloud, *histograms = labels(figure)
    assert all(label.endswith("]") for label in cloud) and cloud[0] != cloud[1]
    assert [name for name, _ in histograms] == ["T_oil [degC]", "T_bearing [degC]", "F_N [N]", "P_fr [W]"]
    # Every point is in the cloud, and all finite values in each histogram.
    legend = [text.get_text() for text in figure.axes[0].get_legend().get_texts()]
    assert legend == ["not verified (48)", "verified (12)"]
    for axes in figure.axes[1:]:
        assert sum(bar.get_height() for bar in axes.patches if bar.get_y() >= 0 and bar.get_width() < np.ptp(axes.get_xlim()) / 20) == 60
    assert labels(verified.plot("load.preload", "F_N"))[0] == ("load.preload [N]", "F_N [N]")
    with pytest.raises(KeyError, match="there are point"):
        verified.plot("load.prelaod")


@pytest.mark.parametrize("count, expected", [
    ({"nominal": 5.0, "tolerance": 1.0}, (4, 6)), ({"nominal": None, "lower": None, "upper": 3.0}, (None, 3)),
    ({"nominal": 0.0, "tolerance": 0.05, "metric": "nrmse"}, (None, 0.05)),
    ({"nominal": 1.0, "tolerance": 0.25, "metric": "corridor"}, (0.75, None))])
def test_accepted_ranges(count, expected):
    assert limits(count) == expected


@pytest.mark.parametrize("values, flags", [
    ([1.0, 2.0, 3.0, 1e160], [True, True, False, False]), ([float("nan")] * 4, [False] * 4), ([2.0] * 4, [True] * 4)])
def test_odd_values_have_a_picture(values, flags, tmp_path):
    table = Table({"point": [1, 2, 3, 4], "a": [1.0, 2.0, 3.0, 4.0], "b": values, "verified": flags}, {"b": "K"})
    count = {"fraction": 0.5, "lower": None, "upper": 2.5}
    figure = points(table, {"parameters": [{"name": "a"}], "criteria": {"b": count}}, None, None)
    figure.savefig(tmp_path / "picture.png")
    assert labels(figure)[0] == ("a", "b [K]")


def test_many_points_are_thinned():
    count = 40_001
    numbers = np.linspace(0, 1, count).tolist()
    table = Table({"point": list(range(count)), "a": numbers, "b": numbers, "verified": [x < 0.5 for x in numbers]})
    criterion = {"fraction": 0.5, "lower": None, "upper": 0.5}
    figure = points(table, {"parameters": [{"name": "a"}], "criteria": {"b": criterion}}, None, None)
    assert "one of 3" in figure.get_suptitle()
    drawn = [len(marks.get_offsets()) for marks in figure.axes[0].collections]
    assert max(drawn) < 7000 and sum(bar.get_height() for bar in figure.axes[1].patches if bar.get_width() < 0.1) == count


def test_sensitivities(verified, tmp_path):
    study = Study.load(PAPER)
    with pytest.raises(OrchestratorError, match="holds no indices"):
        verified.plot_sensitivity()
    sobol = study.sensitivity(base=8, output=tmp_path / "sobol")
    assert {name for name, _ in labels(sobol.plot())} == {"Sobol index (95 % intervals)"}
    assert [axes.get_title() for axes in sobol.plot().axes] == [*study.criteria, "verified"]
    units = sobol.runs.units
    assert units["bearing.radialClearance"] == "mm" and units == {name: verified.points.units[name] for name in units}
    morris = study.sensitivity(morris=4, output=tmp_path / "morris")
    assert labels(morris.plot())[0][0] == "Morris' mean effect [degC] (95 % intervals)"
    assert "<img" in sobol._repr_html_()


IDENTIFY = """
fmu = "functions.fmu"
[identify.free.x1]
min = 0.5
max = 2
scale = "log"
[identify.free.x2]
min = "0.5"
max = "2"
unit = "1"
[identify.measured.P]
variable = "product"
value = 1.0
accuracy = 0.1
"""


def test_a_posterior_is_a_table_with_a_picture(tmp_path):
    pack(tmp_path, 2, "product")
    study = Study(IDENTIFY, folder=tmp_path)
    found = study.identify(posterior=200, output=tmp_path / "found", jobs=1, isolation="none")
    assert len(found.posterior) == 200 and found.posterior.to_pandas()["x1"].between(0.5, 2).all()
    assert found.posterior.units == {one["name"]: one["unit"] for one in found.data["free"] if one["unit"] not in (None, "1")}
    names = {name for pair in labels(found.plot()) for name in pair}
    assert names == {"sets", *map(found.posterior.label, ["x1", "x2"])}
    plain = study.identify(output=tmp_path / "plain")
    assert [name for name, _ in labels(plain.plot())] == ["x1", "x2"]
    with pytest.raises(OrchestratorError, match=r"identify\(posterior=1000\)"):
        Identification(plain.folder).posterior  # noqa: B018


@pytest.mark.parametrize("metric, unit, shown, values", [("nrmse", None, "K", 355), ("rmse", "degC", "degC", 82)])
def test_curves_have_the_unit_in_which_they_are_kept(metric, unit, shown, values, fmu, tmp_path):
    curve = {"variable": "sensor.bearingTemperature", "metric": metric, "tolerance": 5,
             "reference": {"file": {"t": [0, 1], "T": [82, 82.5]}, "time": "t", "column": "T", "unit": "degC"}}
    clearance = {"distribution": "uniform", "min": 18, "max": 22, "unit": "um"}
    result = Study({"fmu": fmu, "simulation": {"stop": 1, "step": 1}, "design": {"method": "sobol", "points": 2},
                    "parameters": {"bearing.radialClearance": clearance},
                    "criteria": {"T": {**curve, **({"unit": unit} if unit else {})}}}).verify(output=tmp_path)
    assert result.curves["value"][0] == pytest.approx(values, abs=1)
    figure = result.plot_curves()
    assert labels(figure) == [("time [s]", f"sensor.bearingTemperature [{shown}]")]
    # The nearest point and the measured curve are in the same unit.
    assert [line.get_ydata()[0] for line in figure.axes[0].lines] == pytest.approx([values] * 2, abs=1)
    assert result.points.units.get("T") == unit
    assert result.plot().axes[1].get_xlabel() == (f"{metric} of T [{unit}]" if unit else f"{metric} of T")


def test_tables_have_units(verified):
    table = verified.points
    assert table.units["T_bearing"] == "degC" and "verified" not in table.units
    assert "T_bearing [degC]" in repr(table) and "T_bearing [degC]" in table._repr_html_()
    frame = table.to_pandas()
    assert frame.attrs["units"] == table.units and frame["verified"].dtype == bool and frame["status"].iloc[0] == "ok"
    assert frame["F_N"].tolist() == list(table["F_N"]) and frame["point"].tolist() == list(range(1, 61))
    assert verified.replay(1).units["sensor.bearingTemperature"] == "K" and verified.replay(1).units["time"] == "s"


def test_no_library_takes_names_for_values(verified):
    for take in (pandas.DataFrame, np.asarray):
        with pytest.raises(TypeError, match="to_pandas"):
            take(verified.points)


def test_a_notebook_shows_verdict_warnings_pictures_page(verified):
    html = Verification.load(verified.folder)._repr_html_()
    root = xml.etree.ElementTree.fromstring(f"<div>{html}</div>")
    warnings = [f"{one['text']}. {one['remedy']}" for one in verified.summary["concerns"] if one["severity"] == "warning"]
    assert [item.text for item in root.iter("li")] == warnings and warnings
    order = [html.index(part) for part in (verified.verdict.words[1:], "<li>", "data:image/png", "report.html")]
    assert order == sorted(order)
    # Warnings are as large as the verdict, which has the colour of doubt.
    assert "size" not in html and COLOURS["inconclusive"] in html and COLOURS["verified"] not in html


def test_a_printed_result_has_the_sign_of_the_terminal(verified):
    assert str(verified) == verified.text.rstrip() and str(verified).startswith("! Verified, with doubts\n")
    headline, *doubts = str(Verification.load(verified.folder)).splitlines()
    assert headline == "! Verified by the one-point rule: 12 of 60 points, with doubts." and f"<Verification: {headline[:-1]};" in repr(verified)
    assert doubts and all(doubt.startswith("warning: ") for doubt in doubts)
    sure = {**verified.summary, "concerns": [], "risk": None}
    assert headline_of(sure)[0] == "✓" and headline_of({**sure, "audit_mismatches": 1})[0] == "!"
    for verdict, sign in [("not verified", "✗"), ("inconclusive", "?")]:
        assert headline_of({**verified.summary, "verdict": verdict})[0] == sign
    name, criterion = next(iter(sure["criteria"].items()))
    assert headline_of({**sure, "criteria": {name: {**criterion, "nominal_from": "model"}}})[0] == "?"


SCREEN = """! Verified, with doubts
Asked    Does the model meet all
         2 criteria?
Answer   It does at 1 < 2 points.

F  rmse at most 20 N
"""


def test_a_notebook_shows_the_first_screen_of_the_terminal(verified):
    html = verification(verified.summary, SCREEN, [], verified.report)
    root = xml.etree.ElementTree.fromstring(f"<div>{html}</div>")
    told = ["".join(part.itertext()) for part in root.iter("p")]
    assert told[1:4] == ["! Verified, with doubts", "Asked Does the model meet all 2 criteria?", "Answer It does at 1 < 2 points."]
    assert COLOURS["inconclusive"] in html and "rmse at most 20 N" not in html


def test_pictures_are_figures_that_notebooks_show(verified):
    figure = verified.plot()
    assert isinstance(figure, matplotlib.figure.Figure) and figure._repr_png_().startswith(b"\x89PNG")


WITHOUT = """
import sys
sys.modules["matplotlib"] = sys.modules["numpy"] = None
from fmu_orchestrator import OrchestratorError, Verification
result = Verification.load(sys.argv[1])
assert "<img" not in result._repr_html_() and "fmu-orchestrator[plot]" in result._repr_html_() and "report.html" in result._repr_html_()
try:
    result.plot()
except OrchestratorError as error:
    print(error)
"""


def test_without_matplotlib_the_extra_is_named(verified):
    done = subprocess.run([sys.executable, "-c", WITHOUT, verified.folder], env=ENVIRONMENT, capture_output=True, text=True)
    assert done.stdout.strip() == "pictures need matplotlib: pip install 'fmu-orchestrator[plot]'", done.stderr


def test_windows_of_pyplot_hold_the_pictures(verified):
    """Where the user shows windows, the picture is one of them; with the back ends of files it is not."""
    code = ("import sys, matplotlib; matplotlib.use('webagg'); import matplotlib.pyplot as p; from fmu_orchestrator import Verification;"
            "Verification.load(sys.argv[1]).plot(); print(len(p.get_fignums())); matplotlib.use('agg');"
            "Verification.load(sys.argv[1]).plot(); print(len(p.get_fignums()))")
    done = subprocess.run([sys.executable, "-c", code, verified.folder], env=ENVIRONMENT, capture_output=True, text=True)
    assert done.stdout.split() == ["1", "1"], done.stderr
    assert Verification.load(verified.folder).verdict == verified.verdict
