"""Other people's FMUs: 100 points of each by `orchestrator verify`, undisturbed and killed and resumed, against fmpy with
a fresh process for every point. Prints a Markdown table; the exit code is 1 when a result is wrong or lost.

    scripts/foreign FOLDER [--only PART] [--points N] [--keep DIR] [--table FILE]

FOLDER holds .fmu files. In the folder of `--keep`, fmpy's results stay for the next time, and the rows of this very
program: a run that was interrupted goes on where it was. `--table` writes a page with the table."""

import argparse
import csv
import hashlib
import json
import os
import random
import re
import signal
import subprocess
import sys
import tempfile
from collections import Counter
from dataclasses import asdict, dataclass, field
from datetime import datetime, timezone
from pathlib import Path

import fmpy

import fresh_points
import supervised
from supervised import PROGRAM, Study

MOST_VARIED, MOST_OBSERVED, MOST_STEPS = 4, 12, 200
SPREAD = 0.05
# How many points fmpy runs in new processes, too: importing it takes long.
FEW = 5
CHECK_TIMEOUT, VERIFY_TIMEOUT, POINT_TIMEOUT = 300, 1500.0, 30.0
# Fills fresh memory with this byte, so that what depends on unwritten memory gives other results.
FILL = {"MALLOC_PERTURB_": "165"}


PAGE = """# Other people's FMUs

Each of {count} FMUs from public repositories (the name before `--` is the repository's) was verified over {points} points by
two workers, a second time with the supervisor killed by SIGKILL on the way and the study resumed, and simulated by fmpy
with a fresh process for every point. A point is *equal* when all its outputs agree bit for bit, or when both give no
result; it is *lost* when fmpy has a result and the orchestrator has none. *Reproducible* says whether fmpy gives the same
in new processes and with fresh memory filled otherwise, and what the orchestrator says of it. `check` counts errors,
warnings and notes; of the errors, the first stands in the last column. Where points are missing, fmpy cannot run the FMU
either, or it has nothing to vary. The FMUs are not part of this repository, and the script fetches none.

Written on {date} with orchestrator {version} by `{command}`:

{summary}

"""

COLUMNS = ["FMU", "made by", "equal", "different", "lost", "killed and resumed", "reproducible: fmpy, orchestrator",
           "isolation", "check: errors, warnings, notes", "remarks"]


@dataclass
class Row:
    """What was found out about one FMU."""
    name: str
    tool: str = ""
    check: str = ""
    equal: str = ""
    different: str = ""
    lost: str = ""
    resumed: str = ""
    reproducible: str = ""
    isolation: str = ""
    remarks: list = field(default_factory=list)
    wrong: list = field(default_factory=list)

    def line(self):
        return cells([self.name, self.tool, self.equal, self.different, self.lost, self.resumed, self.reproducible,
                      self.isolation, self.check, "; ".join([*self.wrong, *self.remarks])])


def cells(row):
    return "| " + " | ".join(plain(str(cell)) for cell in row) + " |"


def plain(text):
    """A cell: one line, without the folders of this machine."""
    text = re.sub(r"(/[\w.~-]+){2,}/(?=[\w.~-])", "", text)
    return text.replace("|", "/").replace("\n", " ")


HEAD = cells(COLUMNS) + "\n|" + "---|" * len(COLUMNS)


def schedule(description):
    """The suggested experiment, cut to some hundred steps; start, stop and step."""
    experiment = description.defaultExperiment

    def number(name, otherwise):
        value = getattr(experiment, name, None)
        return otherwise if value is None else float(value)

    start = number("startTime", 0.0)
    stop = max(number("stopTime", start + 1.0), start + 1e-3)
    step = number("stepSize", (stop - start) / MOST_STEPS)
    return start, min(stop, start + MOST_STEPS * step), step


def varied(description):
    """Variables to vary: parameters, else inputs; real ones first."""
    def kind(variable):
        causes = ["parameter", "input"]
        if variable.type == "String" or variable.start is None or variable.causality not in causes:
            return None
        return (variable.type != "Real", causes.index(variable.causality))

    found = [(kind(variable), variable) for variable in description.modelVariables]
    groups = sorted({kind for kind, _ in found if kind is not None})
    return [v for kind, v in found if groups and kind == groups[0]][:MOST_VARIED]


