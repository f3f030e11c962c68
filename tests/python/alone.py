"""Points of misbehaving FMUs against each point alone: every N-th point has the fault, and the results of all others are compared,
to the last bit, with what fmpy computes in a fresh process each, of the healthy model unless the FMU has results of its own.
Prints a line for every run in which a result is wrong or lost, and what told of it; the exit code is 1 when nothing did, or
when a process is left.

    scripts/evidence/alone [--all] [--every N ...] [--jobs N ...] [--hosts] [--only PART] [--at-once N]

Without --all the FMUs are those whose points meet outside of their processes and folders: at a port, at a lock.
Two hosts are this machine twice."""

import argparse
import re
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import supervised
from faulty import HEALTHY, MEETINGS, MODELS
from laboratory import NO_TIMEOUT, TIMEOUT, Laboratory, bits, study

POINTS = {10: 200, 50: 300}
MOST = 500
# So long that only a run that hangs takes it, s.
DEADLINE = 600.0
# So many points of models that wait for the timeout: each point with the fault does.
FEW = 60


def told(outcome):
    """What the first screen says against the results."""
    said = " ".join(outcome.said.split())
    return [words for words in ("not reproducible:", "the FMU holds a port, a socket or a lock") if words in said]


def examine(laboratory, fmu, model, every, where):
    """The numbers of points that are right, wrong and lost, what told, and the processes that were left."""
    count = FEW if model.waits else POINTS.get(every, MOST)
    hit = {point for point in range(1, count + 1) if point % every == 7}
    with tempfile.TemporaryDirectory() as folder:
        folder = Path(folder)
        options = ["--extra-runs", "0", "--point-timeout", TIMEOUT if model.waits else NO_TIMEOUT, *model.options]
        sound = laboratory.fresh(fmu, points=count) if model.results == "own" else laboratory.sound
        run = study(folder, fmu, hit, options=options, points=count)
        if where is None:
            (folder / "hosts.txt").write_text("alpha 1\nbeta 1\n")
            where = ["--hosts", "hosts.txt", "--launcher", "sh -c 'exec \"$@\"' {host}"]
        place = run.command.index("--jobs")
        run.command[place:place + 2] = where
        outcome = run.run()
    if not outcome.points:
        raise SystemExit(f"{model.name}: {outcome.said[-400:]}")
    good = {point: row for point, row in outcome.points.items() if point not in hit}
    lost = [point for point, row in good.items() if not row["status"].startswith("ok")]
    wrong = [point for point, row in good.items() if point not in lost and bits(row) != sound[point]]
    return len(good), len(wrong), len(lost), told(outcome), outcome.strays


def main():
    arguments = argparse.ArgumentParser(prog="scripts/evidence/alone", description=__doc__.split("\n\n")[0])
    arguments.add_argument("--all", action="store_true", help="all behaviours of tests/faulty")
    arguments.add_argument("--every", type=int, nargs="+", default=[10, 500], metavar="N", help="one point in N has the fault [10 500]")
    arguments.add_argument("--jobs", nargs="+", default=["2"], metavar="N", help="points at a time [2]")
    arguments.add_argument("--hosts", action="store_true", help="two hosts instead, a point at a time each")
    arguments.add_argument("--only", default="", metavar="PART", help="only behaviours with this in their names")
    arguments.add_argument("--at-once", type=int, default=2, metavar="N", help="so many runs at a time [2]")
    options = arguments.parse_args()
    places = [None] if options.hosts else [["--jobs", jobs] for jobs in options.jobs]
    models = [model for model in [*MEETINGS, *(MODELS if options.all else [])] if re.search(options.only, model.name)]
    supervised.DEADLINE = DEADLINE
    points, off, silent = 0, [], 0
    with tempfile.TemporaryDirectory() as folder, ThreadPoolExecutor(options.at_once) as threads:
        laboratory = Laboratory(Path(folder))
        laboratory.sound = laboratory.fresh(laboratory.workshop.model(HEALTHY), points=MOST)
        # Runs of one behaviour have one file, which none may write while another reads it.
        fmus = [(laboratory.workshop.model(model), model) for model in models]
        runs = [(*fmu, every, where) for fmu in fmus for every in options.every for where in places]
        for (_, model, every, where), found in zip(runs, threads.map(lambda run: examine(laboratory, *run), runs)):
            count, wrong, lost, words, strays = found
            points += count
            if wrong or lost or strays:
                off.append(wrong + lost)
                # A point that failed says so itself.
                silent += bool(strays or wrong and not words)
                print(f"{model.name}, one in {every}, {' '.join(where or ['two hosts'])}: of {count} points {wrong} wrong, {lost} failed; "
                      f"told: {', '.join(words) or 'no'}{'; left: ' if strays else ''}{strays or ''}", flush=True)
        laboratory.end()
    print(f"{len(models)} behaviours, {len(runs)} runs, {points} points without the fault: {sum(off)} wrong or failed in {len(off)} runs, "
          f"{silent} of which nothing told.")
    return 1 if silent else 0


if __name__ == "__main__":
    sys.exit(main())
