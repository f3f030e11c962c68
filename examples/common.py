"""Code that the examples share."""

import sys
from pathlib import Path

import fmpy
from fmpy.fmi2 import FMU2Slave

FMU = Path(__file__).resolve().parent.parent / "dist" / "PlainBearingStand.fmu"
if not FMU.is_file():
    sys.exit(f"{FMU} is missing: run scripts/package-fmu first")


def instance():
    """An initialised instance, and the value references by the variables' names."""
    description = fmpy.read_model_description(str(FMU))
    names = {variable.name: variable.valueReference for variable in description.modelVariables}
    stand = FMU2Slave(guid=description.guid, unzipDirectory=fmpy.extract(str(FMU)),
                      modelIdentifier=description.coSimulation.modelIdentifier, instanceName="stand")
    stand.instantiate()
    stand.setupExperiment(startTime=0.0)
    stand.enterInitializationMode()
    stand.exitInitializationMode()
    return stand, names


def table(result, names, rows=11):
    """Prints some rows of a result."""
    print("  ".join(f"{name:>25}" for name in ["time", *names]))
    for row in result[::max(1, (len(result) - 1) // (rows - 1))]:
        print("  ".join(f"{row[name]:25.9g}" for name in ["time", *names]))
