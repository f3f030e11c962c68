"""The project's promises, tested from outside: fmpy and the command line on the packaged FMU."""

import csv
import math
import os
import subprocess
from pathlib import Path

import fmpy
import numpy as np
import pytest

ROOT = Path(__file__).resolve().parent.parent.parent
# What `cargo test` has built: its checks for overflow are on, and nothing has to be compiled a second time.
PROGRAM = Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target")) / os.environ.get("PROFILE", "debug") / "orchestrator"
TABLE3 = ROOT / "studies" / "paper" / "table3_solutions.csv"


def orchestrator(*arguments, code=0):
    done = subprocess.run([PROGRAM, *map(str, arguments)], cwd=ROOT, capture_output=True, text=True)
    assert done.returncode == code, done.stderr
    return done.stdout


def rows(path):
    with open(path, newline="") as file:
        return list(csv.DictReader(file))


def test_the_orchestrator_and_fmpy_give_the_same_trajectory(fmu, tmp_path):
    file = tmp_path / "run.csv"
    orchestrator("simulate", fmu, "--stop", 2, "--step", 0.01, "--set", "bearing.radialClearance=18 um",
                 "--output", file)
    ours = rows(file)
    theirs = fmpy.simulate_fmu(str(fmu), stop_time=2.0, step_size=0.01, output_interval=0.01,
                               start_values={"bearing.radialClearance": 18e-6})
    assert len(ours) == len(theirs) == 201
    for name in theirs.dtype.names:
        mine = np.array([float(row[name]) for row in ours])
        assert mine == pytest.approx(theirs[name].astype(float), rel=1e-12, abs=1e-300), name


def test_the_start_values_are_the_experiment(fmu):
    """Table 2 of the paper: F_N 750 N within 1 % in the mean over a turn, M 0.443 N.m within 5 %, the
    temperatures steady at 48 and 82 degC, each well inside its accuracy, for 1,000 s."""
    end = fmpy.simulate_fmu(str(fmu), stop_time=1000.0, step_size=100.0, output_interval=100.0)
    for name, celsius, within in [("sensor.oilTemperature", 48, 0.1), ("sensor.bearingTemperature", 82, 0.1)]:
        assert np.abs(end[name] - 273.15 - celsius).max() < within
    turn = fmpy.simulate_fmu(str(fmu), stop_time=1.0, step_size=0.002, output_interval=0.002)[-100:]
    assert turn["sensor.loadForce"].mean() == pytest.approx(750, rel=0.01)
    assert turn["sensor.frictionTorque"].mean() == pytest.approx(0.443, rel=0.05)
    assert turn["sensor.frictionCoefficient"] == pytest.approx(0.046, abs=0.002)


def test_the_loads_of_table_3(tmp_path):
    """Vrublevskyi & Skonieczna (2025), Table 3: within 0.3 N after 150 s."""
    orchestrator("verify", "studies/paper-table3.toml", "--points-from", TABLE3, "--output", tmp_path / "out")
    for ours, printed in zip(rows(tmp_path / "out" / "points.csv"), rows(TABLE3), strict=True):
        assert float(ours["F_N"]) == pytest.approx(float(printed["F_N_N"]), abs=0.3)


def test_the_papers_rows_are_judged_both_ways(tmp_path):
    """The bearing's temperature within 0.75 %, as printed, and within 0.75 degC, as the paper counts."""
    printed = (ROOT / "studies/paper-table3.toml").read_text(encoding="utf-8")
    for tolerance, count in (("0.75 %", 9), ("0.75 degC", 10)):
        study = tmp_path / "study.toml"
        study.write_text(printed.replace('tolerance = "0.75 %"', f'tolerance = "{tolerance}"').replace('"../dist/', f'"{ROOT}/dist/'), encoding="utf-8")
        words = [line.split() for line in orchestrator("judge", study, TABLE3).splitlines()]
        assert [int(line[3]) for line in words if line[:3] == ["all", "criteria:", "verified"]] == [count]


@pytest.mark.parametrize("eccentricity, sommerfeld, friction", [
    (0.1, 1.33, 26.4), (0.2, 0.631, 12.8), (0.4, 0.264, 5.79), (0.6, 0.121, 3.22),
    (0.8, 0.0446, 1.70), (0.9, 0.0188, 1.05), (0.97, 0.00474, 0.514)])
def test_raimondi_and_boyd(fmu, eccentricity, sommerfeld, friction):
    """Raimondi & Boyd (1958), full bearing, L/D = 1: eccentricity ratio and (R/c)*f within 2 %."""
    values = {"thermal.isothermal": True, "bearing.roughness": 0.0, "bearing.width": 0.025,
              "load.eccentricity": 0.0, "load.preload": 0.0, "load.stiffness": 0.0}
    viscosity = fmpy.simulate_fmu(str(fmu), stop_time=0.01, step_size=0.01, start_values=values,
                                  output=["bearing.filmViscosity"])["bearing.filmViscosity"][0]
    psi = 2e-5 / 0.0125
    pressure = viscosity * 5.0 / (sommerfeld * psi**2)
    values["load.externalForce"] = pressure * 0.025 * 0.025
    end = fmpy.simulate_fmu(str(fmu), stop_time=20.0, step_size=20.0, output_interval=20.0,
                            start_values=values)[-1]
    assert end["bearing.eccentricityRatio"] == pytest.approx(eccentricity, rel=0.02)
    assert end["sensor.frictionCoefficient"] / psi == pytest.approx(friction, rel=0.02)


def test_the_communication_step_does_not_matter(fmu):
    """0.1 ms, 1 ms, 10 ms and 100 ms agree within 1e-4 relative on the final criteria."""
    finals = [fmpy.simulate_fmu(str(fmu), stop_time=2.0, step_size=step, output_interval=max(step, 0.1))[-1]
              for step in (1e-4, 1e-3, 1e-2, 1e-1)]
    for name, zero in [("sensor.loadForce", 0), ("sensor.frictionPower", 0),
                       ("sensor.oilTemperature", 273.15), ("sensor.bearingTemperature", 273.15)]:
        values = [final[name] - zero for final in finals]
        assert max(values) - min(values) < 1e-4 * math.fabs(values[0]), name
