"""Measures the orchestrator beside FMPy with SALib, OpenTURNS and gemseo-fmu, and writes the tables of docs/evidence/peers.md.

    scripts/evidence/peers [--rounds N] [--only TABLE]

Of each program's rounds, which take turns, the table has the median CPU and elapsed time. Fetches no FMU: the foreign one
comes with gemseo-fmu's wheel, and those that crash are tests/faulty."""

import argparse
import csv
import json
import math
import os
import re
import signal
import statistics
import subprocess
import sys
import tempfile
import threading
import time
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).parents[3]
HERE = ROOT / "scripts/evidence/peers.d"
PAGE = ROOT / "docs/evidence/peers.md"
PROGRAM = ROOT / "target/release/orchestrator"
STAND = ROOT / "dist/PlainBearingStand.fmu"
ENVIRONMENTS = ROOT / ".cache/peers"
OURS = "orchestrator"
PEERS = {"fmpy-salib": "FMPy, SALib", "openturns": "OpenTURNS, FMPy", "gemseo-fmu": "gemseo-fmu"}
BASE, BASE_OF_REFERENCE = 256, 2048
POINTS = 50
OUTPUT, PARAMETER = "sensor.frictionPower", "bearing.radialClearance"
# A program that does nothing for so long, or uses so much CPU for 50 points, will not end, s.
IDLE, BUSY = 15.0, 12.0
POINT_TIMEOUT = 5  # s, elapsed: `verify --point-timeout`
NUMBER = r"([-+]?[\d.]+(?:e[-+]?\d+)?)"


@dataclass(frozen=True)
class Run:
    """What a program used and said; `code` is None when it was stopped for want of an end."""
    elapsed: float
    cpu: float
    code: int | None
    said: str


def used_by(group):
    """The CPU time of the processes of a group and of their children that have ended, s."""
    ticks = 0
    for stat in Path("/proc").glob("[0-9]*/stat"):
        try:
            fields = stat.read_text().rpartition(")")[2].split()
        except OSError:
            continue
        if int(fields[2]) == group:
            ticks += sum(map(int, fields[11:15]))
    return ticks / os.sysconf("SC_CLK_TCK")


def watch(group, ended, late):
    """Kills a group of processes that has done nothing for IDLE seconds, or used more than BUSY seconds of CPU."""
    before, since = -1.0, time.monotonic()
    while not ended.wait(1):
        used = used_by(group)
        if used > before + 0.02:
            before, since = used, time.monotonic()
        if used > BUSY or time.monotonic() - since > IDLE:
            late.set()
            os.killpg(group, signal.SIGKILL)
            return


def run(command, watched=False):
    """Runs a program and all that it starts; a watched one is stopped when it seems to wait or loop for ever."""
    with tempfile.TemporaryFile("w+") as said:
        began = time.monotonic()
        child = subprocess.Popen(list(map(str, command)), stdout=said, stderr=subprocess.STDOUT, cwd=ROOT, start_new_session=True)
        ended, late = threading.Event(), threading.Event()
        watcher = threading.Thread(target=watch, args=(child.pid, ended, late))
        if watched:
            watcher.start()
        _, status, used = os.wait4(child.pid, 0)
        ended.set()
        child.returncode = os.waitstatus_to_exitcode(status)
        said.seek(0)
        return Run(time.monotonic() - began, used.ru_utime + used.ru_stime, None if late.is_set() else child.returncode, said.read())


def python(peer):
    return ENVIRONMENTS / peer / "bin/python"


def lines(path):
    """Lines that a user writes: neither empty nor only a comment or a docstring."""
    return sum(bool(line.strip()) and not re.match(r'\s*(#|""")', line) for line in path.read_text().splitlines())


def succeeded(done, codes=(0,)):
    if done.code not in codes:
        sys.exit(f"failed with {done.code}:\n{done.said[-3000:]}")
    return done


# The paper's study.

