"""What `scripts/cross-check` writes is what the FMI project's cross-check asks for, and what it says of other tools' FMUs is
true."""

import os
import subprocess
import sys

import pytest
from conftest import ROOT
from test_acceptance import PROGRAM

SCRIPT = ROOT / "scripts" / "cross_check.py"


def cross_check(place, *arguments):
    environment = {**os.environ, "ORCHESTRATOR": str(PROGRAM), "CROSS_CHECK": str(place), "PROFILE": "dev"}
    return subprocess.run([sys.executable, SCRIPT, *arguments], env=environment, capture_output=True, text=True)


@pytest.fixture(scope="module")
def repository(fmu, tmp_path_factory):
    """What the exporter writes."""
    place = tmp_path_factory.mktemp("exported")
    done = cross_check(place, "export")
    assert done.returncode == 0, done.stderr
    assert done.stdout.count("rules met") == 3, done.stdout
    return place


def test_every_file_that_the_rules_name_is_there(repository):
    folder = repository / "fmus/2.0/cs/linux64/fmu-export"
    for name in ("PlainBearingStand", "Tank", "Lag"):
        (found,) = folder.glob(f"*/{name}")
        files = {file.name for file in found.iterdir()}
        assert files == {f"{name}.fmu", f"{name}_ref.csv", f"{name}_in.csv", f"{name}_ref.opt", "README.md"}


def test_imports_are_told_as_they_are(repository, tmp_path):
    done = cross_check(tmp_path, "import", repository)
    assert done.stdout.endswith("3 passed\n"), done.stdout + done.stderr
    # A reference that is another model's, options that are missing, an FMU that is not public, one that cannot run.
    (folder,) = repository.glob("fmus/2.0/cs/linux64/fmu-export/*")
    reference = folder / "Tank" / "Tank_ref.csv"
    lines = reference.read_text().splitlines()
    moved = [",".join([row.split(",")[0], *(str(float(cell) + 5.0) for cell in row.split(",")[1:])]) for row in lines[1:]]
    reference.write_text("\n".join([lines[0], *moved]) + "\n")
    (folder / "Lag" / "Lag_ref.opt").unlink()
    (folder / "PlainBearingStand" / "PlainBearingStand_in.csv").write_text('"time","no.such.input"\n0,1\n')
    (folder / "Tank").with_name("Hidden").mkdir()
    done = cross_check(tmp_path, "import", repository)
    told = {line.split()[3]: line.split()[0] for line in done.stdout.splitlines()[:-1]}
    assert told == {"Tank": "failed", "Lag": "rejected", "PlainBearingStand": "failed", "Hidden": "rejected"}
    assert "no.such.input" in done.stdout and "outside of the reference's band" in done.stdout
    results = {file.parent.name: file.name for file in tmp_path.rglob("*") if file.is_file() and file.suffix == ""}
    assert results == told


def test_a_folder_that_is_no_repository_is_named(tmp_path):
    done = cross_check(tmp_path, "import", tmp_path)
    assert done.returncode == 1 and "no folder fmus/2.0/cs/linux64" in done.stderr
