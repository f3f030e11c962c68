"""Other people's FMUs, each kind for itself: points by `orchestrator verify`, undisturbed, and killed and
resumed, against fmpy with a fresh process for every point. Prints a line an FMU and kind, then a Markdown table; the exit
code is 1 when a result is wrong or lost.

    scripts/evidence/foreign FOLDER [--only PART] [--points N] [--at-once N] [--keep DIR] [--table FILE]

FOLDER holds .fmu files, named REPOSITORY--NAME.fmu. In the folder of `--keep`, fmpy's results stay for the next time, and the
rows of this very program: a run that was interrupted goes on where it was. `--table` writes a page, and the table as csv beside it."""

import argparse
import csv
import hashlib
import itertools
import json
import os
import random
import re
import signal
import subprocess
import sys
import sysconfig
import tempfile
import threading
import zipfile
from collections import Counter, defaultdict
from concurrent.futures import ThreadPoolExecutor
from dataclasses import asdict, dataclass, field
from datetime import datetime, timezone
from pathlib import Path

import fmpy
import numpy as np
from fmpy.simulation import settable_in_initialization_mode, settable_in_instantiated

import fresh_points
import supervised
from supervised import PROGRAM, Study

KINDS = {"CoSimulation": "Co-Simulation", "ModelExchange": "Model Exchange"}
MOST_VARIED, MOST_OBSERVED, MOST_ELEMENTS, MOST_STEPS = 4, 10, 12, 100
SPREAD = 0.1
# Model Exchange: relative to the largest value on the way. fmpy's solver and the orchestrator's get their tolerances.
SAME, TIGHT = 1e-4, 1e-8
# How many points fmpy runs in new processes, too: importing it takes long.
FEW = 1
CHECK_TIMEOUT, VERIFY_TIMEOUT, POINT_TIMEOUT = 300, 900.0, 30.0
# Fills fresh memory with this byte, so that what depends on unwritten memory gives other results.
FILL = {"MALLOC_PERTURB_": "165"}
REAL, UNUSABLE = ("Real", "Float64", "Float32"), ("String", "Binary", "Clock")

PAGE = """# Other people's FMUs

`scripts/evidence/foreign FOLDER --table docs/evidence/foreign-fmus.md` ran FMUs from public repositories and Python wheels, which are not
part of this repository, Co-Simulation and Model Exchange each: {points} points within 10 % of the start values, by fmpy with a
fresh process a point, and by `orchestrator verify` twice: undisturbed, and killed by SIGKILL on the way and resumed. [foreign-fmus.csv](foreign-fmus.csv) has the counts by repository. *Equal*: all outputs agree bit for bit, or
neither gives a result. *Within*: by 1e-4 of the largest value (Model Exchange: two solvers). *Lost*: only the other has a result.
*Once*: nothing to vary, one run.

Written on {date} with orchestrator {version}: {summary}
"""

COLUMNS = ["repository", "FMUs", "FMUs and kinds", "equal", "within", "different", "lost", "lost by fmpy", "once", "neither runs",
           "errors", "warnings", "notes"]


@dataclass
class Row:
    """What was found out about one FMU of one kind."""
    name: str
    kind: str
    tool: str = ""
    check: list = field(default_factory=list)
    counts: dict = field(default_factory=dict)
    remarks: list = field(default_factory=list)
    wrong: list = field(default_factory=list)

    def line(self):
        counts = ", ".join(f"{number} {what}" for what, number in self.counts.items() if number)
        return f"{self.name}, {KINDS[self.kind]}: " + plain("; ".join(filter(None, [counts, *self.wrong, *self.remarks])))


def plain(text):
    """One line, without the folders of this machine."""
    return re.sub(r"(/[\w.~-]+){2,}/(?=[\w.~-])", "", text).replace("|", "/").replace("\n", " ")


def cells(row):
    return "| " + " | ".join(map(str, row)) + " |"


def only(fmu, kind, to):
    """A copy for one kind alone: else Co-Simulation would be run."""
    other = next(other for other in KINDS if other != kind).encode()
    with zipfile.ZipFile(fmu) as original, zipfile.ZipFile(to, "w", zipfile.ZIP_DEFLATED) as copy:
        for name in dict.fromkeys(original.namelist()):
            content = original.read(name)
            if name == "modelDescription.xml":
                content = re.sub(rb"<%s\b[^>]*?(/>|>.*?</%s>)" % (other, other), b"", content, flags=re.S)
            copy.writestr(original.getinfo(name), content)
    return to