def papers(folder, rounds):
    """The runs of the paper's study, by tool; the orchestrator's are `verify` and `sensitivity`."""
    study = HERE / OURS / "paper.toml"
    commands = {peer: [[python(peer), HERE / peer / "paper.py"]] for peer in PEERS}
    commands[OURS] = [[PROGRAM, "verify", study, "--output", folder / "verify", "--force"],
                      [PROGRAM, "sensitivity", study, "--base", BASE, "--output", folder / "sensitivity", "--force"]]
    found = {name: [] for name in commands}
    for _ in range(rounds):
        for name, parts in commands.items():
            found[name].append([succeeded(run(command)) for command in parts])
    return found


def median(rounds, value):
    return statistics.median(sum(value(part) for part in parts) for parts in rounds)


def index(value, low, high):
    return f"{value:.3f} ({low:.3f} to {high:.3f})"


def said_index(peer, said, kind):
    """An index of the clearance on the friction power, with its interval, from what a peer printed."""
    row = next(line for line in said.splitlines() if line.startswith(f"{OUTPUT} {PARAMETER} "))
    if peer == "fmpy-salib":
        value, half = map(float, re.search(rf"{kind} {NUMBER} \+- {NUMBER}", row).groups())
        return index(value, value - half, value + half)
    return index(*map(float, re.search(rf"{kind} {NUMBER} {NUMBER} {NUMBER}", row).groups()))


def our_indices(file):
    """First and total index of the clearance on the friction power, with their intervals, in a finished analysis."""
    data = json.loads(file.read_text())
    found = next(output for output in data["outputs"] if output["name"] == "P_fr")["sobol"]
    at = data["parameters"].index(PARAMETER)
    return [index(*(found[kind][at][key] for key in ("value", "low", "high"))) for kind in ("first", "total")]


def percent(value, low, high):
    return f"{100 * value:.0f} % ({100 * low:.0f} to {100 * high:.0f} %)"


def share(peer, said):
    """How many of the points a peer accepted, and what it says of the share."""
    accepted = re.search(r"accepted: (\d+)", said).group(1)
    told = re.search(rf"share: {NUMBER} \+- {NUMBER}", said)
    if not told:
        return f"{accepted}; none"
    value, half = map(float, told.groups())
    return f"{accepted}; {percent(value, value - half, value + half)}"


def our_share(file):
    summary = json.loads(file.read_text())
    return f"{summary['verified']}; {percent(summary['verified_fraction'], *summary['verified_interval'])}"


def paper_table(folder, rounds):
    """The table of the paper's study."""
    found = papers(folder, rounds)
    reference = folder / "reference"
    succeeded(run([PROGRAM, "sensitivity", HERE / OURS / "paper.toml", "--base", BASE_OF_REFERENCE, "--output", reference, "--force"]))
    cpu = {name: median(parts, lambda part: part.cpu) for name, parts in found.items()}
    elapsed = {name: median(parts, lambda part: part.elapsed) for name, parts in found.items()}
    last = {name: parts[-1][-1].said for name, parts in found.items()}
    polynomial = re.search(rf"^{OUTPUT} {PARAMETER} .*polynomial {NUMBER}", last["openturns"], re.M).group(1)
    first, total = our_indices(folder / "sensitivity/sensitivity.json")
    rows = [
        ["", "orchestrator", *PEERS.values()],
        ["lines to write", str(lines(HERE / OURS / "paper.toml") + 2), *(str(lines(HERE / peer / "paper.py")) for peer in PEERS)],
        ["installed, MB", f"{PROGRAM.stat().st_size / 1e6:.0f}", *map(installed, PEERS)],
        ["CPU, s", *(f"{cpu[name]:.1f}" for name in (OURS, *PEERS))],
        ["elapsed, orchestrator = 1", *(f"{elapsed[name] / elapsed[OURS]:.1f}" for name in (OURS, *PEERS))],
        ["accepted of 50; the share", our_share(folder / "verify/summary.json"), *(share(peer, last[peer]) for peer in PEERS)],
        ["wrongly accepted", wrong(folder / "verify/summary.json"), *("not asked" for _ in PEERS)],
        ["first-order index", first, *(said_index(peer, last[peer], "first") for peer in PEERS)],
        ["total index", total, *(said_index(peer, last[peer], "total") for peer in PEERS)],
    ]
    exact = "first-order index {}, total index {}".format(*our_indices(reference / "sensitivity.json"))
    return rows, (f"The orchestrator from {BASE_OF_REFERENCE * 9:,} runs: {exact}. OpenTURNS' polynomial of 200 runs: total index "
                  f"{float(polynomial):.3f}.")


