"""The Python package: its results are the command line's, to the last bit, and other libraries take them."""

import inspect
import json
import os
import re
import signal
import subprocess
import sys
import time
import warnings
from pathlib import Path

import numpy as np
import openturns as ot
import pandas
import polars
import pyarrow
import pytest
import scipy.optimize
from SALib.sample import latin
from test_acceptance import PROGRAM, ROOT, TABLE3, rows

os.environ["FMU_ORCHESTRATOR_PROGRAM"] = str(PROGRAM)
sys.path.insert(0, str(ROOT / "python"))
import fmu_orchestrator  # noqa: E402
from fmu_orchestrator import (  # noqa: E402
    Interrupted, OrchestratorError, OrchestratorWarning, Study, Verification, _arrow)
from fmu_orchestrator._progress import Journal  # noqa: E402
from fmu_orchestrator._study import Running  # noqa: E402
from fmu_orchestrator._table import parse  # noqa: E402

PAPER = ROOT / "studies" / "paper-table3.toml"
# How a run went; all else is the same for every run.
RUN = ["run", "isolation", "audits", "audits_of_shared", "audit_mismatches", "reproducibility"]


def command(*arguments, folder=ROOT):
    return subprocess.run([PROGRAM, *map(str, arguments)], cwd=folder, capture_output=True, text=True)


def same(ours, theirs):
    def summary(folder):
        found = json.loads((folder / "summary.json").read_text())
        return {key: value for key, value in found.items() if key not in RUN}

    assert (ours / "points.csv").read_bytes() == (theirs / "points.csv").read_bytes()
    assert summary(ours) == summary(theirs)


@pytest.fixture(scope="module")
def verified(tmp_path_factory):
    folder = tmp_path_factory.mktemp("verified")
    return Study.load(PAPER).verify(points=60, seed=5, output=folder / "ours")


def test_a_verification_is_the_command_lines(verified, tmp_path):
    done = command("verify", PAPER, "--points", 60, "--seed", 5, "--output", tmp_path)
    same(verified.folder, tmp_path)
    assert verified.text.replace(str(verified.folder), "") == done.stdout.replace(str(tmp_path), "")
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
    assert verdict.rule == "one point" and verdict.required is None and str(verdict) == summary["verdict_words"]
    assert verdict.risks.consumer == summary["risk"]["consumer"]
    assert Verification.load(verified.folder).verdict == verdict


def test_a_notebook_shows_verdict_and_report(verified):
    html = verified._repr_html_()
    assert verified.verdict.words in html and "iframe srcdoc" in html
    # The page is in the frame as a whole: its last words, escaped.
    assert "&lt;/html&gt;" in html


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
    said = command("judge", study, TABLE3).stderr.splitlines()
    remarks = [line.partition(": ")[2] for line in said if line.startswith(("warning: ", "note: "))]
    assert "T_oil: the uncertainty 0.7 degC" in remarks[0]
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        Study.load(study).judge(TABLE3)
    assert [str(warning.message) for warning in caught if warning.category is OrchestratorWarning] == remarks


def test_sensitivity_is_the_command_lines(verified, tmp_path):
    study = Study.load(PAPER)
    ours = study.sensitivity(base=16, output=tmp_path / "ours")
    command("sensitivity", PAPER, "--base", 16, "--output", tmp_path / "theirs")
    theirs = tmp_path / "theirs"
    assert ours.data == json.loads((theirs / "sensitivity.json").read_text())
    assert (ours.folder / "sensitivity-runs.csv").read_bytes() == (theirs / "sensitivity-runs.csv").read_bytes()
    assert len(ours.runs) == ours.data["runs"] and ours.parameters == study.parameters
    total = ours.indices("T_bearing")
    assert max(total, key=total.get) == ours.dominant["T_bearing"] == "bearing.radialClearance"
    existing = study.sensitivity(points_of=verified)
    assert existing.folder == verified.folder and existing.outputs["F_N"]["pawn"] is not None
    with pytest.raises(OrchestratorError, match="no Sobol indices"):
        existing.indices("F_N")


