"""The reference: the C functions called directly, in the order that the standard prescribes.

Importers compute the step size in three ways that differ in the last digit, and the outputs with them.
There is one reference run for each way.
"""

import fmpy
from fmpy.fmi2 import FMU2Slave
from scenario import OUTPUTS, START, STEP, STEPS, fmu, report

PER_SECOND = round(1 / STEP)
MULTIPLIED = [i * STEP for i in range(STEPS + 1)]
DIVIDED = [i / PER_SECOND for i in range(STEPS + 1)]


def between(points):
    """The steps between communication points, as a tool computes them that keeps the points."""
    return [(here, there - here) for here, there in zip(points, points[1:])]


WAYS = {
    "": [(time, STEP) for time in MULTIPLIED[:-1]],
    "it passes t[i+1] - t[i] as step size": between(MULTIPLIED),
    "it passes t[i+1] - t[i] as step size, with times in whole nanoseconds": between(DIVIDED),
}

description = fmpy.read_model_description(fmu())
references = {variable.name: variable.valueReference for variable in description.modelVariables}
folder = fmpy.extract(fmu())
outputs = [references[name] for name in OUTPUTS]


def run(steps):
    instance = FMU2Slave(guid=description.guid, unzipDirectory=folder,
                         modelIdentifier=description.coSimulation.modelIdentifier, instanceName="reference")
    instance.instantiate()
    instance.setupExperiment(startTime=0.0)
    instance.setReal([references[name] for name in START], list(START.values()))
    instance.enterInitializationMode()
    instance.exitInitializationMode()
    samples = [instance.getReal(outputs)]
    for time, step in steps:
        instance.doStep(time, step)
        samples.append(instance.getReal(outputs))
    instance.terminate()
    instance.freeInstance()
    return samples


report("fmpy", {way: run(steps) for way, steps in WAYS.items()})