def wrong(file):
    """How many of the accepted points are expected not to conform."""
    risk = json.loads(file.read_text())["risk"]
    return percent(risk["not_conforming_given_accepted"], *risk["intervals"]["not_conforming_given_accepted"])


# Few runs.

# The criteria of the rare events, and the names of the functions' outputs.
RARE = {"stand": '"sensor.frictionPower", at-most = 28', "branches": '"branches", at-least = 0', "oscillator": '"oscillator", at-least = 0'}
REAL = '<ScalarVariable name="{}" valueReference="{}" causality="{}" {}><Real {}/></ScalarVariable>'
NAMES = ["x1", "x2", "x3", "x4", "x5", "x6"]


def functions(folder):
    """The FMU of functions.c."""
    sys.path.insert(0, str(ROOT / "tests/python"))
    import faulty
    inputs = [REAL.format(name, k, "parameter", 'variability="fixed"', 'start="0"') for k, name in enumerate(NAMES)]
    outputs = [REAL.format(name, len(NAMES) + k, "output", "", "") for k, name in enumerate(["branches", "oscillator"])]
    variables = "<ModelVariables>" + "".join(inputs + outputs) + "</ModelVariables>"
    text = re.sub("<ModelVariables>.*</ModelVariables>", variables, faulty.description(outputs=False), flags=re.DOTALL)
    workshop, binary = faulty.Workshop(folder), folder / "functions.so"
    workshop.compile("-shared", HERE / "functions.c", "-o", binary, "-lm")
    return workshop.fmu("functions", binary, text)


def rare_study(folder, name):
    """A study of a rare event."""
    paper = (HERE / OURS / "paper.toml").read_text().replace("../../../../dist/PlainBearingStand.fmu", str(STAND))
    if name == "stand":
        text = paper.partition("[criteria]")[0]
    else:
        drawn = NAMES[:2] if name == "branches" else NAMES
        parameters = "".join(f'{x} = {{ distribution = "normal", mean = 0, deviation = 1 }}\n' for x in drawn)
        text = f'fmu = "{functions(folder)}"\nsimulation = {{ stop = 1, step = 1 }}\n[parameters]\n{parameters}'
    study = folder / f"{name}.toml"
    study.write_text(f"{text}[criteria]\nmargin = {{ variable = {RARE[name]} }}\n")
    return study


def rare_row(folder, name):
    """A rare share by 150 runs: ours, and OpenTURNS' in two ways."""
    target = folder / "rare"
    command = [PROGRAM, "verify", rare_study(folder, name), "--rare", "not-conforming", "--output", target, "--force"]
    ours = succeeded(run(command), (0, 1, 3))
    told = json.loads((target / "rare.json").read_text())["surrogate"]
    cells = [f"{rarely(told['share'], *told['interval'])}, {told['runs']} runs, {ours.cpu:.1f} s"]
    for how in ("gp", "form"):
        theirs = run([python("openturns"), HERE / "openturns/rare.py", name, how])
        found = re.search(rf"share: {NUMBER} \+- (nan|{NUMBER}) runs: (\d+)", theirs.said)
        if found:
            value, half = map(float, found.group(1, 2))
            share = f"{100 * value:.3g} %" if math.isnan(half) else rarely(value, value - half, value + half)
            cells.append(f"{share}, {found.group(4)} runs, {theirs.cpu:.1f} s")
        else:
            cells.append(kept(theirs, []))
    return cells


def rarely(value, low, high):
    return f"{100 * value:.3g} % ({100 * low:.3g} to {100 * high:.3g} %)"


