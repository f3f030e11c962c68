"""The interoperability matrix; run with `pytest -m importers`."""

import subprocess
import sys

import pytest
from conftest import ROOT


@pytest.mark.importers
def test_every_importer_gets_the_same_outputs(fmu):
    command = [sys.executable, ROOT / "tests/interoperability/matrix.py", "--readme"]
    done = subprocess.run(command, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr
