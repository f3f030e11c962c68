"""The run that every importer does: the same start values, the same communication points."""

import importlib.metadata
import json
import sys

STOP = 1.0
STEP = 0.01
START = {"load.preload": 50.0, "thermal.ambientTemperature": 300.0}
OUTPUTS = ["sensor.loadForce", "sensor.frictionTorque", "sensor.oilTemperature",
           "sensor.bearingTemperature", "bearing.eccentricityRatio", "bearing.minFilmThickness",
           "drive.angle"]
STEPS = round(STOP / STEP)


def report(package, samples, note=""):
    """Hands the samples, a list of output values a communication point, to the matrix.

    A tool that tells nothing of the start gives one sample fewer; the matrix aligns at the end.
    Several runs go by their names.
    """
    version = importlib.metadata.version(package) if package else ""
    runs = samples if isinstance(samples, dict) else {"": samples}
    exact = {name: [[float(value).hex() for value in sample] for sample in run]
             for name, run in runs.items()}
    with open(sys.argv[2], "w", encoding="utf-8") as file:
        json.dump({"version": version, "note": note, "runs": exact}, file)


def fmu():
    return sys.argv[1]