def clearance(said):
    value, deviation = map(float, said)
    return f"{value:.2f} ± {deviation:.2f} µm"


def our_clearance(file):
    """Mean and deviation of the clearance in the sample of a posterior, mm, in µm."""
    free = next(free for free in json.loads(file.read_text())["posterior"]["free"] if free["name"] == PARAMETER)
    return clearance([1000 * free["mean"], 1000 * free["deviation"]])


def few_table(folder, _):
    """What surrogates of few runs tell."""
    study = HERE / OURS / "paper.toml"
    ours = {name: succeeded(run([PROGRAM, *command, study, "--output", folder / name, "--force"]), (0, 1, 3)) for name, command in {
        "share": ["verify", "--budget", 100], "few": ["identify", "--budget", 80], "many": ["identify", "--posterior", 2000]}.items()}
    theirs = {name: succeeded(run([python("openturns"), HERE / f"openturns/{name}.py"])) for name in ("few", "posterior")}
    told = json.loads((folder / "share/summary.json").read_text())["surrogate"]
    low, high = told["interval"]
    other = float(re.search(rf"share: {NUMBER}", theirs["few"].said).group(1))
    places = json.loads((folder / "few/identification.json").read_text())["surrogate"]["runs"]
    sampled = re.search(rf"clearance: {NUMBER} \+- {NUMBER}", theirs["posterior"].said).groups()
    rows = [
        ["", "orchestrator", "OpenTURNS, Gaussian process", "OpenTURNS, FORM"],
        ["accepted, 100 runs", f"{100 * told['share']:.1f} % ({100 * low:.1f} to {100 * high:.1f} %), {ours['share'].cpu:.1f} s",
         f"{100 * other:.1f} %, {theirs['few'].cpu:.1f} s", ""],
        ["power above 28 W", *rare_row(folder, "stand")],
        ["four branches, 0.446 %", *rare_row(folder, "branches")],
        ["oscillator, 2.86 %", *rare_row(folder, "oscillator")],
        ["clearance, identified", f"{our_clearance(folder / 'few/identification.json')}, {places} runs, {ours['few'].cpu:.1f} s",
         f"{clearance(sampled)}, 80 runs, {theirs['posterior'].cpu:.1f} s", ""],
    ]
    return rows, f"Without a surrogate the clearance is {our_clearance(folder / 'many/identification.json')}."


# The same points by all.

def write_table(file, names, rows):
    with file.open("w", newline="") as target:
        csv.writer(target).writerows([names, *rows])


def read_table(file):
    """The rows of a table of results; none where the program wrote no table."""
    if not file.is_file():
        return []
    with file.open(newline="") as source:
        _, *rows = csv.reader(source)
    return [[float(cell) if cell else math.nan for cell in row] for row in rows if row]


@dataclass(frozen=True)
class Task:
    """Points of an FMU, in its own units."""
    fmu: Path
    names: list
    points: list
    stop: float
    step: float
    outputs: list

    def by_peer(self, peer, folder, processes):
        target = folder / "results.csv"
        target.unlink(missing_ok=True)
        write_table(folder / "points.csv", self.names, self.points)
        done = run([python(peer), HERE / peer / "table.py", self.fmu, folder / "points.csv", target, self.stop, self.step,
                    processes, *self.outputs], watched=True)
        return done, read_table(target)

    def by_us(self, folder, processes):
        """The same by `verify`, with limits that everything meets."""
        study, target = folder / "study.toml", folder / "out"
        text = [f'fmu = "{self.fmu}"', f"simulation = {{ stop = {self.stop}, step = {self.step} }}"]
        columns = dict(zip(self.names, zip(*self.points)))
        drawn = {name: column for name, column in columns.items() if min(column) < max(column)}
        text += [f'[parameters."{name}"]\ndistribution = "uniform"\nmin = {min(column)!r}\nmax = {max(column)!r}'
                 for name, column in drawn.items()]
        text += ["[fixed]", *(f'"{name}" = {column[0]!r}' for name, column in columns.items() if name not in drawn)]
        text += [f'[criteria."{name}"]\nvariable = "{name}"\nnominal = 0\ntolerance = 1e300' for name in self.outputs]
        study.write_text("\n".join(text))
        write_table(folder / "points.csv", ["point", *drawn], [[k + 1, *point] for k, point in enumerate(zip(*drawn.values()))])
        done = succeeded(run([PROGRAM, "verify", study, "--points-from", folder / "points.csv", "--output", target, "--force", "--jobs", processes,
                    "--point-timeout", POINT_TIMEOUT, "--extra-runs", "0"]), (0, 1, 3))
        with (target / "points.csv").open(newline="") as source:
            rows = [[float(row[name] or "nan") for name in self.outputs] for row in csv.DictReader(source)]
        return done, rows

    def by(self, name, folder, processes):
        return self.by_us(folder, processes) if name == OURS else self.by_peer(name, folder, processes)


