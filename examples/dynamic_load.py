"""A dynamic load from outside: the rig's own load, and an impact of a connecting rod on top of it."""

import fmpy
import numpy as np
from common import FMU, table

OUTPUTS = ["sensor.loadForce", "bearing.eccentricityRatio", "bearing.minFilmThickness", "bearing.maxFilmPressure"]
PERIOD, LENGTH, HEIGHT = 0.2, 0.02, 2000.0  # s, s, N: a half sine once a turn


def force(time):
    phase = np.mod(time, PERIOD)
    return np.where(phase < LENGTH, HEIGHT * np.sin(np.pi * phase / LENGTH), 0.0)


def run(stop=1.0, step=0.001):
    times = np.linspace(0.0, stop, round(stop / step) + 1)
    load = np.array(list(zip(times, force(times))), dtype=[("time", float), ("load.externalForce", float)])
    return fmpy.simulate_fmu(str(FMU), stop_time=stop, step_size=step, output_interval=step, input=load,
                             output=OUTPUTS)


if __name__ == "__main__":
    result = run()
    table(result[(result["time"] > 0.399) & (result["time"] < 0.431)], OUTPUTS)
