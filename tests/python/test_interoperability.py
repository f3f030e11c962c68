"""The interoperability matrix; run with `pytest -m importers`."""

import json
import subprocess
import sys
import zipfile

import pytest
from conftest import ROOT

# Contents of /usr/lib/llvm-14/lib, and whether bindgen can work with them.
CLANGS = [
    ([], False),
    (["libclang-cpp.so.14", "libclang-cpp.so"], False),
    (["libclang.so.1"], False),
    (["libclang-cpp.so.14", "libclang.so", "libclang.so.1"], True),
]


@pytest.mark.parametrize("files, enough", CLANGS)
def test_other_libraries_of_clang_do_not_pass_for_libclang(files, enough, tmp_path, monkeypatch):
    monkeypatch.syspath_prepend(ROOT / "tests/interoperability")
    import matrix
    from platforms.debian import present
    folder = tmp_path / "usr/lib/llvm-14/lib"
    folder.mkdir(parents=True)
    for file in files:
        (folder / file).touch()
    assert present(file=matrix.LIBRARIES["rust"][1], root=tmp_path) == enough


@pytest.mark.importers
def test_every_importer_gets_the_same_outputs(fmu):
    command = [sys.executable, ROOT / "tests/interoperability/matrix.py", "--write"]
    done = subprocess.run(command, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr


@pytest.mark.importers
def test_the_four_forms_agree_in_the_programs_of_the_reference_fmus(fmu):
    command = [sys.executable, ROOT / "tests/interoperability/forms.py", "--write"]
    done = subprocess.run(command, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr


@pytest.mark.importers
def test_libcosim_runs_the_two_bearings(fmu, tmp_path, monkeypatch):
    monkeypatch.syspath_prepend(ROOT / "tests/interoperability")
    monkeypatch.syspath_prepend(ROOT / "examples")
    import matrix
    import two_bearings as example
    ssp = example.pack()
    with zipfile.ZipFile(ssp) as archive:
        archive.extractall(tmp_path)
    python = matrix.environment("use_libcosimpy", ["libcosimpy"])
    script = ROOT / "tests/interoperability/importers/couple_libcosimpy.py"
    out = tmp_path / "found.json"
    matrix.run([python, script, tmp_path, out])
    found = {name: float.fromhex(value) for name, value in json.loads(out.read_text()).items()}
    last = example.run(ssp, stop=1.0)[-1]
    for name, value in found.items():
        # FMPy hands the second stand its inputs one step later than libcosim does.
        close = 1e-11 if name.startswith("first.") else 5e-3
        assert value == pytest.approx(last[name], rel=close), name
