"""The Reference FMUs of the FMI project: each version and both kinds by `orchestrator simulate`, against their published
results and fmpy (Co-Simulation), and against closed forms and converged solutions (Model Exchange). Prints a
line each; the exit code is 1 when a result is wrong.

    scripts/evidence/reference-fmus FOLDER [--write]

FOLDER is a checkout of github.com/modelica/Reference-FMUs, which is built here by cmake, or an unpacked release of it
(the folders 2.0 and 3.0 with FMUs; published results are then left out). Fetches nothing. `--write` writes
docs/evidence/reference-fmus.csv."""

import argparse
import csv
import math
import re
import subprocess
import sys
import tempfile
import zipfile
from pathlib import Path

import fmpy
import numpy as np
from scipy.integrate import solve_ivp

from supervised import PROGRAM

ROOT = Path(__file__).parents[2]
TABLE = ROOT / "docs/evidence/reference-fmus.csv"
TOLERANCE = 1e-10
# Model Exchange, relative to the largest value; bounces, s.
MOST, MOST_LATE = 1e-6, 1e-9
GRAVITY, RESTITUTION, SLOWEST = 9.81, 0.7, 0.1


class Wrong(Exception):
    """A result that is not what it must be."""


def build(folder, version, into):
    """The FMUs of a version, by cmake where the folder holds the sources."""
    if not (folder / "CMakeLists.txt").is_file():
        found = folder / f"{version}.0"
        return found if found.is_dir() else sys.exit(f"{folder}: neither CMakeLists.txt nor a folder {version}.0 is there")
    for command in (["cmake", "-S", folder, "-B", into, f"-DFMI_VERSION={version}", "-DCMAKE_BUILD_TYPE=Release",
                     "-DCMAKE_C_FLAGS=-Wno-stringop-truncation"], ["cmake", "--build", into]):
        done = subprocess.run(command, capture_output=True, text=True)
        if done.returncode:
            sys.exit(f"{' '.join(map(str, command))}:\n{done.stdout[-2000:]}{done.stderr[-2000:]}")
    return into / "fmus"


def exchange_only(fmu, to):
    """A copy for Model Exchange alone, with a tight tolerance: else Co-Simulation would be run."""
    with zipfile.ZipFile(fmu) as original, zipfile.ZipFile(to, "w") as copy:
        for name in dict.fromkeys(original.namelist()):
            content = original.read(name)
            if name == "modelDescription.xml":
                content = re.sub(rb"<CoSimulation\b[^>]*?(/>|>.*?</CoSimulation>)", b"", content, flags=re.S)
                content = re.sub(rb'(<DefaultExperiment[^>]*) tolerance="[^"]*"', rb"\1", content)
                content = content.replace(b"<DefaultExperiment", b'<DefaultExperiment tolerance="%g"' % TOLERANCE, 1)
            copy.writestr(name, content)
    return to


def column(cells):
    """Numbers where they are numbers."""
    try:
        return np.array([float(cell) for cell in cells])
    except ValueError:
        return np.array(cells)


def read(path):
    """A table by names without units."""
    with open(path) as lines:
        head, *rows = csv.reader(lines)
    return {name.split(" [")[0]: column(cells) for name, cells in zip(head, zip(*rows), strict=True)}


def simulate(fmu, folder, *options):
    """The orchestrator's trajectory."""
    file = folder / "trajectory.csv"
    done = subprocess.run([PROGRAM, "simulate", fmu, *map(str, options), "--output", file], capture_output=True, text=True)
    if done.returncode:
        raise Wrong(done.stderr.strip().splitlines()[0])
    return read(file)


def flat(name, values):
    """fmpy's column, an array by its elements."""
    if values.ndim == 1:
        return {name: values}
    return {f"{name}[{index + 1}]": part for index, part in enumerate(values.reshape(len(values), -1).T)}


def with_fmpy(fmu, got, step, signals=None):
    """Compares a Co-Simulation with fmpy's, bit for bit."""
    start, stop = float(got["time"][0]), float(got["time"][-1])
    names = [v.name for v in fmpy.read_model_description(str(fmu), validate=False).modelVariables if v.causality == "output"]
    result = fmpy.simulate_fmu(str(fmu), validate=False, fmi_type="CoSimulation", start_time=start, stop_time=stop,
                               output_interval=step, input=signals, output=names)
    expected = {key: part for name in result.dtype.names for key, part in flat(name, result[name]).items()}
    compared = 0
    for name in set(got) & set(expected) - {"time"}:
        one, other = got[name], expected[name]
        if one.dtype.kind != "f":
            other = np.array([cell.decode() if isinstance(cell, bytes) else str(cell) for cell in other])
        else:
            other = other.astype(float)
        if len(one) != len(other) or not np.array_equal(one, other):
            raise Wrong(f"{name} is not fmpy's")
        compared += 1
    if not compared:
        raise Wrong("nothing could be compared with fmpy")
    return f"{compared} outputs equal to fmpy bit for bit"


