"""Runs of the orchestrator that are watched from outside: their deadline, and the processes that they leave behind."""

import json
import os
import signal
import subprocess
import time
from dataclasses import dataclass, field
from pathlib import Path

from test_acceptance import PROGRAM, rows

# So long that only a run that hangs takes it.
DEADLINE = 60.0
# How long the processes of a run may take to end with it.
GRACE = 10.0


@dataclass
class Outcome:
    """Exit code and output of a run."""
    code: int | None  # None: it had to be ended at the deadline
    said: str
    strays: list = field(default_factory=list)
    points: dict = field(default_factory=dict)  # the rows of points.csv by point
    summary: dict = field(default_factory=dict)


class Study:
    """A folder with a study, of which runs are made."""

    def __init__(self, folder, name, command, environment):
        self.folder, self.name, self.command = folder, name, command
        # Every process of a run carries this mark in its environment.
        self.mark = folder / f"run-{name}"
        self.mark.mkdir()
        self.environment = {**os.environ, "FAULTY_FOLDER": str(self.mark), **environment}

    @property
    def output(self):
        return self.folder / self.name

    def start(self, *more):
        # The usual limit of open files, wherever the tests run.
        command = ["prlimit", "--nofile=1024", PROGRAM, *map(str, self.command), "--output", self.output, *more]
        said = open(self.folder / f"{self.name}.log", "ab")
        with said:
            return subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=said, stderr=said, cwd=self.folder,
                                    env=self.environment, start_new_session=True)

    def processes(self):
        """The processes of this study's runs that live, with their names; one that is only waited for does not."""
        mark, found = f"FAULTY_FOLDER={self.mark}\0".encode(), []
        for entry in Path("/proc").iterdir():
            try:
                if entry.name.isdigit() and mark in (entry / "environ").read_bytes() + b"\0":
                    found.append((int(entry.name), (entry / "comm").read_text().strip()))
            except OSError:  # gone meanwhile, or another user's
                continue
        return found

    def strays(self):
        """The processes that are left when a run has ended; they are ended, too."""
        end = time.monotonic() + GRACE
        while (left := self.processes()) and time.monotonic() < end:
            time.sleep(0.02)
        self.end_all()
        return left

    def end_all(self):
        while left := self.processes():
            for process, _ in left:
                try:
                    os.kill(process, signal.SIGKILL)
                except ProcessLookupError:
                    pass
            time.sleep(0.01)

    def finished(self, process):
        """The outcome of a run, waited for."""
        try:
            code = process.wait(DEADLINE)
        except subprocess.TimeoutExpired:
            code = None
            self.end_all()
            process.wait()
        strays = self.strays()
        said = (self.folder / f"{self.name}.log").read_text(errors="replace")
        outcome = Outcome(code, said, strays)
        if (self.output / "summary.json").is_file():
            outcome.points = {int(row["point"]): row for row in rows(self.output / "points.csv")}
            outcome.summary = json.loads((self.output / "summary.json").read_text())
        return outcome

    def run(self, *more):
        return self.finished(self.start(*more))

    def progress(self):
        """How many points the journal has."""
        try:
            return max(0, (self.output / "journal.txt").read_bytes().count(b"\n") - 1)
        except FileNotFoundError:
            return -1

    def interrupted(self, points, number, deadline=DEADLINE):
        """A run that gets a signal when so many points are in its journal: its exit code, whether the signal came
        before its end, and the processes that it left."""
        process = self.start()
        end = time.monotonic() + DEADLINE
        while process.poll() is None and self.progress() < points and time.monotonic() < end:
            time.sleep(0.001)
        running = process.poll() is None
        if running:
            process.send_signal(number)
        try:
            process.wait(deadline)
        except subprocess.TimeoutExpired:
            left = self.processes()
            self.end_all()
            process.wait()
            return None, running, left
        return process.returncode, running, self.strays()
