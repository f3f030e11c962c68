"""The Python package: its results are the command line's, to the last bit."""

import inspect
import json
import re
import subprocess
import sys
import warnings
import zipfile

import numpy as np
import pandas
import polars
import pytest
from python_package import PAPER, command, same
from test_acceptance import ROOT, TABLE3, rows

import fmu_orchestrator
from fmu_orchestrator import OrchestratorError, OrchestratorWarning, Study, Verification
from fmu_orchestrator._study import Running


def test_a_verification_is_the_command_lines(verified, tmp_path):
    done = command("verify", PAPER, "--points", 60, "--seed", 5, "--output", tmp_path)
    same(verified.folder, tmp_path)

    def told(text, folder):
        # How much later points ran again depends on the machine.
        return [line.replace(str(folder), "") for line in text.splitlines() if " ran again, " not in line]

    assert told(verified.text, verified.folder) == told(done.stdout, tmp_path)
    assert done.returncode == 0 and verified.verdict.name == "verified"
    header, *lines = (tmp_path / "points.csv").read_text().splitlines()
    for place, name in enumerate(header.split(",")[:12]):
        printed = [float(line.split(",")[place]) for line in lines]
        assert list(verified.points[name]) == printed, name


def test_the_verdict_is_the_summarys(verified):
    verdict, summary = verified.verdict, verified.summary
    points = verified.points
    assert verdict.verified == sum(points["verified"]) == sum(
        all(row[f"{name}.ok"] for name in summary["criteria"]) for row in points.rows())
    assert verdict.share == verdict.verified / verdict.points and verdict.interval[0] < verdict.share < verdict.interval[1]
    assert verdict.shares["P_fr"] == sum(points["P_fr.ok"]) / 60
    assert verdict.rule == "one point" and verdict.required is None and verdict.doubtful
    assert str(verdict) == f"{summary['verdict_words']}, with doubts"
    assert verdict.risks.consumer == summary["risk"]["consumer"]
    assert Verification.load(verified.folder).verdict == verdict


def test_results_of_an_earlier_version(verified, tmp_path):
    summary = {key: value for key, value in verified.summary.items() if key != "verdict"}
    (tmp_path / "summary.json").write_text(json.dumps(summary))
    with pytest.raises(OrchestratorError, match="no 'verdict', as an earlier version wrote it"):
        Verification.load(tmp_path)


@pytest.mark.parametrize("share, exit_code, name", [("90 %", 1, "not verified"), ("20 %", 3, "inconclusive")])
def test_other_verdicts_are_results_too(share, exit_code, name, tmp_path):
    study = tmp_path / "study.toml"
    text = PAPER.read_text().replace("../dist", str(ROOT / "dist"))
    study.write_text(text + f'\n[verdict]\nshare = "{share}"\n')
    result = Study.load(study).verify(output=tmp_path / "out")
    assert command("verify", study, "--output", tmp_path / "theirs").returncode == exit_code
    assert result.verdict.name == name and result.verdict.rule == "share"
    assert result.verdict.required.share == float(share.split()[0]) / 100
    assert (result.verdict.required.points_needed is not None) == (name == "inconclusive")


def test_a_judgement_takes_files_and_tables(tmp_path):
    study = Study.load(PAPER)
    of_file = study.judge(TABLE3)
    of_frame = study.judge(pandas.read_csv(TABLE3))
    of_arrow = study.judge(polars.read_csv(TABLE3), output=tmp_path)
    # The paper's own count by the tolerances as printed.
    assert of_file.verdict.verified == 9 and of_file.report.is_file()
    assert of_file.verdict == of_frame.verdict == of_arrow.verdict
    assert dict(of_file.points) == dict(of_frame.points) == dict(of_arrow.points)
    folder = of_file.folder
    assert folder.is_dir() and of_arrow.folder == tmp_path
    del of_file
    assert not folder.exists()


