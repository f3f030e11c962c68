"""How long a run takes to end after a signal, whatever the FMU of its points does; prints a Markdown table.

Times are asserted nowhere in the tests, as they depend on the machine. This command measures them."""

import argparse
import os
import random
import signal
import statistics
import tempfile
import time
from pathlib import Path

from faulty import MODELS, Workshop
from laboratory import NO_TIMEOUT, PAUSE, study

# Besides those that would wait for --point-timeout: models that leave processes or threads behind, or shield themselves.
OTHERS = {"starts_a_daemon", "starts_children", "leaves_threads_behind", "ignores_signals", "kills_its_parent"}
# How many points are in the journal when the signal comes, and how much later it comes at the most, s. Two workers hang
# from the tenth point on.
MOMENTS, LATER = (0, 4, 8), 0.5
SIGNALS = (signal.SIGINT, signal.SIGTERM)
DEADLINE = 20.0


def arguments():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seed", type=int, default=1, help="seed of the moments [1]")
    parser.add_argument("--models", nargs="*", help="these models only")
    parser.add_argument("--every", action="store_true", help="print each run")
    return parser.parse_args()


def ending(run, points, later, number):
    """Seconds from the signal to the end of the run, and to that of its last process; None where it had ended before."""
    process = run.start()
    end = time.monotonic() + DEADLINE
    while process.poll() is None and run.progress() < points and time.monotonic() < end:
        time.sleep(0.001)
    time.sleep(later)
    if process.poll() is not None:
        run.strays()
        return None
    begun = time.monotonic()
    process.send_signal(number)
    process.wait()
    ended = time.monotonic() - begun
    strays = run.strays()
    if strays:
        raise SystemExit(f"{run.name}: processes are left: {strays}")
    return ended, time.monotonic() - begun


def measure(options, folder):
    """The times of each model."""
    workshop, chance = Workshop(folder), random.Random(options.seed)
    wanted = [model for model in MODELS if model.waits or model.name in OTHERS]
    wanted = [model for model in wanted if not options.models or model.name in options.models]
    for model in wanted:
        fmu, times = workshop.model(model), []
        for number in SIGNALS:
            for points in MOMENTS:
                place = folder / f"{model.name}-{number.name}-{points}"
                place.mkdir()
                command = ["--point-timeout", NO_TIMEOUT, *model.options]
                run = study(place, fmu, {9, 10}, options=command, pause=PAUSE)
                found = ending(run, points, chance.uniform(0, LATER), number)
                if options.every:
                    print(model.name, number.name, points, found, flush=True)
                times += [found] if found else []
        yield model.name, times


def main():
    options = arguments()
    print("| model | runs | median, s | longest, s | until its last process has ended, s |\n|---|---|---|---|---|")
    every = []
    with tempfile.TemporaryDirectory() as folder:
        for name, times in measure(options, Path(folder)):
            every += times
            print(line(name, times), flush=True)
    print(line("all", every))
    print(f"\nLoad average at the end: {os.getloadavg()[0]:.1f}.")


def line(name, times):
    if not times:
        return f"| {name} | 0 | | | |"
    ended, last = zip(*times)
    return f"| {name} | {len(times)} | {statistics.median(ended):.2f} | {max(ended):.2f} | {max(last):.2f} |"


if __name__ == "__main__":
    main()