# Table 2's parameters in the FMU's units: the table has them in millimetres.
MILLIMETRES = {"bearing.radialClearance", "load.eccentricity", "bearing.width", "bearing.diameter"}
FIXED = {
    "bearing.roughness": 0.0, "thermal.freshOilShare": 0.0, "thermal.initialOilTemperature": 48 + 273.15,
    "thermal.initialBearingTemperature": 82 + 273.15, "oil.viscosityScale": 70.71, "thermal.filmCapacity": 116.0,
    "thermal.filmBushConductance": 0.1034, "thermal.filmShaftConductance": 0.2951, "thermal.bushCapacity": 215.2,
    "thermal.shaftCapacity": 47.87, "thermal.bushOilConductance": 0.02625, "thermal.shaftOilConductance": 0.39,
    "thermal.oilAmbientConductance": 0.5131, "thermal.initialFilmRise": -12.76, "thermal.initialShaftRise": 24.83,
}


def stand_task(points):
    """The points that `verify` drew, in the FMU's units."""
    with points.open(newline="") as source:
        rows = list(csv.DictReader(source))
    names = list(rows[0])[1:8]
    drawn = [[float(row[name]) / (1000 if name in MILLIMETRES else 1) for name in names] for row in rows]
    outputs = ["sensor.oilTemperature", "sensor.bearingTemperature", "sensor.loadForce", "sensor.frictionPower"]
    return Task(STAND, names + list(FIXED), [point + list(FIXED.values()) for point in drawn], 150.0, 150.0, outputs)


def spring_task(stiffest=6.0):
    """A mass on a spring of 100 to 10^stiffest N/m. The FMU's solver has steps of 10 ms, too long for the stiffer ones."""
    fmu = next((ENVIRONMENTS / "gemseo-fmu").glob("lib/*/site-packages/gemseo_fmu/problems/fmu_files/linux/Mass_Damper.fmu"))
    points = [[10 ** (2 + (stiffest - 2) * k / (POINTS - 1)), 0.5 + (7 * k % POINTS) / 40, 5 + (13 * k % POINTS) / 4] for k in range(POINTS)]
    return Task(fmu, ["spring.c", "mass.m", "damper.d"], points, 10.0, 0.01, ["y"])


def faulty_task(folder, behaviour, bad):
    """The lag of tests/faulty, which does what where_quick.c says at the `bad` quickest points."""
    sys.path.insert(0, str(ROOT / "tests/python"))
    import faulty
    rates = [0.1 + (7 * k % POINTS) / 13 for k in range(POINTS)]
    workshop, name = faulty.Workshop(folder), f"{behaviour}-{bad}"
    binary = folder / f"{name}.so"
    workshop.compile("-shared", f"-DBEHAVIOUR={behaviour}", f"-DQUICK={sorted(rates)[-bad - 1] + 0.01}", "-I", faulty.SOURCES,
                     faulty.SOURCES / "model.c", HERE / "where_quick.c", "-o", binary, "-lm")
    return Task(workshop.fmu(name, binary), ["rate"], [[rate] for rate in rates], 1.0, 0.05, ["y"])


