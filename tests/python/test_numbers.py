"""Tables of the documents that take seconds to compute: the commands beside them print their numbers."""

import csv
import math
import subprocess

import pytest
from test_acceptance import PROGRAM, ROOT

ZERO = 273.15
BRONZE = {"bearing.bushExpansion": 18e-6, "bearing.bushModulus": "110 GPa"}
HOUSING = {"bearing.housingExpansion": 23e-6, "bearing.housingModulus": "70 GPa"}
FREE, PRESSED = ({"bearing.thermalClearance": name} for name in ("FreeBush", "ConstrainedBush"))
CAVITIES = {"bearing.film": "Reynolds", "load.eccentricity": 0, "thermal.isothermal": "true", "bearing.roughness": 0}


def last(stop, step, settings):
    """The last row of a simulation of the stand."""
    pairs = [part for name, value in settings.items() for part in ("--set", f"{name}={value}")]
    command = [PROGRAM, "simulate", ROOT / "dist/PlainBearingStand.fmu", "--stop", str(stop), "--step", str(step), *pairs]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    return {name: float(value) for name, value in list(csv.DictReader(done.stdout.splitlines()))[-1].items()}


def holds(page, row):
    assert row in (ROOT / "docs" / page).read_text(encoding="utf-8").splitlines(), row


@pytest.mark.parametrize("bush, settings", [
    ("off", {}), ("free, bronze", FREE | BRONZE), ("bronze in steel", PRESSED | BRONZE), ("bronze in aluminium", PRESSED | BRONZE | HOUSING),
])
def test_the_clearance_at_work(bush, settings):
    row = last(0.2, 0.2, {"thermal.initialization": "SteadyState"} | settings)
    bearing = row["sensor.bearingTemperatureMean"] - ZERO
    clearance, torque = 1e6 * row["bearing.hotRadialClearance"], row["sensor.frictionTorqueMean"]
    holds("clearance.md", f"| {bush} | {clearance:.2f} | {torque:.4f} | {bearing:.2f} |")


@pytest.mark.parametrize("pressure", ["1.325, or not given", "90", "101.325"])
def test_the_pressure_in_cavities(pressure):
    given = {} if "not given" in pressure else {"bearing.cavityPressure": f"{pressure} kPa"}
    row = last(4, 0.5, CAVITIES | given)
    flow, torque = 1e9 * row["bearing.sideFlow"], row["sensor.frictionTorque"]
    eccentricity, attitude = row["bearing.eccentricityRatio"], math.degrees(row["bearing.attitudeAngle"])
    holds("film.md", f"| {pressure} | {flow:.1f} | {torque:.4f} | {eccentricity:.3f} | {attitude:.1f} |")