def schedule(description, kind):
    """The suggested experiment, cut to some hundred steps; start, stop and step."""
    experiment = description.defaultExperiment

    def number(name):
        value = getattr(experiment, name, None)
        return None if value is None else float(value)

    start, stop, step = number("startTime") or 0.0, number("stopTime"), number("stepSize")
    if step is None and kind == "CoSimulation" and description.coSimulation.fixedInternalStepSize:
        step = float(description.coSimulation.fixedInternalStepSize)
    if stop is None or stop <= start:
        stop = start + (MOST_STEPS * step if step else 1.0)
    if not step or step > stop - start:
        step = (stop - start) / MOST_STEPS
    # A stop that fmpy and the orchestrator reach by the same sum.
    return start, start + max(1, min(MOST_STEPS, round((stop - start) / step))) * step, step


def varied(description):
    """Variables to vary: parameters, else inputs; real ones first."""
    def kind(variable):
        causes = ["parameter", "input"]
        settable = settable_in_instantiated(variable) or settable_in_initialization_mode(variable)
        if variable.type in UNUSABLE or variable.start is None or variable.causality not in causes or not settable:
            return None
        if any(low >= high for low, high in (span(variable, start) for start in starts(variable))):
            return None
        return (variable.type not in REAL, causes.index(variable.causality))

    known = [(kind(variable), variable) for variable in description.modelVariables]
    groups = sorted({kind for kind, _ in known if kind is not None})
    return [v for kind, v in known if groups and kind == groups[0]][:MOST_VARIED]


def elements(variable):
    """The names of a variable's elements: its own name, or those of an array."""
    if not variable.shape:
        return [variable.name]
    indexes = itertools.product(*(range(1, int(size) + 1) for size in variable.shape))
    return [f"{variable.name}[{','.join(map(str, index))}]" for index in indexes]


def starts(variable):
    """The start values of a variable's elements."""
    texts = str(variable.start).split() if variable.shape else [str(variable.start)]
    numbers = [{"true": 1.0, "false": 0.0}[text] if text in ("true", "false") else float(text) for text in texts]
    return numbers * len(elements(variable)) if len(numbers) == 1 else numbers


def span(variable, start):
    """The range of a variable around its start value, within its limits."""
    if variable.type == "Boolean":
        return 0.0, 1.0
    wide = SPREAD * (abs(start) or 1.0) if variable.type in REAL else 1.0
    holders = (variable, variable.declaredType)
    limits = [[getattr(holder, end) for holder in holders if getattr(holder, end, None) is not None]
              for end in ("min", "max")]
    low = max([start - wide, *map(float, limits[0][:1])])
    high = min([start + wide, *map(float, limits[1][:1])])
    return low, high


def drawn(variable, numbers):
    """Values of a variable's elements, as the variable's type has them; of a long array the first elements vary."""
    values = []
    for place, start in enumerate(starts(variable)):
        low, high = span(variable, start)
        value = start if place >= MOST_ELEMENTS else numbers.uniform(low, high)
        if variable.type == "Float32":
            value = float(np.float32(value))
        elif variable.type not in REAL:
            value = float(min(max(round(value), low), high))
        values.append(value)
    return values


def observed(description):
    """Outputs, or local variables where there are none."""
    numbers = [v for v in description.modelVariables if v.type not in UNUSABLE and v.name != "time"]
    outputs = [v for v in numbers if v.causality == "output"]
    return (outputs or [v for v in numbers if v.causality == "local" and v.type in REAL])[:MOST_OBSERVED]