def number(text):
    return {"true": 1.0, "false": 0.0}.get(text) if text in ("true", "false") else float(text)


def span(variable):
    """The range of a variable around its start value, within its limits."""
    start = number(variable.start)
    if variable.type == "Boolean":
        return 0.0, 1.0
    wide = SPREAD * (abs(start) or 1.0) if variable.type == "Real" else 1.0
    low = start - wide if variable.min is None else max(start - wide, float(variable.min))
    high = start + wide if variable.max is None else min(start + wide, float(variable.max))
    return (low, high) if high > low else (start, start + wide)


def observed(description):
    """Outputs, or local variables where there are none."""
    numbers = [v for v in description.modelVariables if v.type != "String"]
    outputs = [v for v in numbers if v.causality == "output"]
    return (outputs or [v for v in numbers if v.causality == "local" and v.type == "Real"])[:MOST_OBSERVED]


def study(fmu, description, inputs, outputs, count, folder):
    """Writes the study and its table; returns the points."""
    start, stop, step = schedule(description)
    text = f"fmu = {json.dumps(str(fmu))}\n[simulation]\nstart = {start!r}\nstop = {stop!r}\nstep = {step!r}\n"
    for index, variable in enumerate(inputs):
        low, high = span(variable)
        text += f"[parameters.{json.dumps(variable.name)}]\ndistribution = 'uniform'\nmin = {low!r}\nmax = {high!r}\n"
        text += f"column = 'p{index}'\n"
    for index, variable in enumerate(outputs):
        text += f"[criteria.criterion-{index}]\nvariable = {json.dumps(variable.name)}\nnominal = 0\ntolerance = 1e9\n"
    (folder / "study.toml").write_text(text)
    numbers = random.Random(1)
    points = [{v.name: numbers.uniform(*span(v)) for v in inputs} for _ in range(count)]
    lines = [",".join(["point", *(f"p{index}" for index in range(len(inputs)))])]
    lines += [",".join([str(point), *map(repr, values.values())]) for point, values in enumerate(points, 1)]
    (folder / "points.csv").write_text("\n".join(lines) + "\n")
    return points


def reference(fmu, description, points, outputs, keep, server):
    """fmpy's results, and whether other processes give the same: new ones instead of forks, and other fresh memory."""
    start, stop, step = schedule(description)
    job = {"points": points, "outputs": [v.name for v in outputs], "start": start, "stop": stop, "step": step,
           "timeout": POINT_TIMEOUT}
    content = json.dumps([job, hashlib.sha256(fmu.read_bytes()).hexdigest()])
    file = keep / f"{hashlib.sha256(content.encode()).hexdigest()}.json" if keep else None
    if file and file.is_file():
        return json.loads(file.read_text())
    job["fmu"] = str(fmu)
    results = server.run(job)
    known = {"results": results, "reproducible": None}
    if all("failure" in result for result in results):
        # A library that is missing may be installed until the next time.
        return known if "load" in results[0]["failure"] else kept(known, file)
    few = {**job, "points": points[:FEW]}
    again = fresh_points.run(few, workers=2) + fresh_points.run(few, workers=2, environment=FILL)
    pairs = [(one["values"], other["values"]) for one, other in zip(results[:FEW] * 2, again)
             if "values" in one and "values" in other]
    known["reproducible"] = all(one == other for one, other in pairs)
    return kept(known, file)


def kept(known, file):
    if file:
        file.write_text(json.dumps(known))
    return known


def check(fmu, row):
    """The pre-flight: how much it finds, and the first error."""
    try:
        done = subprocess.run([PROGRAM, "check", fmu, "--format", "json"], capture_output=True, text=True,
                              timeout=CHECK_TIMEOUT, errors="replace")
        found = json.loads(done.stdout)
    except subprocess.TimeoutExpired:
        row.wrong.append("check does not end")
        return
    except ValueError:
        row.wrong.append(f"check: exit code {done.returncode}: {done.stderr.strip()[-160:]}")
        return
    row.check = f"{found['errors']}, {found['warnings']}, {found['notes']}"
    errors = [finding for finding in found["findings"] if finding["severity"] == "error"]
    row.remarks += [f"{error['rule']}: {error['message'][:160]}" for error in errors[:1]]
    if (done.returncode == 1) != bool(errors):
        row.wrong.append(f"check: exit code {done.returncode}")