@pytest.mark.parametrize("name, options", [
    ("robustness", {"level": 0.5, "confirm": 4, "seed": 3}), ("pareto", {"seed": 2}),
    ("pareto", {"generations": 2, "population": 6})])
def test_other_analyses_are_the_command_lines(name, options, verified, tmp_path):
    existing = {} if "generations" in options else {"points_of": verified}
    ours = getattr(Study.load(PAPER), name)(**existing, **options, output=tmp_path / "ours")
    flags = [f"--{key}={value}" for key, value in options.items()]
    flags += [f"--from={verified.folder}"] if existing else []
    done = command(name, PAPER, *flags, "--output", tmp_path / "theirs")
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
    run = fmu_orchestrator.simulate(fmu, stop=3, step=1, inputs=speed, record=["drive.angle"])
    turns = np.diff(run["drive.angle"]) / (2 * np.pi)
    assert turns == pytest.approx([5, 5, 10], rel=1e-9)


def test_an_fmu_is_inspected_and_checked(fmu, tmp_path):
    assert "linux64" in fmu_orchestrator.inspect(fmu)["platforms"]
    assert fmu_orchestrator.check(fmu).passed and fmu_orchestrator.check(fmu).findings == ()
    import zipfile
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


def test_libraries_take_tables_as_they_are():
    values = np.linspace(0, 1, 21)
    cells = ((k + 1, x, "" if k % 3 else x, str(k % 2 == 0).lower(), f"'=µ{k}") for k, x in enumerate(values.tolist()))
    lines = ["point,x,gap,flag,status", *(",".join(map(str, row)) for row in cells)]
    table = parse(iter(lines), ["count", "number", "number", "flag", "text"])
    arrow = pyarrow.table(table)
    arrow.validate(full=True)
    assert [str(kind) for kind in arrow.schema.types] == ["int64", "double", "double", "bool", "string"]
    assert arrow["gap"].null_count == 14 and arrow["status"][20].as_py() == "=µ20"
    # Numbers are not copied.
    assert arrow["x"].chunk(0).buffers()[1].address == table["x"].buffer_info()[0]
    for frame in [pandas.DataFrame.from_arrow(table), polars.DataFrame(table)]:
        assert frame["x"].to_list() == values.tolist() and frame["flag"].to_list() == [k % 2 == 0 for k in range(21)]
        assert list(frame["point"]) == list(range(1, 22))
    assert polars.DataFrame(table)["gap"].null_count() == 14
    assert np.isnan(table.to_numpy(["x", "gap"])[:, 1]).sum() == 14
    with pytest.raises(KeyError, match="there are point, x"):
        table["y"]


@pytest.mark.parametrize("rows", [0, 1, 8, 9, 30])
def test_tables_of_any_length(rows):
    flags = [k % 3 == 1 for k in range(rows)]
    text = ["a,b,c\n", *(f"{k},{str(flag).lower()},{'x' * k}\n" for k, flag in enumerate(flags))]
    arrow = pyarrow.table(parse(iter(text), ["number", "flag", "text"]))
    arrow.validate(full=True)
    assert arrow.num_rows == rows and arrow["c"].to_pylist() == ["x" * k for k in range(rows)]
    assert arrow["b"].to_pylist() == flags


def test_what_others_have_taken_is_released():
    table = parse(iter(["a,b\n", "1,x\n", "2,y\n"]))
    kept = pyarrow.table(table)["b"]
    unused = table.__arrow_c_stream__()
    assert _arrow._alive
    del unused
    # A column outlives the table that it came from.
    assert kept.to_pylist() == ["x", "y"]
    del kept
    assert not _arrow._alive and not _arrow._streams


