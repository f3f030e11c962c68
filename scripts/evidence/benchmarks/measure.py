"""CPU time, memory and wall time of commands, and ratios of what was measured in turns."""

import os
import statistics
import subprocess
import threading
import time
from dataclasses import dataclass, field
from pathlib import Path


class Trouble(Exception):
    """The reason why a part cannot be measured."""


@dataclass
class Cost:
    """Time and memory of a command, with its child processes."""

    cpu: float
    wall: float
    memory: float
    child_memory: float
    text: str


def cost(command, allowed=(0,), watch=False):
    """Runs a command to its end. Memory, in MB, is looked at only with `watch`."""
    command = [str(part) for part in command]
    begun = time.perf_counter()
    process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    peak = Peak(process.pid)
    if watch:
        peak.start()
    text, complaint = [], []
    readers = [threading.Thread(target=lambda: text.append(process.stdout.read())),
               threading.Thread(target=lambda: complaint.append(process.stderr.read()))]
    for reader in readers:
        reader.start()
    _, status, usage = os.wait4(process.pid, 0)
    wall = time.perf_counter() - begun
    process.returncode = os.waitstatus_to_exitcode(status)
    peak.done.set()
    for reader in readers:
        reader.join()
    if process.returncode not in allowed:
        raise Trouble(f"`{' '.join(command)}` ended with {process.returncode}: {complaint[0].strip()}")
    return Cost(usage.ru_utime + usage.ru_stime, wall, peak.own, peak.largest_child, text[0])


class Peak(threading.Thread):
    """The most resident memory that a process and its children held, each its own peak (VmHWM), MB."""

    def __init__(self, pid):
        super().__init__(daemon=True)
        self.pid, self.done, self.most = pid, threading.Event(), {}

    def run(self):
        while not self.done.wait(0.05):
            for pid in family(self.pid):
                self.most[pid] = max(self.most.get(pid, 0), high_water(pid))

    @property
    def own(self):
        return self.most.get(self.pid, 0) / 1e3

    @property
    def largest_child(self):
        return max((peak for pid, peak in self.most.items() if pid != self.pid), default=0) / 1e3


def family(pid):
    """A process and its children."""
    try:
        children = Path(f"/proc/{pid}/task").glob("*/children")
        return [pid, *(int(child) for file in children for child in file.read_text().split())]
    except OSError:
        return [pid]


def high_water(pid):
    """The peak of a process's resident memory, kB; zero when it has ended."""
    try:
        for line in Path(f"/proc/{pid}/status").read_text().splitlines():
            if line.startswith("VmHWM:"):
                return int(line.split()[1])
    except OSError:
        pass
    return 0


@dataclass
class Ratio:
    """One thing compared with another: a ratio a repetition."""

    values: list = field(default_factory=list)

    @property
    def median(self):
        return statistics.median(self.values)

    @property
    def low(self):
        return min(self.values)

    @property
    def high(self):
        return max(self.values)


def in_turns(repetitions, base, *others):
    """Measures all of them, one after another, again and again: a ratio to `base` for each other one,
    and all that was measured, a list each. Every argument gives a number when called."""
    measured = [[] for _ in range(1 + len(others))]
    for repetition in range(repetitions):
        order = list(enumerate([base, *others]))
        for index, subject in order if repetition % 2 == 0 else reversed(order):
            measured[index].append(subject())
    first, *rest = measured
    ratios = [Ratio([value / one for value, one in zip(values, first)]) for values in rest]
    return ratios, measured
