"""The FMUs for Model Exchange: other solvers integrate the stand, and come to what Co-Simulation gives."""

import csv
import subprocess
import zipfile

import fmpy
import fmpy.validation
import numpy as np
import pytest
from conftest import ROOT
from lxml import etree
from python_package import PROGRAM

OUTPUTS = ["sensor.loadForce", "sensor.frictionTorque", "sensor.frictionPower", "sensor.bearingTemperature",
           "sensor.oilTemperature", "bearing.eccentricityRatio", "bearing.attitudeAngle", "bearing.minFilmThickness",
           "drive.angle"]


@pytest.fixture(scope="module", params=["-me", "-me-fmi3"])
def exchange(fmu, request):
    path = fmu.with_name(f"PlainBearingStand{request.param}.fmu")
    assert path.is_file(), f"{path} is missing: run scripts/package-fmu first"
    return path


@pytest.fixture(scope="module")
def expected(fmu):
    """Co-Simulation with tight steps of its own."""
    return fmpy.simulate_fmu(str(fmu), stop_time=1.0, output_interval=0.05, output=OUTPUTS, relative_tolerance=1e-11)


def test_the_validator_finds_nothing(exchange):
    assert fmpy.validation.validate_fmu(str(exchange)) == []


def test_variables_are_those_of_co_simulation_but_for_means(exchange, description):
    described = fmpy.read_model_description(str(exchange), validate=True)
    assert described.coSimulation is None and described.modelExchange is not None
    references = {v.name: v.valueReference for v in described.modelVariables}
    here = {v.name: v.valueReference for v in description.modelVariables if not v.name.endswith("Mean")}
    assert here.items() <= references.items()
    more = set(references) - set(here) - {"time"}
    states = {name for name in more if name.startswith("state.")}
    assert len(states) == 8 and more - states == {f"der({name})" for name in states}


def test_cvode_comes_to_the_same(exchange, expected):
    """With CVode of fmpy, relative to the largest value. In the first 0.1 s, while the journal springs from the centre, CVode's
    own error is larger; it shrinks with its tolerance."""
    result = fmpy.simulate_fmu(str(exchange), fmi_type="ModelExchange", solver="CVode", stop_time=1.0, output_interval=0.05,
                               relative_tolerance=3e-11, output=OUTPUTS)
    assert result["time"] == pytest.approx(expected["time"], abs=1e-12)
    for name in OUTPUTS:
        difference = np.abs(result[name] - expected[name])[2:].max() / np.abs(expected[name]).max()
        assert difference < 1e-6, (name, difference)


def test_our_own_importer_takes_it(exchange, expected, tmp_path):
    done = subprocess.run([PROGRAM, "check", exchange], capture_output=True, text=True)
    assert done.returncode == 0 and done.stdout.endswith("nothing found\n"), done.stdout
    file = tmp_path / "run.csv"
    subprocess.run([PROGRAM, "simulate", exchange, "--stop", "1", "--step", "0.05", "--output", file], check=True,
                   capture_output=True)
    with file.open() as lines:
        last = list(csv.DictReader(lines))[-1]
    for name in OUTPUTS:
        column = next(key for key in last if key.split(" ")[0] == name)
        # The tolerance that the description suggests is 1e-6 a step.
        assert float(last[column]) == pytest.approx(expected[name][-1], rel=1e-4), name


def test_the_film_that_steps_itself_is_refused(exchange, capfd):
    with pytest.raises(Exception, match="(?i)initiali[sz]ation"):
        fmpy.simulate_fmu(str(exchange), fmi_type="ModelExchange", stop_time=0.1, start_values={"bearing.film": 2},
                          debug_logging=True)


def test_the_lag_is_exchanged(tmp_path):
    for version in ("2", "3"):
        file = tmp_path / f"Lag{version}.fmu"
        command = ["cargo", "run", "--locked", "--package", "lag", "--", "--profile", "dev", "--exchange", "--fmi", version,
                   "--output", file]
        done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True)
        assert done.returncode == 0, done.stderr
        assert fmpy.validation.validate_fmu(str(file)) == []
        root = etree.fromstring(zipfile.ZipFile(file).read("modelDescription.xml"))
        assert root.find("ModelExchange") is not None and root.find("CoSimulation") is None
        result = fmpy.simulate_fmu(str(file), stop_time=1.0, output_interval=0.1, start_values={"input": 3.0},
                                   relative_tolerance=1e-9)
        assert result["output"] == pytest.approx(6.0 - 5.0 * np.exp(-result["time"] / 0.5), abs=1e-7)
