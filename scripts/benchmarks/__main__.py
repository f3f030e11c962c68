"""Measures the orchestrator and the FMU side by side with others and writes docs/benchmarks.md."""

import argparse
import datetime
import os
import sys
from dataclasses import dataclass

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
    parser = argparse.ArgumentParser(prog="scripts/bench", description=__doc__)
    parser.add_argument("--quick", action="store_true", help="rough figures within one or two minutes")
    parser.add_argument("--points", type=int, metavar="N",
                        help="random points on which leaps are compared with resolved turns [1000]")
    parser.add_argument("--most", type=int, metavar="N", help="largest study of the scaling series [1000000]")
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
        sections.append((f"The errors of leaps: {study}", f"Over {count} points of `studies/{study}`, in per cent of the "
                         "criterion's tolerance.", page.errors(found)))
    say("leaps of the Reynolds film")
    sections.append(("Leaps of the Reynolds film", FILM_LEAPS, parts.film_leaps()))
    say("boundary")
    sections.append(("FMU doStep / direct Rust call of the stand", BOUNDARY, parts.boundary(size, stand)))
    say("isolation")
    sections.append(("Worker processes / in process, a point", ISOLATION, parts.isolation(size, trivial)))
    say("the paper's verification")
    sections.append(("The paper's verification", PAPER, parts.paper(size)))
    sizes = parts.scaling(size, say)
    sections.append(("Scaling", SCALING, page.scaling(sizes)))
    sections.append(("At the largest size", LARGEST, parts.at_scale(sizes)))
    say("Reynolds film")
    sections.append(("Reynolds step / its flop bound", FILM, parts.film(size)))
    return sections, sizes


OVERHEAD = """\
`verify --in-process --jobs 1` against `scripts/benchmarks/minimal.c`, which makes one run after another on one instance. The
trivial FMU (`scripts/benchmarks/trivial`) computes a multiplication or two a step, so its ratio is that of the bare loops.
The time of a step is the difference between runs of many steps and runs of few. It leaves out the cost of a run (see
"Worker processes") and the report's replay of the best point. In "an output read each step" the orchestrator computes the
mean over time, and the minimal loop reads and adds up. Neither this section nor the next has the extra runs that `verify`
makes to see whether values rest (`--extra-runs 0`): what it is compared with makes none."""
IMPORTERS = """\
CPU time of a run that reads one output at each step. For fmpy only the runs count: it gets a model description and an
unpacked FMU, and importing and loading are left out. For the orchestrator the whole process counts, from its start to the
written report, divided by its points. A ratio above 1 is in the orchestrator's favour. The goals are for a trivial FMU and
1,000 runs, where the orchestrator's start and report are a good part of its time."""
AWAY = """

OMSimulator is left out because it is not in `.venv`. Its package on PyPI holds no program; on installation it downloads a
nightly build from another server without checking a signature. With OMSimulator in `.venv` its rows appear here."""
MULTIRATE = """\
`solver.multirate` on (the default) and off. Both times include a point's share of the journal, the tables and the page.
The goal is 50 and the aim 200 at the points of Table 3. Their thick film lets even the resolved turns take large steps; the
rig's mixed lubrication does not."""
FILM_LEAPS = """\
`bearing.film = Reynolds`, 150 s from the given temperatures in one step, with `solver.multirate` on and off."""
BOUNDARY = """\
`fmu/examples/direct.rs` calls the stand without FMI; the minimal loop steps the packaged FMU. Both read one output after
each step. The comparison of a 150 s step includes initialisation and uses default parameters."""
ISOLATION = """\
CPU time of all processes, with one worker process and without any. The figure is what a point costs more than in the
orchestrator's own process: the message there and back in a used process (`--isolation reuse`), or the fork of a process with
the FMU's memory (`--isolation fresh`)."""
PAPER = "CPU time of the whole process, including the page and the files."
SCALING = """\
`verify` of `studies/paper-table3.toml` with one 150 s step a point, including the report and all files. Memory is the peak
of resident memory, of the orchestrator itself and of the largest of its worker processes.

![CPU time a point over the number of points](images/benchmarks-scaling.svg)"""
LARGEST = "A million points in 15 minutes on two cores are 1.8 ms of CPU time a point."
FILM = """\
`crates/journal-bearing/examples/bound.rs` steps the film over the stand's cycle. In the same process it measures how many
multiplications and additions a second one core achieves with the instructions that the build uses. The bound is the time of
the operations that a step cannot do without: in each of its two implicit stages one assembly, one block elimination of the
ring and two solutions. The file counts them."""


def main():
    options = arguments()
    os.chdir(subjects.ROOT)
    subjects.WORK.mkdir(parents=True, exist_ok=True)
    began, before = datetime.datetime.now(), os.getloadavg()[0]
    try:
        sections, sizes = measure(scale(options))
    except Trouble as trouble:
        raise SystemExit(f"bench: {trouble}") from trouble
    command = " ".join(["scripts/bench", *sys.argv[1:]])
    print(page.write(command, began, [before, os.getloadavg()[0]], sections, sizes))


if __name__ == "__main__":
    main()