def study(fmu, exact, times, inputs, outputs, count, folder):
    """Writes the study and its table; returns the points as fmpy takes them."""
    numbers, points, table = random.Random(1), [], []
    for _ in range(count):
        values = {v.name: drawn(v, numbers) for v in inputs}
        table.append([x for v in inputs for x in values[v.name][:MOST_ELEMENTS]])
        kind = {v.name: (float if v.type in REAL else bool if v.type == "Boolean" else int) for v in inputs}
        points.append({v.name: [*map(kind[v.name], values[v.name])] if v.shape else kind[v.name](values[v.name][0])
                       for v in inputs})
    start, stop, step = times
    text = f"fmu = {json.dumps(str(fmu))}\n[simulation]\nstart = {start!r}\nstop = {stop!r}\nstep = {step!r}\n"
    text += "" if exact else f"tolerance = {TIGHT!r}\n"
    names = [name for variable in inputs for name in elements(variable)[:MOST_ELEMENTS]]
    for index, name in enumerate(names):
        low, high = min(row[index] for row in table), max(row[index] for row in table)
        text += f"[parameters.{json.dumps(name)}]\ndistribution = 'uniform'\nmin = {low!r}\n"
        text += f"max = {high if high > low else low + 1.0!r}\ncolumn = 'p{index}'\n"
    for index, name in enumerate(name for variable in outputs for name in elements(variable)):
        # The mean is read at every communication point, as fmpy does: some FMUs give other results when they are not.
        for criterion, statistic in (("criterion", "final"), ("read", "mean")):
            text += f"[criteria.{criterion}-{index}]\nvariable = {json.dumps(name)}\nstatistic = '{statistic}'\n"
            text += "nominal = 0\ntolerance = 1e9\n"
    (folder / "study.toml").write_text(text)
    lines = [",".join(["point", *(f"p{index}" for index in range(len(names)))])]
    lines += [",".join([str(point), *map(repr, row)]) for point, row in enumerate(table, 1)]
    (folder / "points.csv").write_text("\n".join(lines) + "\n")
    return points


