"""The FMUs for Model Exchange: other solvers integrate the stand, and come to what Co-Simulation gives."""

import csv
import re
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


# The rig, fine asperities, and the paper's first calibration, whose film is thick and stays next to the centre.
@pytest.mark.parametrize("parameters", [{}, {"bearing.roughness": 1e-7}, {"bearing.roughness": 0.0, "oil.viscosityScale": 70.71}])
def test_a_solver_with_its_defaults_starts_in_the_centre(exchange, fmu, parameters):
    """With the implicit CVode of fmpy, which differentiates by differences where every run starts."""
    outputs = ["bearing.eccentricityRatio", "sensor.frictionPower"]
    expected, result = (
        fmpy.simulate_fmu(str(path), fmi_type=of, start_values=parameters, stop_time=0.5, output_interval=0.05, output=outputs)
        for path, of in [(fmu, "CoSimulation"), (exchange, "ModelExchange")])
    for name in outputs:
        assert result[name][1:] == pytest.approx(expected[name][1:], rel=0.002), name


@pytest.mark.parametrize("solver", ["Euler", "CVode"])
def test_limits_are_told_at_each_step_of_a_solver(exchange, fmu, solver, monkeypatch):
    """One that only the largest of the pressures between the outputs passes; as by Co-Simulation in one step. fmpy completes one
    step an output where it asks CVode for outputs, but each where it asks for CVode's steps, as FMI wants."""
    monkeypatch.setattr("fmpy.sundials.CV_NORMAL", 2)
    outputs = ["status.validity", "bearing.maxFilmPressure"]

    def run(path, step, **options):
        return fmpy.simulate_fmu(str(path), stop_time=0.6, output_interval=step, output=outputs, start_values=values, **options)

    values = {"load.eccentricity": 1e-3, "load.phase": 0.0, "bearing.roughness": 0.0}
    pressures = run(fmu, 1e-3)[outputs[1]]
    values["bearing.pressureLimit"] = 0.5 * (pressures[1:].max() + pressures[[0, -1]].max())
    expected, result = run(fmu, 0.6), run(exchange, 0.6, solver=solver, step_size=1e-4)
    assert expected[outputs[1]].max() < values["bearing.pressureLimit"]
    assert result[outputs[0]][-1] == expected[outputs[0]][-1] == 4


def trajectory(fmu, file):
    """Of `orchestrator simulate` over 1 s, by name."""
    subprocess.run([PROGRAM, "simulate", fmu, "--stop", "1", "--step", "0.05", "--output", file], check=True,
                   capture_output=True)
    with file.open() as lines:
        names = [key.split(" ")[0] for key in next(csv.reader(lines))]
    return dict(zip(names, np.loadtxt(file, delimiter=",", skiprows=1).T))


def with_tolerance(fmu, tolerance, to):
    """A copy whose description suggests another tolerance."""
    with zipfile.ZipFile(fmu) as original, zipfile.ZipFile(to, "w") as copy:
        for name in original.namelist():
            content = original.read(name)
            if name == "modelDescription.xml":
                content, changed = re.subn(rb'(<DefaultExperiment[^>]* tolerance=)"[^"]*"', rb'\1"%s"' % tolerance, content)
                assert changed == 1
            copy.writestr(name, content)
    return to


def test_our_own_importer_takes_it(exchange, expected, tmp_path):
    done = subprocess.run([PROGRAM, "check", exchange], capture_output=True, text=True)
    assert done.returncode == 0 and done.stdout.endswith("nothing found\n"), done.stdout
    result = trajectory(exchange, tmp_path / "run.csv")
    for name in OUTPUTS:
        # The tolerance that the description suggests is 1e-6 a step.
        assert result[name][-1] == pytest.approx(expected[name][-1], rel=1e-4), name


def test_our_own_importer_comes_to_the_same(exchange, expected, tmp_path):
    """With a tight tolerance, from the first instant on; relative to the largest value. The difference shrinks with the
    tolerance: it is the solver's error."""
    worst = []
    for tolerance in (b"1e-8", b"1e-10"):
        result = trajectory(with_tolerance(exchange, tolerance, tmp_path / "tight.fmu"), tmp_path / "run.csv")
        assert result["time"] == pytest.approx(expected["time"], abs=1e-12)
        worst.append(max(np.abs(result[name] - expected[name]).max() / np.abs(expected[name]).max() for name in OUTPUTS))
    assert worst[0] < 1e-6 and worst[1] < 1e-8, worst


