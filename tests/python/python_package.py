"""What the tests of the Python package share: the package on the program under test, and the command line."""

import json
import os
import subprocess
import sys

from test_acceptance import PROGRAM, ROOT

os.environ["FMU_ORCHESTRATOR_PROGRAM"] = str(PROGRAM)
# For the processes that tests start.
ENVIRONMENT = {**os.environ, "PYTHONPATH": str(ROOT / "python")}
sys.path.insert(0, str(ROOT / "python"))

PAPER = ROOT / "studies" / "paper-table3.toml"
# How a run went; all else is the same for every run. A busy machine has time for fewer re-runs, which tell whether values rest.
RUN = ["run", "isolation", "reproducibility", "rest", "left_out", "concerns"]


def command(*arguments, folder=ROOT):
    return subprocess.run([PROGRAM, *map(str, arguments)], cwd=folder, capture_output=True, text=True)


def same(ours, theirs):
    """Two folders hold the same results, however they were computed."""
    def summary(folder):
        found = json.loads((folder / "summary.json").read_text())
        return {key: value for key, value in found.items() if key not in RUN}

    assert (ours / "points.csv").read_bytes() == (theirs / "points.csv").read_bytes()
    assert summary(ours) == summary(theirs)