def reference(fmu, kind, times, points, outputs, keep, server):
    """fmpy's results, and whether other processes give the same: new ones instead of forks, and other fresh memory."""
    job = {"kind": kind, "points": points, "outputs": [v.name for v in outputs], "timeout": POINT_TIMEOUT,
           "tolerance": TIGHT, **dict(zip(("start", "stop", "step"), times))}
    content = json.dumps([job, hashlib.sha256(fmu.read_bytes()).hexdigest()])
    file = keep / f"{hashlib.sha256(content.encode()).hexdigest()}.json" if keep else None
    if file and file.is_file():
        return json.loads(file.read_text())
    job["fmu"] = str(fmu)
    known = {"results": server.run(job), "reproducible": None}
    few = [{**job, "points": [point]} for point, result in zip(points, known["results"]) if "values" in result][:FEW]
    if few:
        again = [fresh_points.run(one, environment=fill)[0] for one in few for fill in ({}, FILL)]
        first = [result for result in known["results"] if "values" in result]
        known["reproducible"] = all(other.get("values") in (None, first[place // 2]["values"])
                                    for place, other in enumerate(again))
    if file:
        file.write_text(json.dumps(known))
    return known


def check(fmu, row):
    """The pre-flight: how much it finds."""
    try:
        done = subprocess.run([PROGRAM, "check", fmu, "--format", "json"], capture_output=True, text=True,
                              timeout=CHECK_TIMEOUT, errors="replace")
        told = json.loads(done.stdout)
    except subprocess.TimeoutExpired:
        row.wrong.append("check does not end")
        return
    except ValueError:
        row.wrong.append(f"check: exit code {done.returncode}: {done.stderr.strip()[-160:]}")
        return
    row.check = [told["errors"], told["warnings"], told["notes"]]
    if (done.returncode == 1) != bool(told["errors"]):
        row.wrong.append(f"check: exit code {done.returncode}")


def agree(mine, expected, exact):
    """Whether a point's outputs are fmpy's: equal, within, or neither (None)."""
    values = [float.fromhex(value) for value in expected["values"]]
    if mine == values:
        return "equal"
    near = all(abs(a - b) <= SAME * largest + 1e-9 for a, b, largest in zip(mine, values, expected["largest"]))
    return "within" if near and not exact else None


def compare(outcome, known, exact, row, label):
    """Counts points by how they agree with fmpy's; what is wrong goes into the row."""
    if outcome.code not in (0, 1, 3):
        what = "verify does not end" if outcome.code is None else f"verify: exit code {outcome.code}"
        if not all("failure" in result for result in known["results"]):
            row.wrong.append(f"{label}: {what}: {outcome.said.strip()[-160:]}")
        return Counter({"neither": len(known["results"])})
    if outcome.strays:
        row.wrong.append(f"{label}: processes left: {outcome.strays}")
    counts, first = Counter(), {}
    for point, expected in enumerate(known["results"], 1):
        mine = outcome.points.get(point)
        fine = mine is not None and mine["status"].startswith("ok")
        # What fmpy cannot either, or gives as no finite number, is no loss.
        theirs = "values" in expected and all(float.fromhex(v) - float.fromhex(v) == 0 for v in expected["values"])
        if not theirs:
            how = "lost by fmpy" if fine else "neither"
        elif not fine:
            how = "lost"
        else:
            values = [float(mine[f"criterion-{index}"]) for index in range(len(expected["values"]))]
            how = agree(values, expected, exact) or "different"
        counts[how] += 1
        first.setdefault(how, f"point {point}: {(mine or {}).get('status', 'no row')[:120]}")
    for how in ("different", "lost"):
        if how in first and (how == "lost" or known["reproducible"]):
            row.wrong.append(f"{label}: {counts[how]} {how}, {first[how]}")
    return counts


def environment(fmu):
    """FMUs of pythonfmu need Python's library, which fmpy's process has."""
    with zipfile.ZipFile(fmu) as archive:
        embeds = any(name.startswith("resources/pythonfmu") for name in archive.namelist())
    library = Path(sysconfig.get_config_var("LIBDIR")) / (sysconfig.get_config_var("LDLIBRARY") or "")
    path = os.pathsep.join([sysconfig.get_path("purelib"), os.environ.get("PYTHONPATH", "")])
    return {"LD_PRELOAD": str(library), "PYTHONPATH": path} if embeds else {}


def verify(fmu, row, known, exact, folder):
    command = ["verify", "study.toml", "--points-from", "points.csv", "--jobs", "2", "--point-timeout", POINT_TIMEOUT]
    more = environment(fmu)
    whole = Study(folder, "whole", command, more).run()
    row.counts = dict(compare(whole, known, exact, row, "undisturbed"))
    if known["reproducible"] is False and whole.summary.get("reproducible") is not False:
        row.wrong.append("not labelled as not reproducible")
    for begun in (12, 3, 0):
        run = Study(folder, f"killed-{begun}", command, more)
        _, killed, strays = run.interrupted(begun, signal.SIGKILL)
        if killed:
            break
    if strays:
        row.wrong.append(f"processes outlive a kill: {strays}")
    compare(run.run("--resume"), known, exact, row, "resumed")


def examine(fmu, kind, count, keep, folder, server):
    row = Row(fmu.stem, kind)
    fmu = only(fmu, kind, folder / fmu.name)
    check(fmu, row)
    try:
        description = fmpy.read_model_description(str(fmu), validate=False)
        inputs, outputs, times = varied(description), observed(description), schedule(description, kind)
    except Exception as error:
        row.remarks.append(f"fmpy cannot read it: {str(error)[:120]}")
        row.counts = {"neither": 1}
        return row
    row.tool = description.generationTool or ""
    if not outputs:
        row.remarks.append("nothing to observe")
        return row
    exact = kind == "CoSimulation"
    points = study(fmu, exact, times, inputs, outputs, count if inputs else 1, folder)
    known = reference(fmu, kind, times, points, outputs, keep, server)
    failures = [result["failure"] for result in known["results"] if "failure" in result]
    if failures:
        row.remarks.append(f"fmpy cannot run {len(failures)} points: {failures[0][:120]}")
    if inputs:
        verify(fmu, row, known, exact, folder)
    else:
        once(fmu, times, outputs, known["results"][0], exact, row)
    return row


def once(fmu, times, outputs, expected, exact, row):
    """One run as the FMU is, of FMUs without anything to vary."""
    start, stop, step = times
    names = [name for variable in outputs for name in elements(variable)]
    command = [PROGRAM, "simulate", fmu, "--start", repr(start), "--stop", repr(stop), "--step", repr(step)]
    command += [part for name in names if "," not in name for part in ("--record", name)]
    try:
        done = subprocess.run(command, env={**os.environ, **environment(fmu)}, capture_output=True, text=True,
                              errors="replace", timeout=CHECK_TIMEOUT)
    except subprocess.TimeoutExpired:
        row.wrong.append("simulate does not end")
        return
    rows = [line.split(",") for line in done.stdout.strip().splitlines()[1:]] if done.returncode == 0 else []
    if "failure" in expected or not rows:
        how = "neither" if "failure" in expected and not rows else "lost by fmpy" if rows else "lost"
    else:
        # fmpy writes no row for the moment at which an FMU for Model Exchange ends the simulation.
        last = next((row for row in reversed(rows) if float(row[0]) <= expected["time"] + 1e-9 * step), rows[-1])
        mine = [{"true": 1.0, "false": 0.0}.get(cell) if cell in ("true", "false") else float(cell) for cell in last[1:]]
        how = "once" if agree(mine, expected, exact) else "different"
    row.counts = {how: 1}
    if how in ("lost", "different"):
        row.wrong.append(f"simulate: {how}: {done.stderr.strip()[:120]}")


def examined(fmu, kind, count, keep, server):
    """A row: the one that is kept, or a new one."""
    parts = [fmu.read_bytes(), fmu.name.encode(), kind.encode(), Path(PROGRAM).read_bytes(), str(count).encode()]
    digest = hashlib.sha256(b"".join(hashlib.sha256(part).digest() for part in parts)).hexdigest()
    file = keep / f"row-{digest}.json" if keep else None
    if file and file.is_file():
        return Row(**json.loads(file.read_text()))
    with tempfile.TemporaryDirectory(prefix="foreign-") as folder:
        row = examine(fmu, kind, count, keep, Path(folder), server)
    if file:
        file.write_text(json.dumps(asdict(row)))
    return row


def total(rows):
    return sum((Counter(row.counts) for row in rows), Counter())


def table(rows):
    """A line a repository, and one for all."""
    by_repository = defaultdict(list)
    for row in rows:
        by_repository[row.name.split("--")[0]].append(row)
    yield COLUMNS
    for name in [*sorted(by_repository, key=str.lower), "all"]:
        group = by_repository.get(name, rows)
        counts = total(group)
        checked = [sum(column) for column in zip(*(row.check for row in group if row.check))]
        yield [name, len({row.name for row in group}), len(group),
               *(counts[what] for what in ("equal", "within", "different", "lost", "lost by fmpy", "once", "neither")), *checked]


def odd(rows):
    """What is lost or differs."""
    return [f"- {row.line()}" for row in rows if row.wrong or set(row.counts) & {"different", "lost", "lost by fmpy"}]


def summary(rows):
    counts = total(rows)
    return (f"{len({row.name for row in rows})} FMUs, {len(rows)} FMUs and kinds: {counts['equal']} points equal, "
            f"{counts['within']} within, {counts['different']} different, {counts['lost']} lost; "
            f"{sum(bool(row.wrong) for row in rows)} with something wrong.")


def page(rows, options):
    version = subprocess.run([PROGRAM, "--version"], capture_output=True, text=True, check=True).stdout.split()[-1]
    return PAGE.format(date=datetime.now(timezone.utc).date(), version=version, points=options.points,
                       summary=summary(rows)) + "\n" + "\n".join(["What is lost or differs:", "", *odd(rows)]) + "\n"


def kinds(fmu):
    with zipfile.ZipFile(fmu) as archive:
        text = archive.read("modelDescription.xml")
    return [kind for kind in KINDS if re.search(rb"<%s\b" % kind.encode(), text)]


def main():
    arguments = argparse.ArgumentParser(prog="scripts/evidence/foreign", description=__doc__.split("\n\n")[0])
    arguments.add_argument("folder", type=Path)
    arguments.add_argument("--only", default="", metavar="PART", help="only FMUs with this in their names")
    arguments.add_argument("--points", type=int, default=24, metavar="N")
    arguments.add_argument("--at-once", type=int, default=2, metavar="N", help="so many FMUs at a time: most of a row is waiting [2]")
    arguments.add_argument("--keep", type=Path, metavar="DIR", help="where results stay for the next time")
    arguments.add_argument("--table", type=Path, metavar="FILE", help="a page; a file of the same name ending in .csv has the table")
    options = arguments.parse_args()
    fmus = sorted(fmu for fmu in options.folder.absolute().glob("**/*.fmu") if options.only in fmu.name)
    if options.keep:
        options.keep.mkdir(parents=True, exist_ok=True)
    supervised.DEADLINE = VERIFY_TIMEOUT
    rows, servers, own = [], [], threading.local()

    def row(task):
        if not hasattr(own, "server"):
            own.server = fresh_points.Server()
            servers.append(own.server)
        return examined(*task, options.points, options.keep, own.server)

    with ThreadPoolExecutor(options.at_once) as threads:
        for found in threads.map(row, [(fmu, kind) for fmu in fmus for kind in kinds(fmu)]):
            rows.append(found)
            print(found.line(), flush=True)
    for server in servers:
        server.close()
    print(*map(cells, table(rows)), *odd(rows), summary(rows), sep="\n")
    if options.table:
        options.table.write_text(page(rows, options))
        with options.table.with_suffix(".csv").open("w", newline="") as file:
            csv.writer(file, lineterminator="\n").writerows(table(rows))
    return 1 if any(row.wrong for row in rows) or not rows else 0


if __name__ == "__main__":
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    sys.exit(main())
