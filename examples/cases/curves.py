#!/usr/bin/env python3
"""Noisy curves of a mass on a spring with a damper, from scipy's solver: three tests of one system.

    m x'' = f(t) - c x - d x'

    python3 examples/cases/curves.py FOLDER [SEED]

writes release.csv, push.csv and swing.csv (time, force f in N, position x in m with normal noise).
"""

import csv
import sys
from pathlib import Path

import numpy as np
from scipy.integrate import solve_ivp

# The truth that identify is to find.
MASS, STIFFNESS, DAMPING = 1.0, 1.3, 0.4
# Standard deviation of the noise, m.
NOISE = 0.1
STOP, STEP = 10.0, 0.1

# Position at the start, m, as the FMU has it.
START = 1.0
# Force over time.
TESTS = {
    "release": lambda t: 0.0 * t,
    "push": lambda t: np.where(t < 3.0, t / 3.0, 1.0),
    "swing": lambda t: 0.8 * np.sin(1.7 * t),
}


def position(force, times: np.ndarray) -> np.ndarray:
    """The position at these times, far more accurate than the noise."""

    def rates(t, state):
        x, v = state
        return [v, (force(t) - STIFFNESS * x - DAMPING * v) / MASS]

    solved = solve_ivp(rates, [0.0, times[-1]], [START, 0.0], t_eval=times, rtol=1e-9, atol=1e-11, max_step=0.1)
    return solved.y[0]


def main(folder: Path, seed: int) -> None:
    """Writes the tables."""
    random = np.random.default_rng(seed)
    times = np.linspace(0.0, STOP, round(STOP / STEP) + 1)
    folder.mkdir(parents=True, exist_ok=True)
    for name, force in TESTS.items():
        noisy = position(force, times) + NOISE * random.normal(size=times.size)
        with (folder / f"{name}.csv").open("w", newline="") as file:
            table = csv.writer(file)
            table.writerow(["time", "f", "x"])
            table.writerows(zip(times.tolist(), force(times).tolist(), noisy.tolist(), strict=True))


if __name__ == "__main__":
    main(Path(sys.argv[1]), int(sys.argv[2]) if len(sys.argv) > 2 else 1)
