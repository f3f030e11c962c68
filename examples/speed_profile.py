"""An engine starts, idles, runs up and coasts down: the shaft speed as an input over time.

`run` is the short way. `with_slopes` hands the FMU the slope of the profile with each value, so that
long communication steps follow the ramps exactly (FMPy 0.3.32 has an option for that, which fails for
other than nine inputs).
"""

import fmpy
import numpy as np
from common import FMU, instance, table

RPM = np.pi / 30
TIMES = [0.0, 1.0, 3.0, 6.0, 8.0, 10.0]  # s
SPEEDS = [0.0, 800.0 * RPM, 800.0 * RPM, 3000.0 * RPM, 3000.0 * RPM, 300.0 * RPM]  # rad/s
OUTPUTS = ["drive.shaftSpeed", "sensor.frictionTorque", "bearing.contactShare", "bearing.minFilmThickness",
           "drive.angle"]


def run(step=0.01):
    """The profile's points, joined by straight lines; the FMU holds each value for a step."""
    profile = np.array(list(zip(TIMES, SPEEDS)), dtype=[("time", float), ("drive.speed", float)])
    return fmpy.simulate_fmu(str(FMU), stop_time=TIMES[-1], step_size=step, output_interval=step,
                             input=profile, output=OUTPUTS)


def with_slopes(step=0.25):
    """The outputs at the end, with the profile's slopes given to the FMU."""
    stand, names = instance()
    speed = [names["drive.speed"]]
    for i in range(round(TIMES[-1] / step)):
        here, there = np.interp([i * step, (i + 1) * step], TIMES, SPEEDS)
        stand.setReal(speed, [here])
        stand.setRealInputDerivatives(speed, [1], [(there - here) / step])
        stand.doStep(i * step, step)
    values = stand.getReal([names[name] for name in OUTPUTS])
    stand.terminate()
    stand.freeInstance()
    return dict(zip(OUTPUTS, values))


if __name__ == "__main__":
    table(run(), OUTPUTS)
    print("the same with slopes, in 40 steps: shaft angle", with_slopes()["drive.angle"], "rad")