def with_published(path, got):
    """Whether a trajectory is the published one, to 1e-12 of its largest value."""
    expected = read(path)
    for name in set(got) & set(expected):
        one, other = got[name], expected[name]
        # Booleans and names of enumerations are written otherwise there.
        if other.dtype.kind != "f":
            one, other = ("\n".join(map(str, values)).lower().replace("true", "1.0").replace("false", "0.0") for values in (one, other))
            if one != other:
                return False
            continue
        same = np.array_equal(one, other) if one.dtype.kind != "f" else (
            len(one) == len(other) and np.abs(one - other).max() <= 1e-12 * max(1.0, np.abs(other).max()))
        if not same:
            return False
    return True


def ball(time):
    """When the last bounce was, the speed just after it, and the number of bounces: the ball of the Reference FMUs."""
    at, speed, count = math.sqrt(2 / GRAVITY), math.sqrt(2 * GRAVITY), 0
    if time < at:
        return 0.0, 0.0, 0
    while True:
        count, speed = count + 1, RESTITUTION * speed
        if speed < SLOWEST:
            return at, 0.0, count
        if time < at + 2 * speed / GRAVITY:
            return at, speed, count
        at += 2 * speed / GRAVITY


def worst(got, expected):
    """The largest difference relative to the largest value."""
    return np.abs(got - expected).max() / max(np.abs(expected).max(), 1e-300)


def within(error, most=MOST):
    if not error <= most:
        raise Wrong(f"{error:.1e} away")
    return f"{error:.1e}"


def judge_ball(got):
    late, error, most = 0.0, 0.0, 0
    for time, height, speed in zip(got["time"], got["h"], got["v"]):
        at, after, count = ball(time)
        most = max(most, count)
        if after > 0:
            # The flight's speed tells when it began.
            late = max(late, abs(time - (after - speed) / GRAVITY - at))
        exact = 0.0 if count and not after else 1 - 0.5 * GRAVITY * time**2 if not count else (
            after * (time - at) - 0.5 * GRAVITY * (time - at) ** 2)
        error = max(error, abs(height - exact))
    return f"closed form: {within(error)}; {most} bounces, each within {within(late, MOST_LATE)} s"


def judge_oscillator(got):
    exact = solve_ivp(lambda _, x: [x[1], (1 - x[0] ** 2) * x[1] - x[0]], (0, got["time"][-1]), [2, 0], "DOP853",
                      t_eval=got["time"], rtol=3e-14, atol=1e-14).y
    return f"DOP853: {within(max(worst(got['x0'], exact[0]), worst(got['x1'], exact[1])))}"


def judge_roberts(got):
    def rates(_, y):
        third = 1 - y[0] - y[1]
        first = -0.04 * y[0] + 1e4 * y[1] * third
        return [first, -first - 3e7 * y[1] ** 2]

    times = got["time"]
    exact = solve_ivp(rates, (times[0], times[-1]), [1, 0], "Radau", t_eval=times, rtol=1e-12, atol=1e-16).y
    return f"Radau: {within(max(worst(got['y1'], exact[0]), worst(got['y2'], exact[1])))} until {times[-1]:g} s"


def judge_spaces(got):
    exact = np.exp(got["time"])
    return f"closed form: {within(max(worst(got[f'y[{row}]'], row * exact) for row in (1, 2, 3)))}, three elements of an array"


def judge_stair(got):
    if not np.array_equal(got["counter"], np.floor(got["time"] + 1e-9) + 1):
        raise Wrong("it counts at other times")
    return f"exact, until it ends by itself at {got['time'][-1]:g} s"


