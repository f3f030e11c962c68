"""Fixtures for the tests of the packaged FMU."""

import contextlib
from pathlib import Path

import fmpy
import pytest
from fmpy.fmi2 import FMU2Slave

ROOT = Path(__file__).resolve().parent.parent.parent


@pytest.fixture(scope="session")
def fmu():
    """The packaged FMU."""
    path = ROOT / "dist" / "PlainBearingStand.fmu"
    assert path.is_file(), f"{path} is missing: run scripts/package-fmu first"
    return path


@pytest.fixture(scope="session")
def unpacked(fmu, tmp_path_factory):
    """The FMU's folder."""
    return Path(fmpy.extract(str(fmu), str(tmp_path_factory.mktemp("fmu"))))


@pytest.fixture(scope="session")
def description(fmu):
    return fmpy.read_model_description(str(fmu), validate=True)


@pytest.fixture(scope="session")
def references(description):
    """Value references by name."""
    return {variable.name: variable.valueReference for variable in description.modelVariables}


class FMU2Stand(FMU2Slave):
    """An instance that takes names. (fmpy wants its classes called so.)"""

    def __init__(self, folder, description, **options):
        super().__init__(guid=description.guid, unzipDirectory=str(folder),
                         modelIdentifier=description.coSimulation.modelIdentifier,
                         instanceName="stand")
        self.names = {v.name: v.valueReference for v in description.modelVariables}
        self.instantiate(**options)

    def start(self, stop=None, **values):
        """Initialises with values for variables, their names written with __ for dots."""
        self.setupExperiment(startTime=0.0, stopTime=stop)
        self.enterInitializationMode()
        for name, value in values.items():
            self.set(name.replace("__", "."), value)
        self.exitInitializationMode()
        return self

    def set(self, name, value):
        self.setReal([self.names[name]], [value])

    def get(self, *names):
        return self.getReal([self.names[name] for name in names])


@pytest.fixture
def stand(unpacked, description):
    """Makes instances, and frees them at the end."""
    with contextlib.ExitStack() as stack:
        def make(**options):
            instance = FMU2Stand(unpacked, description, **options)
            stack.callback(instance.freeInstance)
            return instance
        yield make


@pytest.fixture(scope="module")
def verified(tmp_path_factory):
    """A verification by the Python package."""
    from python_package import PAPER
    from fmu_orchestrator import Study
    folder = tmp_path_factory.mktemp("verified")
    return Study.load(PAPER).verify(points=60, seed=5, output=folder / "ours")
