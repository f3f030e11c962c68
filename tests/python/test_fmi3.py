"""The FMUs of FMI 3.0: the same model, the same variables, the same results as in FMI 2.0."""

import contextlib
import subprocess
import zipfile

import fmpy
import fmpy.validation
import numpy as np
import pytest
from conftest import ROOT
from fmpy.fmi3 import FMU3Slave
from lxml import etree
from python_package import PROGRAM

OUTPUTS = ["sensor.loadForce", "sensor.frictionTorque", "sensor.bearingTemperature",
           "bearing.eccentricityRatio", "drive.angle"]
TIME = 2**31 - 1
TYPES = {"Float64": "Real", "Int32": "Integer"}


@pytest.fixture(scope="module")
def fmu3(fmu):
    path = fmu.with_name("PlainBearingStand-fmi3.fmu")
    assert path.is_file(), f"{path} is missing: run scripts/package-fmu first"
    return path


@pytest.fixture(scope="module")
def description3(fmu3):
    return fmpy.read_model_description(str(fmu3), validate=True)


def test_the_terminals_join_variables(fmu3, description3):
    with zipfile.ZipFile(fmu3) as archive:
        tree = etree.fromstring(archive.read("terminalsAndIcons/terminalsAndIcons.xml"))
    terminals = [[member.get("variableName") for member in one] for one in tree.iter("Terminal")]
    known = {variable.name for variable in description3.modelVariables}
    assert len(terminals) == 3 and all(terminals) and known.issuperset(sum(terminals, []))


@pytest.fixture
def make3(fmu3, description3, tmp_path):
    """Makes instances at their start, and frees them at the end."""
    folder = fmpy.extract(str(fmu3), str(tmp_path))
    names = {v.name: v.valueReference for v in description3.modelVariables}
    with contextlib.ExitStack() as stack:
        def make(film=1, **options):
            instance = FMU3Slave(guid=description3.guid, unzipDirectory=folder, instanceName="stand",
                                 modelIdentifier=description3.coSimulation.modelIdentifier)
            instance.instantiate(**options)
            stack.callback(instance.freeInstance)
            instance.setInt64([names["bearing.film"]], [film])
            instance.enterInitializationMode(startTime=0.0)
            instance.exitInitializationMode()
            return instance
        yield make


@pytest.fixture
def stand3(make3):
    return make3()


def test_the_validator_finds_nothing(fmu3):
    assert fmpy.validation.validate_fmu(str(fmu3)) == []


def test_variables_are_those_of_fmi_2(description, description3):
    time, *variables = description3.modelVariables
    assert (time.name, time.causality, time.valueReference) == ("time", "independent", TIME)
    assert len(variables) == len(description.modelVariables)
    for two, three in zip(description.modelVariables, variables):
        assert TYPES.get(three.type, three.type) == two.type
        for attribute in ("name", "valueReference", "description", "causality", "variability", "initial", "unit",
                          "displayUnit", "min", "max", "nominal", "start"):
            assert getattr(three, attribute) == getattr(two, attribute), (two.name, attribute)


def test_capabilities_are_those_that_are_there(fmu3):
    root = etree.fromstring(zipfile.ZipFile(fmu3).read("modelDescription.xml"))
    assert root.find("ModelExchange") is None and root.find("ScheduledExecution") is None
    true = {"canGetAndSetFMUState", "canSerializeFMUState", "providesDirectionalDerivatives",
            "providesAdjointDerivatives", "canHandleVariableCommunicationStepSize", "providesIntermediateUpdate",
            "mightReturnEarlyFromDoStep", "canReturnEarlyAfterIntermediateUpdate"}
    expected = {name: "true" for name in true} | {"hasEventMode": "false"}
    assert dict(root.find("CoSimulation").attrib) == {
        **expected, "modelIdentifier": "PlainBearingStand", "maxOutputDerivativeOrder": "1"}
    marked = [v.get("name") for v in root.find("ModelVariables") if v.get("intermediateUpdate")]
    continuous = [v.get("name") for v in root.find("ModelVariables").iter("Float64")
                  if v.get("causality") in ("input", "output")]
    assert marked == continuous and len(marked) > 20


def test_files_are_those_of_fmi_2_but_for_binaries_icon_and_terminals(fmu, fmu3):
    def files(path):
        with zipfile.ZipFile(path) as archive:
            return {name: archive.read(name) for name in archive.namelist()}
    two, three = files(fmu), files(fmu3)
    assert two.pop("binaries/linux64/PlainBearingStand.so") == three.pop("binaries/x86_64-linux/PlainBearingStand.so")
    assert two.pop("modelDescription.xml") != three.pop("modelDescription.xml")
    two.pop("model.png")
    # FMI Library refuses terminals of FMI 3.0 in an FMU of FMI 2.0.
    assert not any(name.startswith("terminalsAndIcons/") for name in two)
    ours = [name for name in two if not name.startswith("binaries/")]
    assert {name: two[name] for name in ours} == {
        n: c for n, c in three.items() if not n.startswith(("binaries/", "terminalsAndIcons/"))}


