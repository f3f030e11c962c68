"""Studies from dictionaries and TOML, changed, and made from an FMU and measured values."""

import json
import tomllib

import numpy as np
import pandas
import pytest
from python_package import PAPER, command
from test_acceptance import ROOT

from fmu_orchestrator import OrchestratorError, OrchestratorWarning, Study, init, simulate, synchronise
from fmu_orchestrator.__main__ import arguments
from fmu_orchestrator._toml import changed, text

STUDY = {
    "fmu": "dist/PlainBearingStand.fmu",
    "simulation": {"stop": 1, "step": 0.5},
    "design": {"method": "sobol", "points": np.int64(12)},
    "parameters": {"bearing.radialClearance": {"distribution": "uniform", "min": np.float64(0.018), "max": 0.022, "unit": "mm"}},
    "criteria": {"P": {"variable": "sensor.frictionPower", "nominal": 14, "tolerance": "50 %", "unit": "W"}},
}


@pytest.mark.parametrize("content", [
    {"a": "\"quoted\" \\ \n\t\x7f µ", "b": [1, 2.5, "x"], "c": {"d.e": {"f": True}}, "g": [{"h": 1}, {"h": 2, "i": {"j": "k"}}]},
    {"cases": [{"name": "300 rpm", "criteria": {"T": {"window": {"from": 1}}}}], "e": [], "f": {}, "g": [[1, 2], [3]]},
    {"tiny": 1e-12, "large": 1e300, "none": float("inf"), "nested": [{"a": 1}, 2]},
])
def test_toml_is_read_as_it_was_written(content):
    assert tomllib.loads(text(content)) == content


@pytest.mark.parametrize("path", sorted((ROOT / "studies").glob("*.toml")), ids=lambda path: path.stem)
def test_shipped_studies_are_written_as_they_are_read(path):
    content = tomllib.loads(path.read_text())
    assert tomllib.loads(text(content)) == content


