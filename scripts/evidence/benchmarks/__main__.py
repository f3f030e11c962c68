"""Measures the orchestrator and the FMU side by side with others and writes docs/evidence/benchmarks.md."""

import argparse
import datetime
import os
import sys
from dataclasses import dataclass
from pathlib import Path

import page
import parts
import subjects
from measure import Ratio, Trouble
from parts import Row


@dataclass
class Scale:
    """How much work is done."""

    work: float
    repetitions: int
    points: int
    sizes: list


def arguments():
    parser = argparse.ArgumentParser(prog="scripts/evidence/bench", description=__doc__)
    parser.add_argument("--quick", action="store_true", help="rough figures within one or two minutes")
    parser.add_argument("--points", type=int, metavar="N",
                        help="random points on which leaps are compared with resolved turns [1000]")
    parser.add_argument("--most", type=int, metavar="N", help="largest study of the scaling series [1000000]")
    parser.add_argument("--alone", action="store_true",
                        help="only what a point costs alone, and the paper's study; prints them, and writes nothing")
    parser.add_argument("--foreign", type=Path, metavar="FMU", help="another FMU for --alone")
    parser.add_argument("--repetitions", type=int, metavar="R", help="how often everything is measured [5]")
    return parser.parse_args()


def scale(options):
    quick = options.quick
    most = options.most or (1_000 if quick else 1_000_000)
    sizes = [10 ** power for power in range(2, 8) if 10 ** power <= most] or [most]
    return Scale(0.4 if quick else 1.0, options.repetitions or (3 if quick else 5),
                 options.points or (40 if quick else 1000), sizes)


def say(text):
    print(f"== {text}", file=sys.stderr, flush=True)


def measure(size):
    """All sections of the page, and the scaling series."""
    subjects.compile_minimal()
    stand, lag, trivial = subjects.stand(), subjects.lag(), subjects.trivial()
    sections = []
    say("orchestrator and minimal loop")
    sections.append(("Orchestrator / minimal dlopen loop, a step", OVERHEAD, parts.overhead(size, [
        ("the trivial FMU", trivial, 20_000, 10_000), ("the lag through the stand's boundary", lag, 20_000, 200),
        ("the stand, 1 ms steps", stand, 2_000, 100)])))
    say("other importers")
    away = "" if parts.omsimulator_is_here() else AWAY
    sections.append(("Other importers / orchestrator, a run", IMPORTERS + away, parts.importers(size, [
        ("the trivial FMU, 1,000 steps", trivial, 1e-3, 1000, 1_000),
        ("the trivial FMU, 1,000 steps, a larger batch", trivial, 1e-3, 1000, 10_000),
        ("the stand, 1,000 steps of 1 ms", stand, 1e-3, 1000, 200),
        ("the stand, one 150 s step", stand, 150.0, 1, 500)])))
    say("leaps and resolved turns")
    rows, [(errors, points), (mixed, few)] = parts.multirate(size)
    rows += [Row(f"largest error of {error.name}, of its tolerance", Ratio([error.worst]), "<= 1",
                 error.worst <= 1, " %", f"{points} points of Table 3") for error in errors]
    sections.append(("Multirate / resolved", MULTIRATE, rows))
    for study, found, count in [("paper-table3.toml", errors, points), ("rig.toml", mixed, few)]:
        sections.append((f"The errors of leaps: {count} points of {study}, in per cent of the tolerance", "", page.errors(found)))
    say("leaps of the Reynolds film")
    sections.append(("Leaps of the Reynolds film", FILM_LEAPS, parts.film_leaps()))
    say("boundary")
    sections.append(("FMU doStep / direct Rust call of the stand", BOUNDARY, parts.boundary(size, stand)))
    say("isolation")
    sections.append(("A point alone, in a used process, in the program's own", ISOLATION, parts.isolation(size, trivial)))
    say("the paper's verification")
    sections.append(("The paper's verification", PAPER, parts.paper(size)))
    sizes = parts.scaling(size, say)
    sections.append(("Scaling", SCALING, page.scaling(sizes)))
    sections.append(("At the largest size", LARGEST, parts.at_scale(sizes)))
    say("Reynolds film")
    sections.append(("Reynolds step / its flop bound", FILM, parts.film(size)))
    return sections, sizes


OVERHEAD = """\
`verify --isolation none --jobs 1` (without `--extra-runs`) against `scripts/evidence/benchmarks/minimal.c`, a bare loop on one instance."""
IMPORTERS = """\
CPU time of a run that reads one output at each step, over the orchestrator's. For fmpy without importing and loading, for
the orchestrator the whole process, divided by its points."""
AWAY = """ OMSimulator is not in `.venv`."""
MULTIRATE = """\
`solver.multirate` off over on; a point's share of journal, tables and page included."""
FILM_LEAPS = """\
`bearing.film = Reynolds`, 150 s from the given temperatures in one step, with `solver.multirate` on and off."""
BOUNDARY = """\
The minimal loop on the packaged FMU over `fmu/examples/direct.rs` (no FMI); both read one output a step."""
ISOLATION = """\
CPU time of a point by `--isolation fresh`, `shared` and `none`, with `--jobs 1` and without `--extra-runs`; `--alone` measures this
section and the next alone."""
PAPER = "The whole process, with page and files."
SCALING = """\
`verify studies/paper-table3.toml` with one 150 s step a point, all included.

![CPU time a point over the number of points](../images/benchmarks-scaling.svg)"""
LARGEST = "A million points in 15 minutes on two cores are 1.8 ms of CPU time a point."
FILM = """\
`crates/journal-bearing/examples/bound.rs` compares a step with the time of its multiplications and additions alone."""


def alone(options):
    """Prints what a point costs alone, and the paper's study."""
    size = scale(options)
    subjects.compile_minimal()
    rows = parts.isolation(size, subjects.trivial(), options.foreign) + parts.paper(size)
    for row in rows:
        print(f"{page.line(row)} ({page.number(row.ratio.low)} .. {page.number(row.ratio.high)}; {row.note})")


def main():
    options = arguments()
    if options.foreign:
        options.foreign = options.foreign.resolve()
    os.chdir(subjects.ROOT)
    subjects.WORK.mkdir(parents=True, exist_ok=True)
    if options.alone:
        return alone(options)
    began, before = datetime.datetime.now(), os.getloadavg()[0]
    try:
        sections, sizes = measure(scale(options))
    except Trouble as trouble:
        raise SystemExit(f"bench: {trouble}") from trouble
    command = " ".join(["scripts/evidence/bench", *sys.argv[1:]])
    print(page.write(command, began, [before, os.getloadavg()[0]], sections, sizes))


if __name__ == "__main__":
    main()
