"""Studies of the faulty FMUs: each is run undisturbed, some are killed and resumed, and computed by fmpy in fresh processes."""

import shutil
import signal
import threading
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from pathlib import Path

import faulty
import fresh_points
from supervised import Outcome, Study

POINTS = 24
# Points with the fault. Where they wait for the timeout there are two, for which two workers can wait at once.
HIT, HIT_AND_WAITING = {9, 10, 16, 21}, {9, 10}
TIMEOUT, NO_TIMEOUT = "2", "600"  # s, of a point
PAUSE = 0.003  # s, of a point, so that a run that does not let itself be held can be caught half-way
OUTPUTS = ["y", "sum"]
STUDY = """
fmu = "{fmu}"
[parameters.rate]
distribution = "uniform"
min = 0.1
max = 4
[parameters.fault]
distribution = "uniform"
min = 0
max = 1
[criteria.y]
variable = "y"
nominal = 0
tolerance = 1e9
[criteria.sum]
variable = "sum"
nominal = 0
tolerance = 1e9
"""


def rate(point):
    return 0.1 + point / 13


def table(hit, points):
    lines = [f"{point},{rate(point)!r},{int(point in hit)}" for point in range(1, points + 1)]
    return "\n".join(["point,rate,fault", *lines]) + "\n"


def study(folder, fmu, hit, name="out", options=(), points=POINTS, pause=0.0):
    """A study of points that take at least `pause` seconds each."""
    (folder / "study.toml").write_text(STUDY.format(fmu=fmu))
    (folder / "points.csv").write_text(table(hit, points))
    command = ["verify", "study.toml", "--points-from", "points.csv", "--jobs", "2", "--verbose", *options]
    return Study(folder, name, command, {"FAULTY_PAUSE": str(pause)})


@dataclass
class Case:
    """All that was found out about one model."""
    model: faulty.Model
    hit: set
    expected: dict  # by point, the outputs as hex floats
    whole: Outcome
    folder: Path  # of its runs
    resumed: Outcome | None = None  # where a run was to be killed
    killed: bool = False  # whether the kill came before the end
    strays: list = field(default_factory=list)  # what the kill left

    @property
    def outcomes(self):
        return [self.whole] + ([self.resumed] if self.resumed else [])


class Laboratory:
    """Investigates models, some at a time: many of them only wait."""

    def __init__(self, folder):
        self.folder, self.workshop, self.own = folder, faulty.Workshop(folder), threading.local()
        self.threads, self.cases, self.servers = ThreadPoolExecutor(4), {}, []
        self.sound = {}

    def begin(self, models):
        """Investigates models, each with whether a run is to be killed."""
        # Reference values of points without a fault: the same for all models but those with results of their own, as a
        # long test shows.
        self.sound = self.fresh(self.workshop.model(faulty.HEALTHY))
        self.cases = {model.name: self.threads.submit(self.investigate, model, killed) for model, killed in models}

    def case(self, model):
        return self.cases[model.name].result()

    def end(self):
        self.threads.shutdown(cancel_futures=True)
        for server in self.servers:
            server.close()

    def server(self):
        """This thread's fmpy, with an empty folder for what FMUs write."""
        if not hasattr(self.own, "server"):
            self.own.folder = self.folder / f"fmpy-{threading.get_ident()}"
            self.own.server = fresh_points.Server({"FAULTY_FOLDER": str(self.own.folder)})
            self.servers.append(self.own.server)
        shutil.rmtree(self.own.folder, ignore_errors=True)
        self.own.folder.mkdir()
        return self.own.server

    def fresh(self, fmu, hit=(), points=POINTS):
        """Reference values: fmpy runs every point alone in a fresh process."""
        server = self.server()

        def run(numbers):
            points = [{"rate": rate(point), "fault": int(point in hit)} for point in numbers]
            job = {"fmu": str(fmu), "points": points, "outputs": OUTPUTS, "stop": 1.0, "step": 0.05,
                   "own_folders": True}
            return dict(zip(numbers, server.run(job)))

        results = run(range(1, points + 1))
        # A licence that was refused may be granted later.
        results |= run([point for point, result in results.items() if "failure" in result])
        failures = [(point, result["failure"]) for point, result in results.items() if "failure" in result]
        assert not failures, f"fmpy: {failures}"
        return {point: result["values"] for point, result in results.items()}

    def investigate(self, model, killed):
        folder = self.folder / model.name
        folder.mkdir()
        fmu, hit = self.workshop.model(model), HIT_AND_WAITING if model.waits else HIT
        expected = {}
        if model.reproducible:
            # A point with a fault that does not matter gives what it gives without.
            expected = self.fresh(fmu, hit) if model.results == "own" else self.sound
        options = ["--point-timeout", TIMEOUT if model.waits else NO_TIMEOUT, *model.options]
        whole = study(folder, fmu, hit, "whole", options).run()
        case = Case(model, hit, expected, whole, folder)
        if killed:
            case.resumed, case.killed, case.strays = self.kill(folder, fmu, hit, options)
        return case

    def kill(self, folder, fmu, hit, options):
        """Kills a run when it has done some points, and resumes it."""
        for points in (6, 3, 1, 0):
            run = study(folder, fmu, hit, f"killed-{points}", options, pause=PAUSE)
            held = run.mark / "held"
            # Where points have a time limit, those with the fault take all of it.
            if NO_TIMEOUT in options:
                held.touch()
            _, killed, strays = run.interrupted(points, signal.SIGKILL)
            held.unlink(missing_ok=True)
            if killed:
                break
        return run.run("--resume"), killed, strays


def bits(row):
    """The results of a row of points.csv, exactly."""
    return [float(row[name]).hex() if row[name] else None for name in OUTPUTS]


def is_right(case, point, row):
    """Whether a point has the status and the results that it should."""
    status, hit = row["status"], point in case.hit
    if not status.startswith(case.model.hit if hit else "ok"):
        return False
    if not status.startswith("ok"):
        return case.model.words in status and bits(row) == [None, None]
    known = case.expected and not (hit and case.model.results == "any")
    return bits(row) == case.expected[point] if known else None not in bits(row)


def complaints(case, outcome):
    """The faults in the result of a run."""
    if outcome.code != 0:
        end = "it did not end" if outcome.code is None else f"exit code {outcome.code}"
        return [f"{end}: {outcome.said[-400:]}"]
    missing = set(range(1, POINTS + 1)) - set(outcome.points)
    found = [f"no point {point}" for point in missing]
    for point, row in outcome.points.items():
        if not is_right(case, point, row):
            wanted = f"{case.model.hit} {case.model.words}" if point in case.hit else "ok"
            expected = [float.fromhex(value) for value in case.expected.get(point, [])]
            found.append(f"point {point}: {row['status'][:200]} {row['y']} {row['sum']}, not {wanted} {expected}")
    return found
