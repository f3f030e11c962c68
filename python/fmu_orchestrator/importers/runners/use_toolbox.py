"""FMU Manipulation Toolbox: its checks, then the FMU within a container FMU that fmpy runs."""

import json
import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

import fmpy
from scenario import FMU, OUTPUTS, START, STEP, STOP, report

programs = Path(sys.executable).parent
folder = Path(tempfile.mkdtemp())
shutil.copy(FMU, folder / "stand.fmu")
(folder / "container.json").write_text(json.dumps({
    "name": "container.fmu", "fmu": ["stand.fmu"], "step_size": STEP, "auto_input": True,
    "auto_output": True, "auto_parameter": True}))
check = subprocess.run([programs / "fmutool", "-input", "stand.fmu", "-check"], cwd=folder,
                       capture_output=True, text=True, check=True)
log = check.stdout + check.stderr
assert "compliant with FMI-" in log and "No semantic error" in log, log
subprocess.run([programs / "fmucontainer", "-container", "container.json", "-fmu-directory", ".",
                "-auto-parameter"], cwd=folder, capture_output=True, check=True)
container = str(folder / "container.fmu")
names = {variable.name for variable in fmpy.read_model_description(container).modelVariables}


def outer(name):
    """The container's name for a variable of the stand."""
    return name if name in names else f"stand.{name}"


result = fmpy.simulate_fmu(container, stop_time=STOP, step_size=STEP, output_interval=STEP,
                           start_values={outer(name): value for name, value in START.items()},
                           output=[outer(name) for name in OUTPUTS])
report("fmu-manipulation-toolbox", [[row[outer(name)] for name in OUTPUTS] for row in result],
       "the stand is packed into its container FMU; its checks find nothing")