def test_a_function_of_arrays(verified):
    study = Study.load(PAPER)
    f = study.function()
    x = verified.points.to_numpy(f.inputs)
    assert f.inputs == study.parameters and f.outputs == study.criteria
    assert np.array_equal(f(x), verified.points.to_numpy(f.outputs))
    assert np.array_equal(f(x[3]), verified.points.to_numpy(f.outputs)[3])
    assert f(np.empty((0, 7))).shape == (0, 4)
    with pytest.raises(ValueError, match="its columns are bearing.radialClearance"):
        f(x[:, :3])


def test_some_inputs_and_one_output(verified):
    study = Study.load(PAPER)
    row = dict(zip(study.parameters, verified.points.to_numpy(study.parameters)[0], strict=True))
    names = ["load.preload", "bearing.radialClearance"]
    f = study.function(names, "P_fr", others={name: value for name, value in row.items() if name not in names})
    assert f([row[name] for name in names]) == verified.points["P_fr"][0]
    # No film fits into a gap that is none: the point has no result, the others do.
    found = f([[48.0, -1.0], [48.0, 0.02]])
    assert np.isnan(found[0]) and found[1] > 0
    for mistake, says in [(lambda: study.function(["load.prelaod"]), "no parameter `load.prelaod`"),
                          (lambda: study.function(names), "give `others` values for load.stiffness"),
                          (lambda: study.function(outputs="P"), "no criterion `P`")]:
        with pytest.raises(OrchestratorError, match=says):
            mistake()


def test_other_libraries_call_it(verified):
    """SALib's samples, OpenTURNS' functions, scipy's searches."""
    study = Study.load(PAPER)
    others = {name: verified.points[name][0] for name in study.parameters if name != "bearing.radialClearance"}
    f = study.function(outputs=["P_fr"], others=others)
    x = latin.sample({"num_vars": 1, "names": f.inputs, "bounds": [[0.015, 0.025]]}, 6, seed=1)
    y = f(x)
    model = ot.PythonFunction(1, 1, func_sample=f)
    assert np.array_equal(np.array(model(ot.Sample(x))), y)
    one = study.function(outputs="P_fr", others=others)
    low, high = x[y[:, 0].argmax()], x[y[:, 0].argmin()]
    middle = (one(low) + one(high)) / 2
    root = scipy.optimize.brentq(lambda clearance: one([clearance]) - middle, *sorted([low[0], high[0]]), xtol=1e-6)
    assert one([root]) == pytest.approx(middle, rel=1e-3)


def test_points_are_given_as_any_table(verified, tmp_path):
    study = Study.load(PAPER)
    frame = pandas.DataFrame.from_arrow(verified.points).head(5)
    for name, table in [("pandas", frame), ("arrow", pyarrow.table(verified.points).slice(0, 5)),
                        ("mapping", {name: frame[name].tolist() for name in study.parameters})]:
        found = study.verify(points_from=table, output=tmp_path / name)
        assert found.points.to_numpy(study.criteria).tolist() == frame[study.criteria].to_numpy().tolist(), name


LONG = """
fmu = "{fmu}"
[simulation]
stop = 10
step = 0.001
[design]
method = "halton"
points = {points}
[parameters."bearing.radialClearance"]
distribution = "normal"
mean = 0.02
deviation = 0.002
unit = "mm"
[criteria.P]
variable = "sensor.frictionPower"
statistic = "mean"
nominal = 14
tolerance = "50 %"
"""
RUNNER = """
import sys
from fmu_orchestrator import Interrupted, Study
try:
    Study.load(sys.argv[1]).verify(output=sys.argv[2], jobs=2)
except Interrupted as stop:
    print(stop)
    sys.exit(77)
"""


def interrupt(arguments, journal, send):
    """Sends Ctrl-C when points are done."""
    process = subprocess.Popen([sys.executable, "-c", RUNNER, *map(str, arguments)], stdout=subprocess.PIPE, text=True,
                               env={**os.environ, "PYTHONPATH": str(ROOT / "python")}, start_new_session=True)
    end = time.monotonic() + 60
    while time.monotonic() < end and process.poll() is None:
        if journal.is_file() and journal.read_bytes().count(b"\n") > 3:
            send(process.pid, signal.SIGINT)
            break
        time.sleep(0.005)
    said, _ = process.communicate(timeout=60)
    return process, said