def test_every_command_finds_a_shipped_study_by_its_name(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    shipped = str(ROOT / "studies" / "rig.toml")
    for name in ["verify", "pareto", "pack"]:
        assert arguments([name, "rig", "--dry-run"]) == [name, shipped, "--dry-run"]
    for given in [["verify", "--help"], ["check", "rig.fmu"], ["--version"]]:
        assert arguments(given) == given
    (tmp_path / "rig").touch()
    assert arguments(["verify", "rig"]) == ["verify", "rig"]


def test_a_dictionary_runs_as_its_file_does(tmp_path, monkeypatch):
    monkeypatch.chdir(ROOT)
    study = Study(STUDY)
    ours = study.verify(output=tmp_path / "ours")
    file = tmp_path / "study.toml"
    study.save(file)
    command("verify", file, "--output", tmp_path / "theirs")
    assert (ours.folder / "points.csv").read_bytes() == (tmp_path / "theirs/points.csv").read_bytes()
    assert len(ours.points) == 12
    of_text = Study(text(STUDY)).verify(output=tmp_path / "text")
    assert dict(of_text.points) == dict(ours.points)
    # Its files are where they were when it was made.
    monkeypatch.chdir(tmp_path)
    again = study.verify(output=tmp_path / "ours", resume=True)
    assert again.summary["run"]["computed"] == 0
    judged = study.judge(ours.points)
    assert judged.verdict.verified == ours.verdict.verified
    folder = study.verify().folder
    assert folder.parent.name == "results" and folder.name.startswith("study-") and study.verify().folder == folder
    # Its analyses find the points that it ran last.
    assert study.robustness().folder == study.pareto().folder == folder


def test_what_is_changed_runs(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    loaded = Study.load(PAPER)
    first = loaded.verify(points=4, extra_runs=0)
    assert first.folder.name == "paper-table3"
    other = loaded.with_(points=5, seed=3, **{"criteria.T_bearing.nominal": 60})
    assert loaded.content["design"]["points"] == 50 and loaded.content["criteria"]["T_bearing"]["nominal"] == 82
    second = other.verify(extra_runs=0)
    assert second.verdict.shares["T_bearing"] == 0 and second.verdict.points == 5
    assert second.summary["provenance"]["seed"] == 3 and second.folder != first.folder
    loaded["design"]["points"] = 3
    third = loaded.verify(extra_runs=0)
    assert third.verdict.points == 3 and third.folder not in (first.folder, second.folder)
    # Earlier results stay what they are.
    assert len(first.points) == 4 and len(second.points) == 5
    loaded["design"]["points"] = 50
    again = loaded.verify(points=4, extra_runs=0, output="again")
    assert json.loads((again.folder / "request.json").read_text())["study"] == str(PAPER)
    assert dict(again.points) == dict(first.points)
    # The points of a changed study serve its other analyses.
    many = other.with_(points=24)
    third = many.verify(extra_runs=0)
    assert many.pareto(points_of=third).folder == third.folder


def test_a_table_stands_for_a_file(fmu, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    run = simulate(fmu, stop=1, step=0.1, record=["sensor.loadForce"])
    frame = run.to_pandas().rename(columns={"sensor.loadForce": "F"})
    curve = {"variable": "sensor.loadForce", "reference": {"file": frame, "time": "time", "column": "F", "unit": "N"},
             "metric": "rmse", "tolerance": "50 N", "unit": "N"}
    speed = {"file": {"t": [0.0, 1.0], "n": [300.0, 300.0]}, "time": "t", "column": "n", "unit": "rpm"}
    study = Study({**STUDY, "fmu": fmu, "simulation": {"stop": 1, "step": 0.1}, "criteria": {"F": curve}, "inputs": {"drive.speed": speed}})
    result = study.verify()
    assert result.curves["value"].tolist() == frame["F"].tolist() and len(list(result.folder.glob("table-*.csv"))) == 2
    (tmp_path / "saved").mkdir()
    of_file = study.save(tmp_path / "saved/study.toml").verify(output="of-file")
    assert (of_file.folder / "points.csv").read_bytes() == (result.folder / "points.csv").read_bytes()
    # Other values, another folder; a table in the place of a name is seen, too.
    frame["F"] += 100
    assert study.with_(**{"criteria.F.reference.file": frame}).verify().folder != result.folder
    loaded = Study.load(tmp_path / "saved/study.toml")
    loaded["criteria"]["F"]["reference"]["file"] = frame
    assert loaded.verify().verdict.verified == 0 < result.verdict.verified


@pytest.mark.parametrize("changes, expected", [
    ({"criteria.a.b.nominal": 2}, {"criteria": {"a.b": {"nominal": 2}, "a": {"nominal": 0}}}),
    ({"criteria.a.nominal": 2}, {"criteria": {"a.b": {"nominal": 1}, "a": {"nominal": 2}}}),
    ({"criteria.a.window.from": 2}, {"criteria": {"a.b": {"nominal": 1}, "a": {"nominal": 0, "window": {"from": 2}}}}),
    ({'criteria."c.d".nominal': 2}, {"criteria": {"a.b": {"nominal": 1}, "a": {"nominal": 0}, "c.d": {"nominal": 2}}}),
    ({"criteria.a": None, "verdict.share": "5 %"}, {"criteria": {"a.b": {"nominal": 1}}, "verdict": {"share": "5 %"}}),
])
def test_dotted_names(changes, expected):
    assert changed({"criteria": {"a.b": {"nominal": 1}, "a": {"nominal": 0}}}, changes) == expected


def test_a_case_is_found_by_its_name():
    content = {"cases": [{"name": "300 rpm", "fixed": {}}, {"name": "a.b", "fixed": {}}]}
    assert changed(content, {"cases.a.b.fixed": {"x": 1}})["cases"][1]["fixed"] == {"x": 1}
    with pytest.raises(OrchestratorError, match="no case `400 rpm`; there are 300 rpm, a.b"):
        changed(content, {"cases.400 rpm.fixed": {}})


def test_mistakes_are_told_with_a_place_that_is_there(tmp_path, monkeypatch):
    monkeypatch.chdir(ROOT)
    with pytest.raises(OrchestratorError, match="no `stifness` in it; there are bearing.radialClearance"):
        Study(STUDY).with_(**{"parameters.stifness.unit.x": 1})
    with pytest.raises(OrchestratorError, match="Study.load opens a file"):
        Study("my.toml")
    with pytest.raises(OrchestratorError, match="cannot hold"):
        Study({"fmu": object()}).verify(output=tmp_path / "none")
    wrong = Study(STUDY)
    wrong["criteria"]["P"]["nominall"] = 3
    for _ in range(2):
        # Once more, as nothing was run.
        with pytest.raises(OrchestratorError, match="nominall") as error:
            wrong.verify(output=tmp_path / "wrong")
        place, line = str(error.value).split(":")[:2]
        assert "nominall" in (tmp_path / "wrong" / place).read_text().splitlines()[int(line) - 1]
    assert Study(STUDY).verify(output=tmp_path / "wrong").verdict.points == 12


@pytest.mark.parametrize("name, words", [
    ("criteria.P.nominall", "no study has `nominall` there; did you mean `nominal`?"),
    ("verdikt.share", "no study has `verdikt` there; did you mean `verdict`?"),
    ("criteria.PP.nominal", "there is no `PP`; did you mean `P`?"),
    ("criteria.Friction.nominal", "there is no `Friction`; there are P"),
    ("inputs.drive.speed", "there is no `drive`; a name with dots stands in quotes"),
    ("cases.one.fixd", "no study has `fixd` there; did you mean `fixed`?"),
])
def test_misspelt_names_are_refused(name, words):
    study = Study({**STUDY, "cases": [{"name": "one", "fixed": {}}]})
    with pytest.raises(OrchestratorError) as error:
        study.with_(**{name: 3})
    assert str(error.value) == f"{name}: {words}"


def test_new_names_that_a_study_may_have_are_taken():
    news = {"criteria.F.variable": "sensor.loadForce", "criteria.F.at-most": "900 N", "verdict.share": "5 %", 'fixed."load.stiffness"': 90,
            "criteria.P.window.from": "1 s", 'inputs."drive.speed"': {"file": "n.csv"}, "simulation.warm-up": None}
    study = Study(STUDY).with_(**news)
    assert study.criteria == ["P", "F"] and study["inputs"]["drive.speed"]["file"] == "n.csv"


def test_results_of_others_are_not_replaced(tmp_path, monkeypatch):
    monkeypatch.chdir(ROOT)
    file = Study(STUDY).save(tmp_path / "file.toml")
    kept = file.verify(output=tmp_path / "out")
    with pytest.raises(OrchestratorError, match="holds results of another study file"):
        Study(STUDY).with_(points=3).verify(output=tmp_path / "out")
    assert len(kept.points) == 12 and tomllib.loads((kept.folder / "study.toml").read_text()) == file.content
    ours = Study(STUDY).verify(output=tmp_path / "ours")
    with pytest.raises(OrchestratorError, match="holds results of another study file"):
        Study(STUDY).with_(seed=3).verify(output=tmp_path / "ours")
    assert Study(STUDY).verify(output=tmp_path / "ours").verdict == ours.verdict
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine/study.toml").write_text("mine")
    with pytest.raises(OrchestratorError, match="was there before any run"):
        Study(STUDY).verify(output=tmp_path / "mine")
    assert (tmp_path / "mine/study.toml").read_text() == "mine"
    assert Study(STUDY).with_(points=3).verify(output=tmp_path / "out", force=True).verdict.points == 3


def test_a_study_of_an_fmu(fmu, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    study = init(fmu, stop=1, step=0.5)
    assert "bearing.radialClearance" in study.parameters and len(study.criteria) == 3
    with pytest.warns(OrchestratorWarning, match="no measured value yet"):
        assert study.verify(points=2).verdict.points == 2
    run = simulate(fmu, {"bearing.radialClearance": "21 um"}, stop=1, step=0.1, record=["sensor.loadForce"])
    measured = init(fmu, measured=run.to_pandas())
    reference = measured["criteria"]["sensor.loadForce"]["reference"]
    assert measured["simulation"]["stop"] == 1 and pandas.read_csv(reference["file"])["time [s]"].iloc[-1] == 1
    few = {name: one for name, one in measured["parameters"].items() if name.startswith("load.")}
    result = measured.with_(points=4, parameters=few).verify()
    assert result.curves["criterion"] == ["sensor.loadForce"] * 11
    assert result.plot_curves().axes[0].get_ylabel() == "sensor.loadForce [N]"


SETTINGS = {
    "diameter": "25 mm", "longest-delay": "50 ms", "smoothing": {"method": "none"}, "time": {"column": "t"},
    "speed": {"variable": "drive.speed", "value": 300, "unit": "rpm", "accuracy": "0.5 rpm"},
    "load": {"column": "F", "variable": "sensor.loadForce", "unit": "N", "accuracy": "10 N", "tolerance": "15 N"},
    "torque": {"column": "M", "variable": "sensor.frictionTorque", "unit": "N.m", "accuracy": "0.007 N.m", "tolerance": 0.02},
}


@pytest.mark.parametrize("many", [False, True])
def test_recordings_become_criteria(many, fmu, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    run = simulate(fmu, stop=4, step=0.01, record=["sensor.loadForce", "sensor.frictionTorque"]).to_numpy()
    table = pandas.DataFrame(run, columns=["t", "F", "M"])
    file = tmp_path / "measured.csv"
    table.to_csv(file, index=False)
    (tmp_path / "settings.toml").write_text(text(SETTINGS))
    ours = synchronise([table] if many else table, SETTINGS, case="one", output="ours")
    done = command("synchronise", file, "--settings", tmp_path / "settings.toml", "--case", "one", "--output", tmp_path / "theirs")
    assert done.returncode == 0, done.stderr
    theirs = tomllib.loads((tmp_path / "theirs/criteria.toml").read_text())["criteria"]
    assert ours.criteria == theirs and ours.criteria["F_N"]["uncertainty"]
    assert ours.cases[0]["name"] == "one" and len(ours.signals) > 100
    curve = ours.cases[0]["criteria"]["F_N"]["reference"]["file"]
    assert curve == str(tmp_path / "ours/case.csv")
    of_file = synchronise(file, tmp_path / "settings.toml", output="file")
    assert of_file.criteria == theirs and of_file.cases == [] and "F_N" in of_file._repr_html_()
    # A format of its own is converted on the way.
    pytest.importorskip("scipy.io").savemat(tmp_path / "rig.mat", {name: table[name].to_numpy() for name in table})
    assert synchronise(tmp_path / "rig.mat", SETTINGS, output="converted").criteria == theirs
    assert (tmp_path / "converted/rig.csv").is_file()


def test_numbers_of_a_request_are_kept(tmp_path, monkeypatch):
    monkeypatch.chdir(ROOT)
    result = Study(STUDY).verify(output=tmp_path / "out")
    assert json.loads((result.folder / "request.json").read_text())["study"] == str(result.folder / "study.toml")
    assert result.replay(2)["time"][-1] == 1
