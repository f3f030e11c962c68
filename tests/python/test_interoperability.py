"""The stand in other importers; those of them that have to be installed run with `pytest -m importers`."""

import json
import subprocess
import sys
import xml.etree.ElementTree as ET
import zipfile
from argparse import Namespace

import pytest
from conftest import ROOT
from python_package import ENVIRONMENT

from fmu_orchestrator.importers import __main__ as importers
from fmu_orchestrator.importers import _tools

# Libraries that importers need and do not bring: Debian's package, and a file that only this package has.
# libclang.so comes with the headers that bindgen reads; libclang-cpp.so, which LLVM's tools install, does not.
LIBRARIES = {"libtbb12": "/usr/lib/*/libtbb.so.12*", "libclang-dev": "/usr/lib/llvm-*/lib/libclang.so"}
FORMS = [f"PlainBearingStand{form}.fmu" for form in ("", "-fmi3", "-me", "-me-fmi3")]
# While the journal springs from the centre, in the first 0.1 s, the solvers of Model Exchange are further apart.
SCENARIO = ["--stop", "1", "--step", "0.01", "--set", "load.preload=50", "--set", "thermal.ambientTemperature=300", "--since", "0.1",
            "--record", "sensor.loadForce,sensor.frictionTorque,sensor.oilTemperature,sensor.bearingTemperature,"
            "bearing.eccentricityRatio,bearing.minFilmThickness,drive.angle"]
# Contents of /usr/lib/llvm-14/lib, and whether bindgen can work with them.
CLANGS = [
    ([], False),
    (["libclang-cpp.so.14", "libclang-cpp.so"], False),
    (["libclang.so.1"], False),
    (["libclang-cpp.so.14", "libclang.so", "libclang.so.1"], True),
]


def matrix(*arguments, **options):
    command = [sys.executable, "-m", "fmu_orchestrator.importers", *map(str, arguments)]
    return subprocess.run(command, capture_output=True, text=True, **{"env": ENVIRONMENT, **options})


@pytest.mark.parametrize("files, enough", CLANGS)
def test_other_libraries_of_clang_do_not_pass_for_libclang(files, enough, tmp_path, monkeypatch):
    monkeypatch.syspath_prepend(ROOT / "scripts")
    from platforms.debian import present
    folder = tmp_path / "usr/lib/llvm-14/lib"
    folder.mkdir(parents=True)
    for file in files:
        (folder / file).touch()
    assert present(file=LIBRARIES["libclang-dev"], root=tmp_path) == enough


def test_what_is_installed_runs_and_the_rest_is_named(fmu, tmp_path):
    names = [FORMS[0], FORMS[3]]
    done = matrix(*(fmu.with_name(name) for name in names), *SCENARIO, "--stop", "0.3", "--environments", tmp_path / "none", "--output", tmp_path, "--junit", tmp_path / "junit.xml",
                  "--csv", tmp_path / "table.csv", *(part for name in ("orchestrator simulate", "FMPy", "ECOS (ecospy)", "fmi4c",
                  "FMPy validation") for part in ("--only", name)), env={**ENVIRONMENT, "FMI4C": ""})
    assert done.returncode == 1, done.stdout + done.stderr  # FMI4C names nothing that loads
    for name, same in zip(names, ("identical", "within")):
        assert f"{name}  FMPy: {same}" in done.stdout and f"{name}  FMPy validation: accepts it" in done.stdout
    assert f'{FORMS[0]}  ECOS (ecospy): not installed: {_tools.CALL} --install --only "ECOS (ecospy)"' in done.stdout
    assert not (tmp_path / "none").exists()  # nothing is fetched
    suites = ET.parse(tmp_path / "junit.xml").getroot()
    assert [(suite.get("name"), suite.get("tests"), suite.get("failures"), suite.get("skipped")) for suite in suites] == [
        (FORMS[0], "5", "1", "1"), (FORMS[3], "5", "0", "2")]
    table = (tmp_path / "table.csv").read_text().splitlines()
    assert table[0].startswith("FMU,orchestrator simulate,FMPy 0") and "ECOS" not in table[0] and len(table) == 3
    assert "FMPy validation" in (tmp_path / "importers.html").read_text()


SAMPLES = [[1.0, 10.0], [2.0, 10.0], [4.0, 10.0]]
JUDGED = [
    (SAMPLES, 0, "identical", ""),
    (SAMPLES[1:], 0, "identical", ""),
    ([[1.0, 10.0], [2.0, 10.0], [4.0, 10.0 + 1e-8]], 0, "within", "1e-09"),
    ([[1.5, 10.0], [2.0, 10.0], [4.0, 10.0]], 0, "differs", "1e-01"),
    ([[1.5, 10.0], [2.0, 10.0], [4.0, 10.0]], 1, "identical", ""),
    ([[1.5, 10.0], [2.0, 10.0], [3.0, 10.0]], 1, "differs", "2e-01"),
    ([[float("nan"), 10.0], *SAMPLES[1:]], 0, "differs", "inf"),
]