STUDY = """
fmu = "{fmu}"
[simulation]
stop = 0.2
step = 0.05
[design]
method = "sobol"
points = 12
seed = 1
[parameters."bearing.radialClearance"]
distribution = "uniform"
min = 0.015
max = 0.025
unit = "mm"
[criteria.P]
variable = "sensor.frictionPower"
nominal = 14
tolerance = "50 %"
"""


def test_points_are_the_same_however_they_are_run(fmu, tmp_path):
    """One worker or two, processes of many points or of one, killed and resumed."""
    study = tmp_path / "study.toml"
    study.write_text(STUDY.format(fmu=fmu.with_name("PlainBearingStand-me-fmi3.fmu")))

    def command(name, *options):
        return [PROGRAM, "verify", study, "--output", tmp_path / name, *options]

    def points(name, *options):
        done = subprocess.run(command(name, *options), capture_output=True, text=True)
        assert done.returncode in (0, 1), done.stderr
        return (tmp_path / name / "points.csv").read_bytes()

    one = points("one", "--jobs", "1", "--isolation", "fresh")
    assert one.count(b",ok\n") == 12
    assert points("two", "--jobs", "2", "--isolation", "shared") == one
    # As a kill leaves it: the head and four points.
    journal = (tmp_path / "two/journal.txt").read_text().splitlines(keepends=True)
    (tmp_path / "killed").mkdir()
    (tmp_path / "killed/journal.txt").write_text("".join(journal[:5]))
    assert points("killed", "--jobs", "2", "--resume") == one


def test_the_film_that_steps_itself_is_refused(exchange, capfd):
    with pytest.raises(Exception, match="(?i)initiali[sz]ation"):
        fmpy.simulate_fmu(str(exchange), fmi_type="ModelExchange", stop_time=0.1, start_values={"bearing.film": 2},
                          debug_logging=True)


def test_the_lag_is_exchanged(tmp_path):
    program = ["cargo", "run", "--locked", "--package", "lag", "--"]
    for version in ("2", "3"):
        file = tmp_path / f"Lag{version}.fmu"
        options = ["--profile", "dev", "--exchange", "--fmi", version, "--output", file]
        done = subprocess.run([*program, *options], cwd=ROOT, capture_output=True, text=True)
        assert done.returncode == 0, done.stderr
        # Through cargo, program and library would be built in turns, each time anew.
        program = [PROGRAM.with_name("lag")]
        assert fmpy.validation.validate_fmu(str(file)) == []
        root = etree.fromstring(zipfile.ZipFile(file).read("modelDescription.xml"))
        assert root.find("ModelExchange") is not None and root.find("CoSimulation") is None
        result = fmpy.simulate_fmu(str(file), stop_time=1.0, output_interval=0.1, start_values={"input": 3.0},
                                   relative_tolerance=1e-9)
        assert result["output"] == pytest.approx(6.0 - 5.0 * np.exp(-result["time"] / 0.5), abs=1e-7)
        # Driven by a sine in straight lines of 10 ms, with communication steps of 0.2 s: 0.5 y' = 2 u - y, exactly. An importer
        # that holds the input over a step is up to 0.4 off, a third of the largest value.
        times = np.arange(0, 2.0001, 0.01)
        sine = np.sin(2 * np.pi * times)
        table = tmp_path / f"sine{version}.csv"
        np.savetxt(table, np.column_stack([times, sine]), delimiter=",", header="time,input", comments="", fmt="%.17g")
        exact, decay = [1.0], np.exp(-0.01 / 0.5)
        for before, after in zip(sine[:-1], sine[1:], strict=True):
            slope = (after - before) / 0.01
            # y = 2 (u - 0.5 u') is a solution for an input that grows evenly.
            exact.append(2 * (after - 0.5 * slope) + (exact[-1] - 2 * (before - 0.5 * slope)) * decay)
        out = tmp_path / f"sine{version}.out.csv"
        subprocess.run([PROGRAM, "simulate", file, "--stop", "2", "--step", "0.2", "--input", table,
                        "--output", out], check=True, capture_output=True)
        with out.open() as lines:
            found = {round(float(row["time"]), 9): float(row["output"]) for row in csv.DictReader(lines)}
        assert len(found) == 11
        for time_, value in found.items():
            assert value == pytest.approx(exact[round(time_ / 0.01)], abs=1e-8)
