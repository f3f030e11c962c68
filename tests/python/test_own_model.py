"""A model of one's own (`examples/own-model`) becomes an FMU by one command, and fmpy runs it."""

import subprocess
import zipfile

import fmpy
import fmpy.validation
import numpy as np
import pytest
from conftest import ROOT, FMU2Stand
from test_acceptance import PROGRAM

GRAVITY, AREA, HOLE = 9.81, 0.5, 2e-3


@pytest.fixture(scope="module")
def tank(tmp_path_factory):
    """The packed tank. The profile `dev` shares what the Rust tests have built."""
    file = tmp_path_factory.mktemp("own") / "Tank.fmu"
    command = ["cargo", "run", "--locked", "--package", "own-model", "--", "--profile", "dev", "--output", file]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert done.stdout.startswith(str(file)), done.stdout
    return file


def level(time, start):
    """Torricelli's solution without inflow."""
    return np.maximum(np.sqrt(start) - HOLE / AREA * np.sqrt(GRAVITY / 2) * time, 0.0) ** 2


def test_the_fmu_is_valid_and_tells_where_it_comes_from(tank):
    assert fmpy.validation.validate_fmu(str(tank)) == []
    description = fmpy.read_model_description(str(tank))
    assert (description.modelName, description.version, description.license) == ("Draining tank", "1.0.0", "MIT")
    assert description.author == "The plain-bearing-stand authors"
    assert zipfile.ZipFile(tank).namelist() == ["binaries/linux64/Tank.so", "modelDescription.xml"]


def test_the_level_falls_by_torricellis_law(tank):
    result = fmpy.simulate_fmu(str(tank), stop_time=200, output_interval=0.5, start_values={"initialLevel": 2.0},
                               validate=True)
    assert result["level"] == pytest.approx(level(result["time"], 2.0), abs=1e-7)
    outflow = HOLE * np.sqrt(2 * GRAVITY * level(result["time"], 2.0))
    assert result["outflow"] == pytest.approx(outflow, abs=1e-6)
    assert result["level"][-1] == pytest.approx(0.0, abs=1e-9), "empty after 160 s"


def test_states_and_derivatives_come_with_the_boundary(tank, tmp_path):
    description = fmpy.read_model_description(str(tank))
    instance = FMU2Stand(fmpy.extract(str(tank), str(tmp_path)), description).start(inflow=0.01)
    instance.doStep(0.0, 1.0)
    state = instance.getFMUstate()
    (before,) = instance.get("level")
    (rate,) = instance.getRealOutputDerivatives([instance.names["level"]], [1])
    assert rate == pytest.approx((0.01 - HOLE * np.sqrt(2 * GRAVITY * before)) / AREA, rel=1e-12)
    instance.doStep(1.0, 1.0)
    after = instance.get("level")
    instance.setFMUstate(state)
    assert instance.get("level") == [before]
    instance.doStep(1.0, 1.0)
    assert instance.get("level") == after
    instance.freeFMUstate(state)
    instance.freeInstance()


def test_a_mistake_in_the_command_is_told(tank):
    # The program that the fixture built: through cargo, program and library would be built in turns, each time anew.
    done = subprocess.run([PROGRAM.with_name("own-model"), "--add", "win65=tank.dll"], cwd=ROOT, capture_output=True, text=True)
    assert done.returncode == 2 and "the platforms are linux64" in done.stderr
