"""Builds the program for a platform, through its gates."""

import csv
import subprocess
import sys
from pathlib import Path

from . import build as here
from . import cross, gates, host, mac, unwinder
from .common import Failure, Row, native, run, say
from .debian import install

LARGEST = 20e6
# Enough to see that program, study and FMU fit together.
POINTS = 5
COMPILERS = {
    "linux64": here.linux,
    "aarch64-linux": cross.arm_linux,
    "win64": cross.windows,
    "darwin64": lambda: mac.compiler(mac.TARGETS[0]),
    "aarch64-darwin": lambda: mac.compiler(mac.TARGETS[1]),
}


def compiler(platform):
    """How cargo builds for the platform."""
    if platform == "linux64" and native() != "linux64":
        raise Failure("linux64: built on Linux only")
    return COMPILERS[platform]()


def build(platform):
    """The program, built and through the gates, with what the gates found."""
    how = compiler(platform)
    say(f"building the program for {platform}")
    row = Row(platform, file=how.program(), notes=list(how.notes))
    libraries = needs(row)
    size = row.file.stat().st_size
    if size > LARGEST:
        raise Failure(f"the program has {size / 1e6:.1f} MB, more than {LARGEST / 1e6:.0f}")
    row.notes.append(f"{size / 1e6:.1f} MB; needs {' '.join(sorted(libraries))}")
    row.notes.append(step(row))
    return row


def needs(row):
    """The libraries that the program needs, which have to be those that every such system has."""
    if row.platform.endswith(("linux64", "linux")):
        install("binutils", command="readelf")
        libraries = gates.elf(row, {unwinder.LIBRARY})[1]
        if unwinder.LIBRARY not in libraries:
            raise Failure("the program has an unwinder of its own: an FMU that throws would seem to use a wrong address")
        return libraries
    if row.platform == "win64":
        install("binutils", command="objdump")
        return gates.dll(row.file)[1]
    return gates.mach(row)[1]


def step(row):
    """Asks the program for its version where it can be run; says why not where it cannot."""
    runner, why = runner_of(row.platform)
    if why:
        return f"not run: {why}"
    if row.platform == "win64" and runner:
        host.wine_ready()
    said = run([*runner, row.file, "--version"], env=host.quiet(), stderr=subprocess.DEVNULL)
    if not said.startswith("orchestrator "):
        raise Failure(f"{row.platform}: the program tells no version: {said}")
    return f"run{f' under {Path(runner[0]).name}' if runner else ''}"


def paper(row, folder):
    """Verifies points of the paper with the wheel that is installed in a folder; says why not where that cannot be run."""
    runner, why = runner_of(row.platform)
    if why:
        return f"not run: {why}"
    package = folder / "fmu_orchestrator"
    file = package / "bin" / row.file.name
    file.chmod(0o755)
    if row.platform == "win64" and runner:
        host.wine_ready()
    run([*runner, file, "verify", package / "studies/paper-table3.toml", "--points", POINTS, "--output", folder / "out"],
        env=host.quiet())
    with open(folder / "out/points.csv", encoding="utf-8") as table:
        done = [line["status"] for line in csv.DictReader(table)]
    if done != ["ok"] * POINTS:
        raise Failure(f"{row.platform}: the wheel's points are {done}")
    return f"{POINTS} points of the paper run from it{f' under {Path(runner[0]).name}' if runner else ''}"


def runner_of(platform):
    """What runs programs of the platform here, or why nothing does."""
    if platform == native():
        return [], ""
    if platform == "win64":
        return [host.wine()], "" if host.wine() else "no wine"
    if platform == "aarch64-linux":
        return host.arm_again()
    return [], "no such machine here"


if __name__ == "__main__":
    try:
        print(build(sys.argv[1]).file)
    except Failure as failure:
        sys.exit(f"program: {failure}")