def compare(outcome, known, outputs, row):
    """Counts points: equal, different, lost (fmpy has a result and the orchestrator none)."""
    if outcome.code not in (0, 1, 3):
        what = "verify does not end" if outcome.code is None else f"verify: exit code {outcome.code}"
        row.wrong.append(f"{what}: {outcome.said.strip()[-160:]}")
        return None
    if outcome.strays:
        row.wrong.append(f"processes left: {outcome.strays}")
    equal, different, lost = 0, [], []
    for point, expected in enumerate(known["results"], 1):
        mine = outcome.points.get(point)
        fine = mine is not None and mine["status"].startswith("ok")
        if "failure" in expected or any(not float.fromhex(v) - float.fromhex(v) == 0 for v in expected["values"]):
            # What fmpy cannot either, or gives as no finite number, is no loss.
            equal += not fine
            different += [point] if fine else []
        elif not fine:
            lost.append((point, "no row" if mine is None else mine["status"]))
        elif [float(mine[f"criterion-{index}"]).hex() for index in range(len(outputs))] == expected["values"]:
            equal += 1
        else:
            different.append(point)
    return equal, different, lost


def simulate(fmu, description, outputs, row, server):
    """One run as the FMU is, of FMUs without anything to vary."""
    start, stop, step = schedule(description)
    job = {"fmu": str(fmu), "points": [{}], "outputs": [v.name for v in outputs], "start": start, "stop": stop,
           "step": step}
    expected = server.run(job)[0]
    if "failure" in expected:
        row.remarks.append(f"fmpy cannot run it: {expected['failure'][:120]}")
        return
    command = [PROGRAM, "simulate", fmu, "--start", repr(start), "--stop", repr(stop), "--step", repr(step)]
    try:
        done = subprocess.run(command, capture_output=True, text=True, errors="replace", timeout=CHECK_TIMEOUT)
    except subprocess.TimeoutExpired:
        row.wrong.append("simulate does not end")
        return
    last = list(csv.DictReader(done.stdout.splitlines()))[-1:]
    values = [float({"true": 1, "false": 0}.get(last[0][v.name], last[0][v.name])).hex() for v in outputs
              if last and last[0].get(v.name)]
    if done.returncode != 0 or values != expected["values"]:
        row.wrong.append(f"simulate: exit code {done.returncode}, {values} instead of {expected['values']}: "
                         f"{done.stderr.strip()[:120]}")
    else:
        row.remarks.append("simulated once, equal to fmpy")


def examine(fmu, count, keep, folder, server):
    row = Row(fmu.stem)
    try:
        description = fmpy.read_model_description(str(fmu), validate=False)
        inputs = varied(description)
        outputs = observed(description)
    except Exception as error:
        check(fmu, row)
        row.remarks.append(f"fmpy cannot read it: {str(error)[:120]}")
        return row
    row.tool = description.generationTool or ""
    if inputs and outputs:
        points = study(fmu, description, inputs, outputs, count, folder)
        known = reference(fmu, description, points, outputs, keep, server)
        failures = [result["failure"] for result in known["results"] if "failure" in result]
        if failures:
            row.remarks.append(f"fmpy cannot run {len(failures)} points: {failures[0][:120]}")
        if len(failures) < len(points):
            verify(fmu, row, known, outputs, folder)
    elif outputs:
        row.remarks.append("nothing to vary")
        simulate(fmu, description, outputs, row, server)
    else:
        row.remarks.append("nothing to observe")
    check(fmu, row)
    return row


