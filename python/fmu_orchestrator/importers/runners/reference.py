"""The reference: the C functions called directly, in the order that the standard prescribes.

Importers compute times and step sizes in four ways that differ in the last digit, and the outputs with them; some pass the
FMU's suggested tolerance. There is one reference run for each way.
"""

from concurrent.futures import ProcessPoolExecutor
from itertools import accumulate, repeat

import fmpy
from fmpy.fmi2 import FMU2Slave
from fmpy.fmi3 import FMU3Slave
from scenario import FMU, GUID, IDENTIFIER, OUTPUTS, REFERENCES, START, STEP, STEPS, SUGGESTED, VERSION, report

PER_SECOND = round(1 / STEP)
MULTIPLIED = [i * STEP for i in range(STEPS + 1)]
DIVIDED = [i / PER_SECOND for i in range(STEPS + 1)] if PER_SECOND * STEP == 1 else MULTIPLIED


def between(points):
    """The steps between communication points, as a tool computes them that keeps the points."""
    return [(here, there - here) for here, there in zip(points, points[1:])]


WAYS = {
    "": [(time, STEP) for time in MULTIPLIED[:-1]],
    "it adds up the steps": [(time, STEP) for time in accumulate(repeat(STEP, STEPS - 1), initial=0.0)],
    "it passes t[i+1] - t[i] as step size": between(MULTIPLIED),
    "it passes t[i+1] - t[i] as step size, with times in whole nanoseconds": between(DIVIDED),
}
WITH_TOLERANCE = "it passes the FMU's tolerance"
outputs = [REFERENCES[name] for name in OUTPUTS]


def run(steps, folder, tolerance=None):
    old = VERSION == "2.0"
    instance = (FMU2Slave if old else FMU3Slave)(guid=GUID, unzipDirectory=folder, modelIdentifier=IDENTIFIER,
                                                 instanceName="reference")
    instance.instantiate()
    read, write = (instance.getReal, instance.setReal) if old else (instance.getFloat64, instance.setFloat64)
    if old:
        instance.setupExperiment(startTime=0.0, tolerance=tolerance)
    if START:
        write([REFERENCES[name] for name in START], list(START.values()))
    instance.enterInitializationMode(*() if old else (tolerance,))
    instance.exitInitializationMode()
    samples = [read(outputs)]
    for time, step in steps:
        instance.doStep(time, step)
        samples.append(read(outputs))
    instance.terminate()
    instance.freeInstance()
    return samples


if __name__ == "__main__":
    unpacked = fmpy.extract(FMU)
    # Each in a process of its own: some FMUs keep something from instance to instance.
    with ProcessPoolExecutor(1, max_tasks_per_child=1) as processes:
        runs = {way: processes.submit(run, steps, unpacked).result() for way, steps in WAYS.items()}
        if SUGGESTED:
            runs[WITH_TOLERANCE] = processes.submit(run, WAYS[""], unpacked, SUGGESTED).result()
        report("fmpy", runs)
