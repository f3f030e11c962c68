"""The parts of the benchmark. Each measures its subjects in turns and gives rows for the page."""

import csv
import json
import statistics
from dataclasses import dataclass

import subjects
from measure import Ratio, Trouble, in_turns
from subjects import WORK, alone, constant, direct, importer, minimal, rig, steady_rig, table3, verify


@dataclass
class Row:
    """A line of a table: what is compared, the ratio, and what issue and goal say of it."""

    what: str
    ratio: Ratio
    goal: str = ""
    met: bool | None = None
    unit: str = ""
    note: str = ""


def longer(measure, few, many):
    """The cost of one out of `many - few`: what is spent once a process cancels out."""
    return lambda: (measure(many) - measure(few)) / (many - few)


def at_most(ratio, limit):
    return {"goal": f"<= {limit:g}", "met": ratio.median <= limit}


def at_least(ratio, limit):
    return {"goal": f">= {limit:g}", "met": ratio.median >= limit}


def overhead(scale, fmus):
    """Orchestrator over the minimal loop, a step: what further runs of many steps cost more than further runs
    of few. So neither a run's own cost is in it, nor the replay of the best point for the report."""
    rows = []
    few = 5
    for name, fmu, steps, runs in fmus:
        many, short = few + max(5, round(runs * scale.work)), steps // 20
        readings = [("", "final", 1.05), (", an output read each step", "mean", 1.05), (", and compared with a curve", "curve", 1.3)]
        for reading, statistic, limit in readings:
            def loop(steps):
                return longer(lambda count: minimal(fmu, 1e-3, steps, count, statistic != "final"), few, many)()

            def ours(steps):
                study = constant(fmu, 1e-3, steps, statistic)
                return longer(lambda count: alone(study, count), few, many)()

            [ratio], times = in_turns(scale.repetitions, longer(loop, short, steps), longer(ours, short, steps))
            nanoseconds = [1e9 * statistics.median(time) for time in times]
            note = f"minimal loop {nanoseconds[0]:.1f} ns a step, orchestrator {nanoseconds[1]:.1f} ns"
            rows.append(Row(f"{name}{reading}", ratio, note=note, **at_most(ratio, limit)))
    return rows


def importers(scale, fmus):
    """Other importers over the orchestrator, a run, the orchestrator's start and report included."""
    rows = []
    for name, fmu, step, steps, batch in fmus:
        study = constant(fmu, step, steps, "mean")
        kinds = [("fmpy.simulate_fmu", "simulate", 300), ("fmpy, doStep loop", "loop", 150)]
        if omsimulator_is_here():
            kinds.append(("OMSimulator", "omsimulator", 100))
        runs = max(3, round((20 if steps > 1 else 60) * scale.work))

        def others(kind):
            return lambda: importer(kind, fmu, step, steps, runs)[0]

        def loop():
            return minimal(fmu, step, steps, batch, True) / batch

        def ours():
            return alone(study, batch) / batch

        ratios, times = in_turns(scale.repetitions, ours, loop, *[others(kind) for _, kind, _ in kinds])
        note = f"{batch:,} points; orchestrator {1e3 * statistics.median(times[0]):.3f} ms a point, all included"
        rows.append(Row(f"{name}: minimal loop, a run", ratios[0], note=note))
        goals = batch == 1000 and name.startswith("the trivial")
        for (kind, _, goal), ratio, time in zip(kinds, ratios[1:], times[2:]):
            note = f"{1e3 * statistics.median(time):.2f} ms a run"
            rows.append(Row(f"{name}: {kind}", ratio, note=note, **(at_least(ratio, goal) if goals else {})))
    return rows


def omsimulator_is_here():
    try:
        import OMSimulator  # noqa: F401
    except ImportError:
        return False
    return True


RESOLVED = '"solver.multirate" = false\n'


def multirate(scale):
    """Leaping over turns against resolving them, in speed and in what the criteria become: the rows, and the
    errors over the points of Table 3 and over those of the rig, each with their number."""
    leaping, resolved = table3("multirate"), table3("resolved", fixed=RESOLVED)
    # The speed of turns needs fewer points than the errors do, that of leaps more: beside them the process's own
    # start and end would not be small.
    row = leap(scale, "Table 3, 150 s in one step", (leaping, 2000), (resolved, min(scale.points, 200)))
    for key, value in at_least(row.ratio, 50).items():
        setattr(row, key, value)
    here, there = rig("rig-multirate"), rig("rig-resolved", fixed=RESOLVED)
    mixed = min(scale.points, 256)
    rows = [row, leap(scale, "the rig, 150 s in one step", (here, 100), (there, min(mixed, 32)))]
    rows.append(leap(scale, "the rig, one turn from the steady start / 150 s from given temperatures",
                     (here, 100), (steady_rig("rig-steady"), 400), words=("from given temperatures", "steady start")))
    rows.append(steady_cost(scale))
    return rows, [(errors(leaping, resolved, scale.points), scale.points), (errors(here, there, mixed), mixed)]