def test_the_message_is_the_command_lines(tmp_path):
    study = tmp_path / "study.toml"
    study.write_text(PAPER.read_text().replace('"load.preload"', '"load.prelaod"').replace("../dist", str(ROOT / "dist")))
    with pytest.raises(OrchestratorError) as error:
        Study.load(study).verify(output=tmp_path / "out")
    assert command("verify", study).stderr.splitlines()[-1] == f"error: {error.value}"
    assert "did you mean `load.preload`?" in str(error.value)
    for mistake in [lambda: Study.load(tmp_path / "none.toml"), lambda: fmu_orchestrator.inspect(tmp_path / "none.fmu"),
                    lambda: Verification.load(tmp_path), lambda: Study.load(PAPER).verify(points=-1)]:
        with pytest.raises(OrchestratorError) as error:
            mistake()
        assert "\n" not in str(error.value)


def test_remarks_are_warnings(tmp_path):
    study = tmp_path / "study.toml"
    # A sensor that is worse than what it is to decide on.
    text = PAPER.read_text().replace("../dist", str(ROOT / "dist"))
    study.write_text(text.replace('uncertainty = "0.5 degC"', 'uncertainty = "0.7 degC"'))
    said = command("verify", study, "--points", 4, "--output", tmp_path / "theirs").stderr.splitlines()
    remarks = [line.partition(": ")[2] for line in said if line.startswith(("warning: ", "note: "))]
    assert "T_oil: the uncertainty 0.7 degC" in remarks[0]
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        result = Study.load(study).verify(points=4, output=tmp_path / "ours")
    assert all(isinstance(value, float) and 0 <= value <= 1 for value in result.points["conformance"])
    ours = [warning for warning in caught if warning.category is OrchestratorWarning]
    said = [str(warning.message) for warning in ours]
    assert said[: len(remarks)] == remarks and {warning.filename for warning in ours} == {__file__}
    # Doubts that only the result shows follow; each is told once.
    doubts = [concern["text"] for concern in result.summary["concerns"] if concern["severity"] == "warning"]
    assert all(sum(doubt in one for one in said) == 1 for doubt in doubts)
    # The best point is run once more within two seconds, which a busy machine may not have; the result says so then.
    assert len(doubts) > 1 or result.summary.get("left_out")


def test_sensitivity_is_the_command_lines(tmp_path):
    study = Study.load(PAPER)
    ours = study.sensitivity(base=64, output=tmp_path / "ours")
    command("sensitivity", PAPER, "--base", 64, "--output", tmp_path / "theirs")
    theirs = tmp_path / "theirs"
    assert ours.data == json.loads((theirs / "sensitivity.json").read_text())
    assert (ours.folder / "sensitivity-runs.csv").read_bytes() == (theirs / "sensitivity-runs.csv").read_bytes()
    assert len(ours.runs) == ours.data["runs"] and ours.parameters == study.parameters
    total = ours.indices("T_bearing")
    assert max(total, key=total.get) == ours.dominant["T_bearing"] == "bearing.radialClearance"
    with pytest.raises(OrchestratorError, match="no Sobol indices"):
        study.sensitivity(morris=4, output=tmp_path / "morris").indices("F_N")


SMALL = """
fmu = "{fmu}"
[simulation]
stop = 1
step = 1
[design]
points = 24
seed = 5
[parameters."bearing.radialClearance"]
distribution = "normal"
mean = 0.02
deviation = 0.002
unit = "mm"
[parameters."load.preload"]
distribution = "uniform"
min = 45
max = 51
unit = "N"
[criteria.F_N]
variable = "sensor.loadForceMean"
nominal = 750
tolerance = "2 %"
unit = "N"
[criteria.P_fr]
variable = "sensor.frictionPowerMean"
nominal = 14
tolerance = "20 %"
unit = "W"
"""


@pytest.fixture(scope="module")
def small(fmu, tmp_path_factory):
    """A study of two parameters and two criteria, with which an analysis is done soon, and its verification."""
    file = tmp_path_factory.mktemp("small") / "study.toml"
    file.write_text(SMALL.format(fmu=fmu))
    return file, Study.load(file).verify(output=file.parent / "verified")


