"""A master that controls its communication step, and takes steps back that were too long.

The stand is coupled to a spring-mounted mass of this master, which the bearing's load pushes, and which
pushes back. Each step is done once whole and once in halves; where these differ by more than the
tolerance, the FMU's saved state is restored and the step is done again, shorter.
"""

from common import instance

MASS, STIFFNESS, DAMPING = 20.0, 4e5, 400.0  # kg, N/m, N.s/m: 22 Hz
COUPLING = 5e4  # N/m: force on the bearing for the mass's displacement
TOLERANCE = 1e-7  # m


class Coupled:
    """The FMU and the mass."""

    def __init__(self):
        self.fmu, self.names = instance()
        self.mean = self.get("sensor.loadForce")
        self.mass = (0.0, 0.0)  # displacement, velocity

    def get(self, name):
        return self.fmu.getReal([self.names[name]])[0]

    def step(self, time, step):
        """Both go ahead with what they know of each other at the step's start (Jacobi)."""
        place, speed = self.mass
        push = self.get("sensor.loadForce") - self.mean
        self.fmu.setReal([self.names["load.externalForce"]], [-COUPLING * place])
        self.fmu.doStep(time, step)
        # Implicit in the mass's own spring and damper.
        speed = (speed + step / MASS * (push - STIFFNESS * place)) / (
            1.0 + step * DAMPING / MASS + step * step * STIFFNESS / MASS)
        self.mass = (place + step * speed, speed)

    def restore(self, saved):
        self.fmu.setFMUstate(saved[0])
        self.mass = saved[1]


def run(stop=0.5, longest=0.02, tolerance=TOLERANCE):
    """Returns the coupled system at the end, the steps taken (start, length), and the number rejected."""
    coupled, time, step, steps, rejected = Coupled(), 0.0, longest, [], 0
    while stop - time > 1e-9:
        step = min(step, stop - time)
        saved = (coupled.fmu.getFMUstate(), coupled.mass)
        coupled.step(time, step)
        whole = coupled.mass[0]
        coupled.restore(saved)
        coupled.step(time, step / 2)
        coupled.step(time + step / 2, step / 2)
        error = abs(coupled.mass[0] - whole)
        if error > tolerance and step > 1e-5:
            coupled.restore(saved)
            rejected += 1
        else:
            steps.append((time, step))
            time += step
        coupled.fmu.freeFMUstate(saved[0])
        step = min(longest, step * min(2.0, max(0.3, 0.8 * (tolerance / max(error, 1e-30)) ** 0.5)))
    return coupled, steps, rejected


if __name__ == "__main__":
    coupled, steps, rejected = run()
    lengths = [length for _, length in steps]
    print(f"{len(steps)} steps from {min(lengths):.2g} s to {max(lengths):.2g} s, {rejected} rejected")
    print(f"mass at {1e6 * coupled.mass[0]:.3f} um, load {coupled.get('sensor.loadForce'):.3f} N")
    coupled.fmu.terminate()
    coupled.fmu.freeInstance()