def good(rows):
    """The points that have all their values."""
    return [row for row in rows if all(map(math.isfinite, row))]


def kept(done, rows):
    """What a program has in the end."""
    if good(rows):
        return str(len(good(rows)))
    if done.code is None:
        return "none, does not end"
    if done.code < 0:
        return f"none, {signal.Signals(-done.code).name}"
    error = re.findall(r"^(?:\w+\.)*(\w+): ", done.said, re.M)
    return f"none, {error[-1] if error else 'no table'}"


def difference(ours, theirs):
    """The largest difference of a value, relative to ours."""
    ours, theirs = good(ours), good(theirs)
    if len(ours) != len(theirs):
        return f"{len(theirs)} of {len(ours)} points have values"
    most = max(abs(one - other) / abs(one) for row, like in zip(ours, theirs) for one, other in zip(row, like))
    return f"{most:.0e}" if most else "none"


def accident_table(folder, rounds):
    """The table of what becomes of bad points, and whether all programs compute the same."""
    names = (OURS, *PEERS)
    table = [["", "orchestrator", *PEERS.values()]]

    def add(label, task, processes):
        results = {name: task.by(name, folder, processes) for name in names}
        table.append([f"{label}, {processes} process{'es' * (processes > 1)}", *(kept(*results[name]) for name in names)])

    def compare(label, results):
        table.append([label, "", *(difference(results[OURS], results[peer]) for peer in PEERS)])

    drawn = folder / "drawn"
    succeeded(run([PROGRAM, "verify", HERE / OURS / "paper.toml", "--output", drawn]))
    spring = spring_task()
    add("21 diverge", spring, 1)
    add("21 diverge", spring, 2)
    crashing = faulty_task(folder, "crashes", 5)
    add("5 crash (SIGSEGV)", crashing, 1)
    add("5 crash (SIGSEGV)", crashing, 2)
    add("1 never ends", faulty_task(folder, "loops", 1), 2)
    for label, task in {"the stand": stand_task(drawn / "points.csv"), "softer springs": spring_task(4.0)}.items():
        compare(f"largest difference: {label}", {name: task.by(name, folder, 2)[1] for name in names})
    sound = faulty_task(folder, "crashes", 0)
    costs = [[task.by(OURS, folder, 2)[0] for task in (sound, crashing)] for _ in range(rounds)]
    cost = [statistics.median(pair[at].cpu for pair in costs) for at in (0, 1)]
    return table, f"What five crashes cost the orchestrator: {cost[0]:.2f} s of CPU without them, {cost[1]:.2f} s with them."


def markdown(table):
    head, *rows = ["| " + " | ".join(row) + " |" for row in table]
    return "\n".join([head, "|---" * len(table[0]) + "|", *rows])


def put(page, name, text):
    """The page with `text` between the markers of a name."""
    begin, end = f"<!-- {name}:begin -->", f"<!-- {name}:end -->"
    if page.count(begin) != 1 or page.count(end) != 1:
        sys.exit(f"{PAGE}: not one {begin} and one {end}")
    return page[:page.index(begin)] + f"{begin}\n{text}\n" + page[page.index(end):]


def write(name, table, sentence):
    """Puts a table and what belongs to it into the page."""
    text = f"{markdown(table)}\n\n{sentence}"
    print(text, flush=True)
    PAGE.write_text(put(PAGE.read_text(), name, text))


def installed(peer):
    """The size of a peer's environment, MB."""
    return subprocess.run(["du", "-sm", ENVIRONMENTS / peer], capture_output=True, text=True, check=True).stdout.split()[0]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rounds", type=int, default=5, help="of each program that is timed")
    parser.add_argument("--only", choices=["paper", "few", "accidents"], help="one of the tables")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for part, measured in {"paper": paper_table, "few": few_table, "accidents": accident_table}.items():
            if options.only in (None, part):
                write(part, *measured(folder, options.rounds))


if __name__ == "__main__":
    main()