def test_analyses_take_points_of_a_study(small, tmp_path):
    file, verified = small
    study = Study.load(file)
    ours = study.sensitivity(points_of=verified, output=tmp_path / "ours")
    command("sensitivity", file, "--from", verified.folder, "--output", tmp_path / "theirs")
    assert ours.data == json.loads((tmp_path / "theirs" / "sensitivity.json").read_text()) and ours.data["runs"] == 24
    with pytest.raises(OrchestratorError, match="--budget"):
        study.sensitivity(points_of=verified, budget=80)
    for options, told in [({}, "needs budget=N"), ({"budget": 20, "output": tmp_path / "other"}, "leave output out")]:
        with pytest.raises(OrchestratorError, match=told):
            study.identify(points_of=verified, **options)


@pytest.mark.parametrize("name, options", [
    ("robustness", {"level": 0.5, "confirm": 4, "seed": 3}), ("pareto", {})])
def test_other_analyses_are_the_command_lines(name, options, small, tmp_path):
    file, verified = small
    ours = getattr(Study.load(file), name)(points_of=verified, **options, output=tmp_path / "ours")
    flags = [f"--{key}={value}" for key, value in options.items()] + [f"--from={verified.folder}"]
    done = command(name, file, *flags, "--output", tmp_path / "theirs")
    assert ours.data == json.loads((tmp_path / "theirs" / f"{name}.json").read_text())
    assert ours.text.replace(str(ours.folder), "") == done.stdout.replace(str(tmp_path / "theirs"), "")


def test_tolerances_are_the_command_lines(tmp_path):
    study = tmp_path / "study.toml"
    study.write_text(PAPER.read_text().replace("../dist", str(ROOT / "dist")) + '\n[tolerances]\nshare = "30 %"\n')
    ours = Study.load(study).tolerances(points=64, confirm=16, output=tmp_path / "ours")
    command("tolerances", study, "--points", 64, "--confirm", 16, "--output", tmp_path / "theirs")
    assert ours.data == json.loads((tmp_path / "theirs" / "tolerances.json").read_text())


IDENTIFY = """
fmu = "{fmu}"
[simulation]
stop = 1
step = 1
[identify]
starts = 4
descents = 1
[identify.free."oil.viscosityScale"]
min = 1
max = 100
scale = "log"
[identify.measured.P]
variable = "sensor.frictionPower"
value = "14 W"
accuracy = "1 %"
"""


def test_an_identification_is_the_command_lines(fmu, tmp_path):
    study = tmp_path / "study.toml"
    study.write_text(IDENTIFY.format(fmu=fmu))
    ours = Study.load(study).identify(output=tmp_path / "ours")
    done = command("identify", study, "--output", tmp_path / "theirs")
    assert ours.data == json.loads((tmp_path / "theirs" / "identification.json").read_text())
    assert ours.converged == (done.returncode == 0)
    found = ours.parameters["oil.viscosityScale"]
    assert found.interval[0] < found.value < found.interval[1]
    assert ours.optima[0].parameters == ours.parameters
    assert ours.causes == ours.data["causes"]
    assert sum(optimum.weight for optimum in ours.optima) == pytest.approx(1)
    power = fmu_orchestrator.simulate(fmu, {"oil.viscosityScale": found.value}, stop=1, step=1)["sensor.frictionPower"]
    assert power[-1] == pytest.approx(14, rel=0.01)


