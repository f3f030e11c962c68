#!/usr/bin/env python3
"""Makes recording.csv, the recording of docs/tutorial.md: the stand with a clearance and an elastic element that differ from
the FMU's start values, and the noise of its sensors.

    python3 examples/tutorial/record.py [FMU]      # the program `orchestrator` must be on the PATH
"""

import csv
import random
import subprocess
import sys
import tempfile
from pathlib import Path

HERE = Path(__file__).resolve().parent
FMU = HERE.parents[1] / "dist" / "PlainBearingStand.fmu"
# The truth, which the tutorial does not know.
VALUES = ["bearing.radialClearance=21 um", "load.stiffness=104", "load.preload=47.2"]
# The signals by name: unit, standard deviation of the noise, digits.
SIGNALS = {"sensor.loadForce": ("N", 5.0, 1), "sensor.frictionTorque": ("N.m", 0.004, 4)}
STOP, STEP, SEED = "2", "0.01", 1


def main() -> None:
    with tempfile.TemporaryDirectory() as folder:
        run = Path(folder) / "run.csv"
        settings = [f"--set={value}" for value in VALUES]
        subprocess.run(["orchestrator", "simulate", sys.argv[1] if len(sys.argv) > 1 else FMU, "--stop", STOP, "--step", STEP,
                        *settings, "--record", ",".join(SIGNALS), "--output", run], check=True, stdout=subprocess.DEVNULL)
        with run.open(newline="") as file:
            rows = list(csv.DictReader(file))
    noise = random.Random(SEED)
    with (HERE / "recording.csv").open("w", newline="") as file:
        table = csv.writer(file, lineterminator="\n")
        table.writerow(["time", *(f"{name} [{unit}]" for name, (unit, _, _) in SIGNALS.items())])
        for row in rows:
            cells = [f"{float(row[name]) + noise.gauss(0.0, size):.{digits}f}" for name, (_, size, digits) in SIGNALS.items()]
            table.writerow([f"{float(row['time']):g}", *cells])


if __name__ == "__main__":
    main()