@pytest.mark.parametrize("samples, leave, verdict, words", JUDGED)
def test_differences_count_relative_to_the_largest_value(samples, leave, verdict, words):
    row = importers.Row("model.fmu", "tool")
    importers.judge(row, _tools.Answer(runs={"": samples}), {"": SAMPLES}, 1e-6, leave)
    assert (row.verdict, row.words) == (verdict, words)


def test_a_model_without_real_variables_runs_and_is_not_called_identical():
    row = importers.Row("model.fmu", "tool")
    importers.judge(row, _tools.Answer(runs={"": [[], []]}), {"": [[], []]}, 1e-6, 0)
    assert (row.verdict, row.good) == ("runs", True)


def test_the_table_keeps_what_was_not_run(tmp_path):
    file = tmp_path / "table.csv"
    file.write_text("FMU,FMPy 0.1,fmi4c,FMPy validation 0.1\nother.fmu,identical,-,accepts it\nmodel.fmu,refused: x,identical,\n")
    rows = [importers.Row("model.fmu", "FMPy", "0.2", "within", "1e-09"), importers.Row("model.fmu", "fmi4c", "-", "not installed", "y"),
            importers.Row("new.fmu", "fmusim", "-", "identical")]
    importers.table(rows, file)
    assert file.read_text() == ("FMU,FMPy 0.2,fmusim,fmi4c,FMPy validation 0.1\nother.fmu,identical,,-,accepts it\n"
                                "model.fmu,within: 1e-09,,identical,\nnew.fmu,,identical,,\n")


def test_a_run_that_crashes_or_says_nothing_has_its_reason():
    with pytest.raises(_tools.Trouble, match="ends by signal 11"):
        _tools.run([sys.executable, "-c", "import os; os.kill(os.getpid(), 11)"])
    with pytest.raises(_tools.Trouble, match="it said nothing"):
        _tools.run([sys.executable, "-c", "raise SystemExit(3)"])
    with pytest.raises(_tools.Trouble, match="in place of 3"):
        importers.difference([[1.0]], SAMPLES)


def test_an_answer_that_is_none_is_a_reason(fmu):
    wanted = _tools.Scenario(str(fmu), "2.0", "CoSimulation", "", "", 0.1, 2, 0.2, {}, ["x", "y"], {})
    row = importers.asked(_tools.Tool("odd", _tools.ALL, ask=lambda *_: {}["y"]), wanted, {"": SAMPLES}, Namespace(environments=fmu.parent))
    assert (row.verdict, row.words, row.good) == ("refused", "'y'", False)
    row = importers.asked(_tools.Tool("odd", (_tools.NEW,), ask=lambda *_: {}["y"]), wanted, {"": SAMPLES}, Namespace(environments=fmu.parent))
    assert (row.verdict, row.good) == ("not for it", None)


@pytest.mark.importers
def test_every_importer_gets_the_same_outputs(fmu, tmp_path, monkeypatch):
    monkeypatch.syspath_prepend(ROOT / "scripts")
    from platforms.debian import install
    for package, file in LIBRARIES.items():
        install(package, file=file)
    done = matrix(*(fmu.with_name(name) for name in FORMS), *SCENARIO, "--install", "--output", tmp_path, "--csv",
                  ROOT / "docs/evidence/importers.csv")
    assert done.returncode == 0, done.stdout + done.stderr


@pytest.mark.importers
def test_the_orchestrator_does_nothing_against_fmi(fmu):
    command = [sys.executable, ROOT / "tests/interoperability/errors.py"]
    done = subprocess.run(command, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr


@pytest.mark.importers
def test_the_four_forms_agree_in_the_programs_of_the_reference_fmus(fmu):
    command = [sys.executable, ROOT / "tests/interoperability/forms.py", "--write"]
    done = subprocess.run(command, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr


@pytest.mark.importers
def test_libcosim_runs_the_two_bearings(fmu, tmp_path, monkeypatch):
    monkeypatch.syspath_prepend(ROOT / "examples")
    import two_bearings as example
    ssp = example.pack()
    with zipfile.ZipFile(ssp) as archive:
        archive.extractall(tmp_path)
    tool = next(tool for tool in _tools.TOOLS if tool.module == "libcosimpy")
    _tools.install(tool, ROOT / ".cache/importers")
    python = _tools.python_of(tool, ROOT / ".cache/importers")
    script = ROOT / "tests/interoperability/couple_libcosimpy.py"
    out = tmp_path / "found.json"
    _tools.run([python, script, tmp_path, out])
    found = {name: float.fromhex(value) for name, value in json.loads(out.read_text()).items()}
    last = example.run(ssp, stop=1.0)[-1]
    for name, value in found.items():
        # FMPy hands the second stand its inputs one step later than libcosim does.
        close = 1e-11 if name.startswith("first.") else 5e-3
        assert value == pytest.approx(last[name], rel=close), name