def verify(fmu, row, known, outputs, folder):
    command = ["verify", "study.toml", "--points-from", "points.csv", "--jobs", "2", "--point-timeout", POINT_TIMEOUT]
    whole = Study(folder, "whole", command, {}).run()
    first = compare(whole, known, outputs, row)
    label = whole.summary.get("reproducible")
    row.isolation = whole.summary.get("isolation", "")
    row.reproducible = f"{'yes' if known['reproducible'] else 'no'}, {({True: 'yes', False: 'no'}).get(label, 'not said')}"
    if first is None:
        return
    equal, different, lost = first
    row.equal, row.different, row.lost = equal, len(different), len(lost)
    if different and known["reproducible"]:
        row.wrong.append(f"other results at points {different[:8]}")
    if not known["reproducible"] and label is not False:
        row.wrong.append("not labelled as not reproducible")
    if lost:
        row.wrong.append(f"lost: point {lost[0][0]}: {lost[0][1][:120]}")
    for begun in (20, 8, 3, 1, 0):
        run = Study(folder, f"killed-{begun}", command, {})
        _, killed, strays = run.interrupted(begun, signal.SIGKILL)
        if killed:
            break
    if strays:
        row.wrong.append(f"processes outlive a kill: {strays}")
    again = compare(run.run("--resume"), known, outputs, row)
    row.resumed = ("the same" if again == first else "other points") if killed else "ended before the kill"
    if again is not None and known["reproducible"] and (again[1] or again[2]):
        row.wrong.append(f"resumed: {len(again[1])} different, {len(again[2])} lost")


def examined(fmu, count, keep, server):
    """A row: the one that is kept, or a new one."""
    parts = [fmu.read_bytes(), fmu.name.encode(), Path(PROGRAM).read_bytes(), str(count).encode()]
    digest = hashlib.sha256(b"".join(hashlib.sha256(part).digest() for part in parts)).hexdigest()
    file = keep / f"row-{digest}.json" if keep else None
    if file and file.is_file():
        return Row(**json.loads(file.read_text()))
    with tempfile.TemporaryDirectory(prefix="foreign-") as folder:
        row = examine(fmu, count, keep, Path(folder), server)
    if file:
        file.write_text(json.dumps(asdict(row)))
    return row


def summary(found, count):
    run = [row for row in found if row.equal != ""]
    how = Counter(row.resumed for row in run)
    return (f"{len(found)} FMUs, {len(run)} run over {count} points: {sum(row.equal for row in run)} points equal to fmpy "
            f"bit for bit, {sum(row.different for row in run)} different, {sum(row.lost for row in run)} lost; after a "
            f"kill: {', '.join(f'{how[key]} {key}' for key in sorted(how))}; "
            f"{sum(bool(row.wrong) for row in found)} FMUs with something wrong.")


def page(found, options):
    version = subprocess.run([PROGRAM, "--version"], capture_output=True, text=True, check=True).stdout.split()[-1]
    head = PAGE.format(date=datetime.now(timezone.utc).date(), version=version, count=len(found), points=options.points,
                       command=f"scripts/foreign FOLDER --table docs/{options.table.name}",
                       summary=summary(found, options.points))
    rows = sorted(found, key=lambda row: row.name.lower())
    return head + "\n".join([HEAD, *(row.line() for row in rows)]) + "\n"


def main():
    arguments = argparse.ArgumentParser(prog="scripts/foreign", description=__doc__.split("\n\n")[0])
    arguments.add_argument("folder", type=Path)
    arguments.add_argument("--only", default="", metavar="PART", help="only FMUs with this in their names")
    arguments.add_argument("--points", type=int, default=100, metavar="N")
    arguments.add_argument("--keep", type=Path, metavar="DIR", help="where results stay for the next time")
    arguments.add_argument("--table", type=Path, metavar="FILE", help="a page with the table")
    options = arguments.parse_args()
    fmus = sorted(fmu for fmu in options.folder.absolute().glob("**/*.fmu") if options.only in fmu.name)
    if options.keep:
        options.keep.mkdir(parents=True, exist_ok=True)
    supervised.DEADLINE = VERIFY_TIMEOUT
    print(HEAD, flush=True)
    found, server = [], fresh_points.Server()
    for fmu in fmus:
        row = examined(fmu, options.points, options.keep, server)
        print(row.line(), flush=True)
        found.append(row)
    server.close()
    print("\n" + summary(found, options.points))
    if options.table:
        options.table.write_text(page(found, options))
    return 1 if any(row.wrong for row in found) or not found else 0


if __name__ == "__main__":
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    sys.exit(main())