def steady_cost(scale):
    """A point of the rig's study as it is shipped."""
    measure = longer(lambda count: alone(steady_rig("rig-steady"), count), 20, 400)
    cost = Ratio([1e3 * measure() for _ in range(scale.repetitions)])
    return Row("the rig, one turn from the steady start, CPU time a point", cost, unit=" ms", note="400 points, all included",
               **at_most(cost, 2))


REYNOLDS = '"bearing.film" = "Reynolds"\n'


def film_studies():
    """Studies with the Reynolds film, each with leaps and with every turn resolved."""
    return {"paper-table3.toml": (table3("film-leaping", fixed=REYNOLDS), table3("film-resolved", fixed=REYNOLDS + RESOLVED)),
            "rig.toml": (rig("film-rig-leaping", fixed=REYNOLDS), rig("film-rig-resolved", fixed=REYNOLDS + RESOLVED))}


def film_leaps():
    """The same for the Reynolds film. Resolved points take some ten seconds, so that few of them are measured, once."""
    rows = []
    few, many = 3, 100
    for study, (leaping, resolved) in film_studies().items():
        times = [[longer(lambda count: alone(file, count), 1, count)()] for file, count in [(leaping, many), (resolved, few)]]
        [[leaps], [turns]] = times
        note = f"mean of {many} points, resolved {turns:.1f} s of {few}; a film that cannot leap is resolved"
        rows.append(Row(f"{study}, 150 s with leaps, CPU time a point", Ratio([leaps]), unit=" s", note=note,
                        **at_most(Ratio([leaps]), 0.5)))
        for error in errors(leaping, resolved, few):
            rows.append(Row(f"{study}: largest error of {error.name}, of its tolerance", Ratio([error.worst]), unit=" %",
                            note=f"{few} points; `scripts/evidence/film-leaps` for more", **at_most(Ratio([error.worst]), 1)))
    return rows


