#!/usr/bin/env python3
"""Recordings of a simulated rig at two speeds, with what spoils real ones: noise, a late torque, drift, spikes, missing samples.

    python3 examples/recording/record.py FOLDER [SEED] [FMU]

writes 300rpm.csv and 450rpm.csv as a logger would. The rig is the stand itself with CLEARANCE and STIFFNESS, which
`identify` is to find; `orchestrator` must be on the PATH, or in the environment variable ORCHESTRATOR.
"""

import csv
import os
import random
import subprocess
import sys
import tempfile
from pathlib import Path

# The truth.
CLEARANCE, STIFFNESS = 21.0, 103.0          # um, N/m
# The torque's amplifier is late, s: a sample and a part of one.
LATE = 0.0172
# Standard deviations of the noise: N, N.m, degC.
NOISE = {"F": 4.0, "M": 0.004, "T": 0.05}
# The zero of the torque's sensor drifts by so much from begin to end, N.m: within its accuracy.
DRIFT = 0.002
STOP, STEP, FINE = 6.0, 0.01, 0.001
FMU = Path(__file__).resolve().parents[2] / "dist" / "PlainBearingStand.fmu"


def speed(nominal: float, time: float) -> float:
    """The drive droops by 1 % under load, rpm."""
    return nominal * (1.0 - 0.01 * time / STOP)


def run(fmu: Path, nominal: float) -> list[list[float]]:
    """Time, load, torque and bearing temperature (degC) of the rig, in fine steps."""
    with tempfile.TemporaryDirectory() as folder:
        profile, out = Path(folder) / "speed.csv", Path(folder) / "out.csv"
        rows = [[t, speed(nominal, t)] for t in (0.0, STOP)]
        profile.write_text("time,drive.speed [rpm]\n" + "".join(f"{t},{n}\n" for t, n in rows))
        subprocess.run([os.environ.get("ORCHESTRATOR", "orchestrator"), "simulate", fmu, "--stop", str(STOP),
                        "--step", str(FINE), "--set", f"bearing.radialClearance={CLEARANCE} um",
                        "--set", f"load.stiffness={STIFFNESS}", "--input", profile,
                        "--record", "sensor.loadForce,sensor.frictionTorque,sensor.bearingTemperature", "--output", out],
                       check=True)
        with out.open(newline="") as file:
            rows = [[float(cell) for cell in row] for row in list(csv.reader(file))[1:]]
        return [[*row[:3], row[3] - 273.15] for row in rows]


def at(rows: list[list[float]], column: int, time: float) -> float:
    """The value at a time, on a straight line between the steps; the first one before them."""
    place = max(0.0, time) / FINE
    before = min(int(place), len(rows) - 2)
    low, high = rows[before][column], rows[before + 1][column]
    return low + (place - before) * (high - low)


def record(fmu: Path, nominal: float, path: Path, noise: random.Random) -> None:
    """One recording."""
    rows = run(fmu, nominal)
    with path.open("w", newline="") as file:
        table = csv.writer(file)
        table.writerow(["t [s]", "n [rpm]", "F [N]", "M [N.m]", "T [degC]"])
        for k in range(round(STOP / STEP) + 1):
            t = k * STEP
            cells = {
                "F": at(rows, 1, t) + noise.gauss(0.0, NOISE["F"]),
                "M": at(rows, 2, t - LATE) + noise.gauss(0.0, NOISE["M"]) + DRIFT * (t / STOP - 0.5),
                "T": at(rows, 3, t) + noise.gauss(0.0, NOISE["T"]),
            }
            if k in (250, 480):
                cells["F"] = 9999.0                       # a spike
            texts = {name: f"{value:.6g}" for name, value in cells.items()}
            if k in (300, 301):
                texts["M"] = ""                           # samples that the logger lost
            table.writerow([f"{t:.3f}", f"{speed(nominal, t):.3f}", *texts.values()])


if __name__ == "__main__":
    folder = Path(sys.argv[1])
    folder.mkdir(parents=True, exist_ok=True)
    seed = int(sys.argv[2]) if len(sys.argv) > 2 else 1
    for number, rpm in enumerate((300, 450)):
        source = Path(sys.argv[3]) if len(sys.argv) > 3 else FMU
        record(source.resolve(), rpm, folder / f"{rpm}rpm.csv", random.Random(100 * seed + number))