def test_a_simulation_is_the_command_lines(fmu, tmp_path):
    command("simulate", fmu, "--stop", 2, "--step", 0.5, "--set", "bearing.radialClearance=18 um", "--output",
            tmp_path / "run.csv")
    theirs = rows(tmp_path / "run.csv")
    ours = fmu_orchestrator.simulate(fmu, {"bearing.radialClearance": "18 um"}, stop=2, step=0.5)
    assert ours.names == list(theirs[0]) and len(theirs) == 5
    assert list(ours.rows()) == [{name: float(cell) for name, cell in row.items()} for row in theirs]
    exact = fmu_orchestrator.simulate(fmu, {"bearing.radialClearance": np.float64(18e-6), "thermal.isothermal": True},
                                      stop=1, step=1, record=["sensor.oilTemperature"])
    assert exact.names == ["time", "sensor.oilTemperature"] and exact["time"].tolist() == [0.0, 1.0]
    assert exact["sensor.oilTemperature"][0] == exact["sensor.oilTemperature"][1]


def test_inputs_over_time(fmu):
    speed = {"time": [0.0, 1.0, 2.0], "drive.speed [rpm]": [300.0, 300.0, 600.0]}
    run = fmu_orchestrator.simulate(fmu, stop=3, step=1, inputs=speed, extrapolate="hold", record=["drive.angle"])
    turns = np.diff(run["drive.angle"]) / (2 * np.pi)
    assert turns == pytest.approx([5, 5, 10], rel=1e-9)


def test_an_fmu_is_inspected_and_checked(fmu, tmp_path):
    assert "linux64" in fmu_orchestrator.inspect(fmu)["platforms"]
    clean = fmu_orchestrator.check(fmu)
    assert clean.passed and clean.findings == () and clean.data == json.loads(command("check", fmu, "--format", "json").stdout)
    broken = tmp_path / "broken.fmu"
    with zipfile.ZipFile(fmu) as source, zipfile.ZipFile(broken, "w") as target:
        for name in source.namelist():
            content = source.read(name)
            target.writestr(name, content.replace(b'fmiVersion="2.0"', b'fmiVersion="2.5"'))
    found = fmu_orchestrator.check(broken)
    assert not found.passed and found.findings[0].severity == "error" and found.findings[0].message in found._repr_html_()


def test_a_point_is_replayed(verified, tmp_path):
    command("replay", verified.folder, 7, "--output", tmp_path / "theirs.csv")
    ours = verified.replay(7)
    assert (verified.folder / "point-7.csv").read_bytes() == (tmp_path / "theirs.csv").read_bytes()
    assert ours["time"][-1] == 150.0
    # What the package itself gives names a point, too.
    best = verified.best_point
    for point in [best, best["point"], float(best["point"]), np.int64(best["point"]), verified.points["point"][best["point"] - 1]]:
        assert verified.replay(point)["time"][-1] == 150.0
    for point in ["7", 7.5, {"parameters": {}}, None]:
        with pytest.raises(OrchestratorError, match="no number of a point"):
            verified.replay(point)


# What Python has in other ways: files of its own, results that are read, functions. The search for rare shares has results of
# its own, and the command line alone runs it so far, as it does what serves build servers and a study that an FMU carries.
OTHERWISE = {"help", "output", "from", "shard", "shard-index", "shards", "dry-run", "parquet", "rare",
             "junit", "strict", "study", "verbose"}


@pytest.mark.parametrize("name", ["verify", "judge", "sensitivity", "robustness", "tolerances", "pareto", "identify"])
def test_no_option_of_the_command_line_is_missing(name):
    options = set(re.findall(r"^ +(?:-\w, )?--([\w-]+)", command(name, "--help").stdout, re.MULTILINE)) - OTHERWISE
    method = getattr(Study, name)
    known = {*inspect.signature(method).parameters, *Running.__annotations__}
    assert {option.replace("-", "_") for option in options} <= known


def test_the_packages_own_example(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    example = (ROOT / "python" / "README.md").read_text().split("```")[1].removeprefix("python\n")
    found = {}
    exec(example, found)
    assert found["result"].verdict.points == 50 and (tmp_path / "results/paper-table3/report.html").is_file()


def test_types():
    done = subprocess.run([sys.executable, "-m", "mypy", "--strict", "fmu_orchestrator"], cwd=ROOT / "python",
                          capture_output=True, text=True)
    assert done.returncode == 0, done.stdout