def session(leader):
    """The processes of a session."""
    found = []
    for entry in Path("/proc").iterdir():
        try:
            # What follows the name in brackets: state, parent, group, session.
            if entry.name.isdigit() and int((entry / "stat").read_text().rpartition(")")[2].split()[3]) == leader:
                found.append(entry.name)
        except OSError:  # gone meanwhile
            continue
    return found


# A notebook's stop may reach Python alone; on a terminal Ctrl-C reaches the program, too.
@pytest.mark.parametrize("send", [os.kill, os.killpg])
def test_ctrl_c_keeps_what_is_done(send, fmu, tmp_path):
    study = tmp_path / "study.toml"
    study.write_text(LONG.format(fmu=fmu, points=40))
    folder = tmp_path / "out"
    process, said = interrupt([study, folder], folder / "journal.txt", send)
    assert process.returncode == 77 and said.strip() == f"interrupted; resume=True goes on in {folder}"
    # Nothing of the run is left: neither its processes, which belong to its session, nor its folders.
    assert session(process.pid) == []
    assert not list(folder.glob(".running-*"))
    done = Journal(folder, resume=True)
    assert done.look() and 0 < done.done < 40 and done.total == 40
    with pytest.raises(OrchestratorError, match="--resume"):
        Study.load(study).verify(output=folder)
    whole = Study.load(study).verify(output=folder, resume=True)
    assert whole.summary["run"]["computed"] == 40 - done.done
    same(folder, Study.load(study).verify(output=tmp_path / "whole").folder)


def test_progress_is_told(fmu, tmp_path, monkeypatch):
    monkeypatch.setattr("fmu_orchestrator._progress.QUIET", 0.0)
    monkeypatch.setattr("fmu_orchestrator._program.GLANCE", 0.01)
    study = tmp_path / "study.toml"
    study.write_text(LONG.format(fmu=fmu, points=20))
    told = []
    for attempt in range(2):
        told.clear()
        Study.load(study).verify(output=tmp_path / "out", progress=lambda *counts: told.append(counts))
        # The second run replaces the journal that is there, and does not begin with its 20 points.
        assert told and told[0][0] < 20 and {total for _, total in told} == {20}
        assert [done for done, _ in told] == sorted(done for done, _ in told)
    journal = Journal(tmp_path / "out", resume=True)
    assert journal.look() and journal.done == 20


def test_the_command_finds_the_packages_studies(tmp_path):
    environment = {**os.environ, "PYTHONPATH": str(ROOT / "python")}
    call = [sys.executable, "-m", "fmu_orchestrator"]
    done = subprocess.run([*call, "verify", "paper-table3", "--points", "3", "--seed", "2"], cwd=tmp_path,
                          env=environment, capture_output=True, text=True)
    assert done.returncode in (0, 1) and (tmp_path / "results/paper-table3/report.html").is_file(), done.stderr
    # A file of the user's own comes first, and other commands' arguments stay as they are.
    (tmp_path / "rig").write_text("none")
    for arguments in [["verify", "rig"], ["check", "paper-table3"]]:
        done = subprocess.run([*call, *arguments], cwd=tmp_path, env=environment, capture_output=True, text=True)
        assert done.returncode == 2 and done.stderr.startswith(f"error: {arguments[1]}"), done.stderr
    missing = {**environment, "FMU_ORCHESTRATOR_PROGRAM": str(tmp_path / "none")}
    done = subprocess.run([*call, "--help"], env=missing, capture_output=True, text=True)
    assert done.returncode == 2 and "there is no program" in done.stderr


# What Python has in other ways: files of its own, results that are read, functions.
OTHERWISE = {"help", "output", "from", "shard", "dry-run", "parquet", "png"}


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