@pytest.mark.parametrize(("film", "stop", "step"), [(1, 2.0, 0.01), (2, 0.2, 0.002), (1, 30.0, 5.0)])
def test_results_are_those_of_fmi_2_to_the_last_bit(fmu, fmu3, film, stop, step):
    """Resolved steps with both films, and leaps; with an input that changes."""
    times = np.linspace(0.0, stop, 5)
    speed = np.array(list(zip(times, 31.4 + np.sin(times))), dtype=[("time", float), ("drive.speed", float)])
    results = [fmpy.simulate_fmu(str(path), stop_time=stop, output_interval=step, output=OUTPUTS, input=speed,
                                 start_values={"bearing.film": film})
               for path in (fmu, fmu3)]
    assert len(results[0]) == len(results[1]) > 5
    for name in ["time", *OUTPUTS]:
        assert results[0][name].tobytes() == results[1][name].tobytes(), name


def test_states_go_back_and_to_bytes(stand3, description3):
    names = {v.name: v.valueReference for v in description3.modelVariables}
    references = [names[name] for name in OUTPUTS]
    def run(first, last):
        for i in range(first, last):
            stand3.doStep(i * 0.01, 0.01)
        return stand3.getFloat64(references)
    run(0, 20)
    state = stand3.getFMUState()
    data = stand3.serializeFMUState(state)
    expected = run(20, 40)
    stand3.setFMUState(state)
    assert stand3.getFloat64([TIME]) == [pytest.approx(0.2)]
    assert run(20, 40) == expected
    copy = stand3.deserializeFMUState(data)
    stand3.setFMUState(copy)
    assert run(20, 40) == expected
    for one in (state, copy):
        stand3.freeFMUState(one)


@pytest.mark.parametrize(("film", "step", "updates", "error"), [
    (1, 0.5, (100, 1000), 1e-6),   # the steps of the time integration
    (2, 0.05, (25, 25), 1e-12),    # those of the Reynolds film, none longer than 2 ms
    (1, 30.0, (1, 1), 0.0),        # a leap
])
def test_a_host_looks_into_a_step(make3, description3, film, step, updates, error):
    """The results are those of a host that does not look, to the tolerance of the time integration or better."""
    names = {v.name: v.valueReference for v in description3.modelVariables}
    references = [names[name] for name in OUTPUTS]
    seen, told = [], []

    def look(_, time, set_requested, get_allowed, finished, can_return, requested, at):
        told.append((set_requested, get_allowed, finished, can_return))
        seen.append((time, *watched.getFloat64(references)))

    watched = make3(film, intermediateUpdate=look, requiredIntermediateVariables=references)
    plain = make3(film)
    assert watched.doStep(0.0, step) == plain.doStep(0.0, step) == (False, False, False, step)
    assert updates[0] <= len(seen) <= updates[1]
    assert told == [(True, True, True, False)] * (len(seen) - 1) + [(False, True, True, False)]
    times = [row[0] for row in seen]
    assert times == sorted(set(times)) and times[-1] == step
    assert list(seen[-1][1:]) == watched.getFloat64(references) == pytest.approx(plain.getFloat64(references), rel=error, abs=0.0)


def test_a_host_ends_a_step_where_it_wants(make3, description3):
    """It stops after the inner step in which the shaft has turned by a radian, then at a time between two inner steps."""
    angle = [v.valueReference for v in description3.modelVariables if v.name == "drive.angle"]

    def look(_, time, set_requested, get_allowed, finished, can_return, requested, at):
        if can_return and time < first and watched.getFloat64(angle)[0] > 1.0:
            requested[0], at[0] = True, time
        elif can_return and time > first:
            requested[0], at[0] = True, 0.1234

    first = np.inf
    watched = make3(intermediateUpdate=look, earlyReturnAllowed=True, requiredIntermediateVariables=angle)
    *_, early, first = watched.doStep(0.0, 0.5)
    assert early and 1.0 < watched.getFloat64(angle)[0] < 1.2
    *_, early, reached = watched.doStep(first, 0.5 - first)
    assert early and reached == 0.1234
    assert watched.getFloat64(angle) == pytest.approx([0.1234 * 10 * np.pi], rel=1e-12)
    assert watched.doStep(reached, 1e-5)[2:] == (False, reached + 1e-5)


def test_the_lag_becomes_an_fmu_of_fmi_3(tmp_path):
    file = tmp_path / "Lag-fmi3.fmu"
    command = ["cargo", "run", "--locked", "--package", "lag", "--", "--profile", "dev", "--fmi", "3", "--output", file]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert "x86_64-linux" in done.stdout
    assert fmpy.validation.validate_fmu(str(file)) == []
    result = fmpy.simulate_fmu(str(file), stop_time=1.0, output_interval=0.1, start_values={"input": 3.0})
    assert result["output"] == pytest.approx(6.0 - 5.0 * np.exp(-result["time"] / 0.5), abs=1e-13)


def test_the_orchestrator_takes_it(fmu, fmu3, tmp_path):
    """No finding, and the same points as with FMI 2.0."""
    done = subprocess.run([PROGRAM, "check", fmu3], capture_output=True, text=True)
    assert done.returncode == 0 and done.stdout.endswith("nothing found\n"), done.stdout
    done = subprocess.run([PROGRAM, "inspect", fmu3], capture_output=True, text=True, check=True)
    assert "FMI 3.0 for Co-Simulation" in done.stdout
    points = []
    for file in (fmu, fmu3):
        output = tmp_path / file.stem
        done = subprocess.run([PROGRAM, "verify", ROOT / "studies/paper-table3.toml", "--fmu", file, "--points", "4", "--seed",
                               "1", "--output", output], capture_output=True, text=True)
        assert done.returncode in (0, 1), done.stderr
        points.append((output / "points.csv").read_text())
    assert points[0] == points[1] and points[0].count("\n") == 5
