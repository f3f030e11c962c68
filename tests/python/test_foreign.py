"""FMUs that nobody here wrote: OpenModelica's, as gemseo-fmu ships them, and one of pythonfmu. Points of studies,
on reused instances in worker processes, against fmpy, which makes a new instance for every run."""

import json
import os
import subprocess
import sys
import sysconfig
from pathlib import Path

import fmpy
import pytest

from reference_fmus import exchange_only
from test_acceptance import PROGRAM, ROOT, rows

# Three for each of two workers.
POINTS = 6
PACKAGE = "gemseo-fmu==3.1.1"
FOLDER = ROOT / ".venv" / "foreign"
# Parameters with their ranges, and outputs.
CASES = {
    "Mass_Damper": ({"mass.m": (0.5, 2), "spring.c": (5000, 20000), "damper.d": (2, 20), "f": (0, 5)}, ["y"]),
    "MassSpringSystem": ({"k1": (0.5, 2), "k2": (0.5, 2), "m1": (0.5, 3)}, ["x1", "x2", "v1", "v2"]),
    "ramp": ({"ramp.height": (1, 5), "ramp.duration": (0.3, 2), "ramp.offset": (-1, 1)}, ["out"]),
    "add": ({"add.k1": (-2, 2), "add.k2": (-2, 2), "u1": (1, 9), "u2": (1, 9)}, ["y"]),
}


@pytest.fixture(scope="session")
def foreign():
    """The folder of the FMUs; the package comes without the many others that it would like to have."""
    folder = FOLDER / "gemseo_fmu" / "problems" / "fmu_files" / "linux"
    if not folder.is_dir():
        subprocess.run([sys.executable, "-m", "pip", "install", "--quiet", "--no-deps", "--target", FOLDER, PACKAGE],
                       check=True)
    return folder


def study(fmu, parameters, outputs):
    text = f"fmu = {json.dumps(str(fmu))}\n[simulation]\nstop = 1\nstep = 0.01\n"
    text += f"[design]\nmethod = 'latin-hypercube'\npoints = {POINTS}\n"
    for name, (low, high) in parameters.items():
        text += f"[parameters.{json.dumps(name)}]\ndistribution = 'uniform'\nmin = {low}\nmax = {high}\n"
    for name in outputs:
        text += f"[criteria.{name}]\nvariable = '{name}'\nnominal = 0\ntolerance = 1e9\n"
    return text


def compare(fmu, parameters, outputs, folder, environment=None):
    """Every point of a study against fmpy; returns how many."""
    (folder / "study.toml").write_text(study(fmu, parameters, outputs))
    command = [PROGRAM, "verify", folder / "study.toml", "--output", folder / "out", "--jobs", "2"]
    done = subprocess.run(command, capture_output=True, text=True, env=environment)
    assert done.returncode == 0, done.stderr
    points = rows(folder / "out" / "points.csv")
    for point in points:
        values = {name: float(point[name]) for name in parameters}
        end = fmpy.simulate_fmu(str(fmu), start_values=values, output=outputs, stop_time=1.0, step_size=0.01,
                                output_interval=0.01)[-1]
        assert point["status"] == "ok"
        for name in outputs:
            assert float(point[name]) == pytest.approx(end[name], rel=1e-12, abs=1e-14), (point["point"], name)
    return len(points)


@pytest.mark.parametrize("name", CASES)
def test_openmodelica(foreign, tmp_path, name):
    assert compare(foreign / f"{name}.fmu", *CASES[name], tmp_path) == POINTS


@pytest.mark.parametrize("name", CASES)
def test_openmodelica_by_model_exchange(foreign, tmp_path, name):
    """The same FMUs without their own solver, against CVode at a tighter tolerance."""
    parameters, outputs = CASES[name]
    fmu = exchange_only(foreign / f"{name}.fmu", tmp_path / f"{name}.fmu")
    (tmp_path / "study.toml").write_text(study(fmu, parameters, outputs))
    subprocess.run([PROGRAM, "verify", tmp_path / "study.toml", "--output", tmp_path / "out", "--jobs", "2"],
                   capture_output=True, check=True)
    points = rows(tmp_path / "out" / "points.csv")
    assert [point["status"] for point in points] == ["ok"] * POINTS
    for point in points:
        values = {name: float(point[name]) for name in parameters}
        end = fmpy.simulate_fmu(str(fmu), fmi_type="ModelExchange", start_values=values, output=outputs, stop_time=1.0,
                                output_interval=0.01, relative_tolerance=1e-12)[-1]
        for name in outputs:
            assert float(point[name]) == pytest.approx(end[name], rel=1e-6, abs=1e-8), (point["point"], name)


MODEL = '''
from pythonfmu import Fmi2Causality, Fmi2Slave, Fmi2Variability, Real


class Cooling(Fmi2Slave):
    def __init__(self, **kwargs):
        super().__init__(**kwargs)
        self.rate = 1.0
        self.temperature = 100.0
        self.register_variable(Real("rate", causality=Fmi2Causality.parameter, variability=Fmi2Variability.tunable))
        self.register_variable(Real("temperature", causality=Fmi2Causality.output))

    def do_step(self, time, step):
        self.temperature += step * self.rate * (20.0 - self.temperature)
        return True
'''


def test_pythonfmu(tmp_path):
    """FMUs that embed Python find its library when it is loaded beforehand."""
    library = Path(sysconfig.get_config_var("LIBDIR")) / (sysconfig.get_config_var("LDLIBRARY") or "")
    if library.suffix != ".so" or not library.is_file():
        pytest.skip("this Python has no shared library")
    (tmp_path / "cooling.py").write_text(MODEL)
    subprocess.run([sys.executable, "-m", "pythonfmu", "build", "-f", "cooling.py"], cwd=tmp_path, check=True,
                   capture_output=True)
    path = os.pathsep.join([sysconfig.get_path("purelib"), sysconfig.get_path("platlib")])
    environment = {**os.environ, "LD_PRELOAD": str(library), "PYTHONPATH": path}
    assert compare(tmp_path / "Cooling.fmu", {"rate": (0.1, 2)}, ["temperature"], tmp_path, environment) == POINTS
    done = subprocess.run([PROGRAM, "simulate", tmp_path / "Cooling.fmu"], capture_output=True, text=True)
    assert done.returncode == 2 and "LD_PRELOAD" in done.stderr