EXCHANGE = {
    "BouncingBall": judge_ball,
    "Dahlquist": lambda got: f"closed form: {within(worst(got['x'], np.exp(-got['time'])))}",
    "Resource": lambda got: within(np.abs(got["y"] - 97).max(), 0) and "exact",
    "Roberts": judge_roberts,
    "Stair": judge_stair,
    "StateSpace": judge_spaces,
    "VanDerPol": judge_oscillator,
}
# Its own Euler method makes a million steps a second: the 1e8 s that it suggests would take months.
OPTIONS = {("Roberts", "CS"): ["--start", 0, "--stop", 0.5, "--step", 0.01],
           ("Roberts", "ME"): ["--start", 0, "--stop", 40, "--step", 0.4],
           "StateSpace": ["--stop", 10, "--step", 1], "Feedthrough": ["--stop", 2, "--step", 0.1],
           "Resource": ["--stop", 1, "--step", 1]}


def feed(fmu, folder):
    """Inputs for each number of Feedthrough: a triangle for the continuous one, steps for the others."""
    description = fmpy.read_model_description(str(fmu), validate=False)
    names = [v.name for v in description.modelVariables if v.causality == "input" and v.type not in ("String", "Binary")]
    # Two rows of one time are a jump; an enumeration has the items 1 and 2.
    rows = [[time, *(time * 3 if "continuous" in n else
                     high + n.startswith("Enumeration") for n in names)]
            for time, high in ((0.0, 0), (1.0, 0), (1.0, 1), (2.0, 1))]
    file = folder / "inputs.csv"
    with file.open("w", newline="") as lines:
        csv.writer(lines).writerows([["time", *names], *rows])
    return file, names


def judge_feedthrough(fmu, folder):
    file, names = feed(fmu, folder)
    got = simulate(fmu, folder, *OPTIONS["Feedthrough"], "--input", file)
    for name in names:
        output = name.replace("input", "output")
        # The row of a communication point has what the inputs gave until then: a jump at 1 s shows in the row after it.
        exact = 3 * got["time"] if "continuous" in name else (got["time"] > 1 + 1e-9) + float(
            name.startswith("Enumeration"))
        if output in got and np.abs(got[output] - exact).max() > (1e-6 if "32" in name else 1e-12):
            raise Wrong(f"{output} is not {name}")
    return f"{len(names)} inputs come out as they go in"


def co_simulation(fmu, published, folder):
    name = fmu.stem
    options = OPTIONS.get((name, "CS"), OPTIONS.get(name, []))
    got = simulate(fmu, folder, *options)
    words = [with_fmpy(fmu, got, float(got["time"][1] - got["time"][0]))]
    # The published file of Roberts is BouncingBall's.
    if published.is_file() and name != "Roberts" and with_published(published, got):
        words.append("equal to the published file")
    return "; ".join(words)


def model_exchange(fmu, folder):
    name = fmu.stem
    copy = exchange_only(fmu, folder / fmu.name)
    if name == "Feedthrough":
        return judge_feedthrough(copy, folder)
    return EXCHANGE[name](simulate(copy, folder, *OPTIONS.get((name, "ME"), OPTIONS.get(name, []))))


def refused(fmu, folder):
    try:
        simulate(fmu, folder)
    except Wrong as error:
        why = str(error)
        if "Scheduled Execution" in why:
            return "refused: it has Scheduled Execution only"
        raise
    raise Wrong("clocks are not refused")


def attempt(function, *parameters):
    """What is to be said, and whether all is right."""
    try:
        return function(*parameters), True
    except Wrong as error:
        return f"WRONG: {error}", False


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--write", action="store_true")
    given = parser.parse_args()
    lines, right = [["Reference FMU", "FMI", "Co-Simulation", "Model Exchange"]], True
    with tempfile.TemporaryDirectory() as temporary:
        folder = Path(temporary)
        for version in (2, 3):
            for fmu in sorted(build(given.folder.resolve(), version, folder / f"build-{version}").glob("*.fmu")):
                published = given.folder / fmu.stem / f"{fmu.stem}_out.csv"
                if fmu.stem == "Clocks":
                    results = [attempt(refused, fmu, folder)] * 2
                else:
                    results = [attempt(co_simulation, fmu, published, folder), attempt(model_exchange, fmu, folder)]
                right &= all(good for _, good in results)
                lines.append([fmu.stem, f"{version}.0", results[0][0], results[1][0]])
                print(*lines[-1], sep=" | ")
    if given.write:
        with TABLE.open("w", newline="") as file:
            csv.writer(file, lineterminator="\n").writerows(lines)
    return 0 if right else 1


if __name__ == "__main__":
    sys.exit(main())