def leap(scale, name, leaping, resolved, words=("leaping", "resolved")):
    """Runs with leaps against runs without, each a study and its points; what the orchestrator does for a point
    is included."""
    def measure(study, points):
        return longer(lambda count: alone(study, count), max(2, points // 20), points)

    [ratio], times = in_turns(scale.repetitions, measure(*leaping), measure(*resolved))
    note = (f"{words[0]} {1e3 * statistics.median(times[0]):.3f} ms a point, "
            f"{words[1]} {1e3 * statistics.median(times[1]):.2f} ms")
    name = f"{name}: resolved / multirate" if words[1] == "resolved" else name
    return Row(name, ratio, note=note)


@dataclass
class Error:
    """How far a criterion's value with leaps is from the resolved one, in per cent of its tolerance."""

    name: str
    median: float
    high: float
    worst: float
    point: str
    above: int
    other: int


def errors(leaping, resolved, points):
    """An error for every criterion."""
    tables = []
    for study in [leaping, resolved]:
        verify(study, "--isolation", "none", "--points", points)
        folder = WORK / "verification"
        with open(folder / "points.csv", encoding="utf-8", newline="") as file:
            tables.append(list(csv.DictReader(file)))
        summary = json.loads((folder / "summary.json").read_text(encoding="utf-8"))
    if any(row["status"] != "ok" for table in tables for row in table):
        failed = [row["point"] for table in tables for row in table if row["status"] != "ok"]
        raise Trouble(f"points {', '.join(failed)} failed")
    found = []
    for name, criterion in summary["criteria"].items():
        apart = [(100 * abs(float(a[name]) - float(b[name])) / criterion["tolerance"], a["point"])
                 for a, b in zip(*tables, strict=True)]
        values = sorted(value for value, _ in apart)
        worst, point = max(apart)
        found.append(Error(name, statistics.median(values), values[int(0.99 * (len(values) - 1))], worst, point,
                           sum(value > 1 for value in values),
                           sum(a[f"{name}.ok"] != b[f"{name}.ok"] for a, b in zip(*tables))))
    return found


def boundary(scale, fmu):
    """The FMU's doStep over the stand called from Rust."""
    rows = []
    for name, step, few, many in [("1 ms steps", 1e-3, 500, 5000), ("one 150 s step a run", 150.0, 30, 300)]:
        many = max(few + 1, int(many * scale.work * (4 if step < 1 else 1)))
        runs = 20

        def by_steps(call):
            return longer(lambda steps: call(step, steps, runs), few, many)

        def by_runs(call):
            return longer(lambda runs: call(step, 1, runs), few, many)

        how = by_steps if step < 1 else by_runs
        [ratio], times = in_turns(2 * scale.repetitions, how(direct),
                                  how(lambda *sizes: minimal(fmu, *sizes, get=True)))
        per = runs if step < 1 else 1
        note = f"direct {1e6 * statistics.median(times[0]) / per:.2f} us, FMU {1e6 * statistics.median(times[1]) / per:.2f} us"
        rows.append(Row(f"the stand, {name}, a get each", ratio, note=note, **at_most(ratio, 1.05)))
    return rows


WAYS = ["none", "shared", "fresh"]


def isolation(scale, trivial, foreign=None):
    """What a point costs in the program's own process, in a used one and alone in its own, beside a fork that does nothing."""
    [trivial, touching] = [constant(fmu, 0.1, 10, "final") for fmu in (trivial, subjects.touching())]
    studies = [("the trivial FMU", trivial, 100, 3000, 0.5), ("5 MB touched", touching, 50, 1000, None),
               ("paper-table3.toml", subjects.shipped("paper-table3.toml"), 50, 1000, 1.0),
               ("rig.toml", subjects.shipped("rig.toml"), 20, 200, None)]
    if foreign:
        studies.append((foreign.name, subjects.first_study(foreign), 20, 500, None))
    rows = []
    for name, study, few, many, goal in studies:
        def cpu(way):
            more = 1 if way == "fresh" else 5
            return longer(lambda points: verify(study, "--jobs", 1, "--extra-runs", 0, "--isolation", way, "--points", points).cpu,
                          few, few + more * round(many * scale.work))

        ratios, times = in_turns(scale.repetitions, subjects.fork, *map(cpu, WAYS))
        for way, ratio, seconds in zip(WAYS, ratios, times[1:]):
            cost = Ratio([1e3 * second for second in seconds])
            bound = at_most(cost, goal) if goal and way == "fresh" else {}
            rows.append(Row(f"{name}, {way}", cost, unit=" ms", note=f"{ratio.median:.2f} times a fork that does nothing", **bound))
    return rows


def paper(scale):
    """The paper's 50 points, from the start of the process to the report, against the goal of 0.5 s."""
    rows = []
    for name, study in [("as shipped", subjects.shipped("paper-table3.toml")), ("one 150 s step", table3("multirate"))]:
        seconds = Ratio([verify(study, "--points", 50).cpu for _ in range(2 * scale.repetitions)])
        rows.append(Row(f"paper-table3.toml, {name}: CPU time of 50 points", seconds, unit=" s", **at_most(seconds, 0.5)))
    return rows


@dataclass
class Size:
    """One run of a scaling series."""

    points: int
    jobs: int
    place: str
    cpu: float
    wall: float
    memory: float
    worker_memory: float


def scaling(scale, progress):
    """Verifications of more and more points, with one and two workers, and in one process."""
    study = table3("multirate")
    sizes = []
    for points in scale.sizes:
        for jobs, options in [(1, []), (2, []), (2, ["--isolation", "none"])]:
            progress(f"scaling: {points:,} points, {jobs} at a time {' '.join(options)}")
            seen = verify(study, "--points", points, "--jobs", jobs, *options, watch=True)
            sizes.append(Size(points, jobs, "in process" if options else "isolated", seen.cpu, seen.wall,
                              seen.memory, seen.child_memory))
    return sizes


def at_scale(sizes):
    """The goals for a million points, checked at the largest size that was run."""
    most = max(size.points for size in sizes)
    rows = []
    for one in (size for size in sizes if size.points == most):
        how, points = f"{one.jobs} at a time, {one.place}", f"{most:,} points"
        cpu = Ratio([1e3 * one.cpu / most])
        rows.append(Row(f"CPU time a point, {how}", cpu, unit=" ms", note=f"{points}, all included", **at_most(cpu, 1.8)))
        for ten in sizes:
            if (ten.points, ten.jobs, ten.place) == (10_000, one.jobs, one.place) and most > 10_000:
                growth = Ratio([one.cpu / most * ten.points / ten.cpu])
                rows.append(Row(f"CPU time a point over that at 10,000 points, {how}", growth, **at_most(growth, 1.1)))
        memory = Ratio([one.memory])
        rows.append(Row(f"peak resident memory, {how}", memory, unit=" MB", note=points, **at_most(memory, 200)))
        if one.worker_memory:
            memory = Ratio([one.worker_memory])
            rows.append(Row(f"peak resident memory of the largest worker, {how}", memory, unit=" MB", note=points, **at_most(memory, 200)))
    return rows


def film(scale):
    """A step of the Reynolds film over the time of its counted operations at the machine's peak."""
    steps = round(600 * scale.work)
    seen = [[float(word) for word in subjects.bound(steps).split()] for _ in range(scale.repetitions)]
    ratio = Ratio([seconds / (operations / peak) for seconds, operations, peak in seen])
    seconds, operations, peak = (statistics.median(column) for column in zip(*seen))
    note = (f"{1e6 * seconds:.0f} us a step; {operations / 1e3:.0f} thousand operations at {peak / 1e9:.1f} "
            f"thousand million a second are {1e6 * operations / peak:.0f} us")
    return [Row("a step of 1 ms, 96 x 8 cells, mass-conserving, warm", ratio, note=note)]
