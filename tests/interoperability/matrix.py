#!/usr/bin/env python3
"""Runs the FMU through every importer that installs, and compares their outputs with our own.

The same start values, the same communication points; each importer in a Python environment of
its own under .cache/importers. With --write the table goes into docs/evidence/importers.csv.
Exit code 1 when an importer that runs here fails or differs by more than 1e-12.
"""

import argparse
import csv
import json
import os
import shutil
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path

HERE = Path(__file__).resolve().parent
ROOT = HERE.parent.parent
CACHE = ROOT / ".cache" / "importers"
FMU = ROOT / "dist" / "PlainBearingStand.fmu"
ORCHESTRATOR = ROOT / os.environ.get("CARGO_TARGET_DIR", "target") / os.environ.get("PROFILE", "debug") / "orchestrator"
TABLE = ROOT / "docs/evidence/importers.csv"
TOLERANCE = 1e-12

sys.path[:0] = [str(HERE / "importers"), str(ROOT / "scripts")]
from platforms.common import Failure  # noqa: E402
from platforms.debian import install  # noqa: E402
from scenario import OUTPUTS, START, STEP, STEPS, STOP  # noqa: E402

# name, its runner, its packages (the first names the environment)
PYTHON = [
    ("FMPy", "use_fmpy", ["fmpy"]),
    ("libcosimpy (libcosim, FMI Library)", "use_libcosimpy", ["libcosimpy"]),
    ("ecospy (ECOS)", "use_ecos", ["ecospy"]),
    ("FMU Manipulation Toolbox", "use_toolbox", ["fmu-manipulation-toolbox", "fmpy"]),
    ("GEMSEO (gemseo-fmu)", "use_gemseo", ["gemseo-fmu"]),
    ("PathSim (pathsim-fmi)", "use_pathsim", ["pathsim-fmi"]),
    ("estim8", "use_estim8", ["estim8", "psutil"]),
    ("fmuloader", "use_fmuloader", ["fmuloader"]),
    ("OMSimulator", None, ["omsimulator"]),
    ("PyFMI", None, ["pyfmi"]),
]
RUST = [("fmi", "use-fmi"), ("fmi-sim", "use-fmi-sim"), ("fmu-runner", "use-fmu-runner")]
# Programs that no registry has: the variable that names the file, and what goes before it and after it on the command line. The
# Checker integrates by the explicit Euler method, which needs short steps.
READERS = [
    ("FMI Library 3 (PyFMI, OMSimulator)", "FMI_LIBRARY", [sys.executable, HERE / "importers/use_fmilibrary.py"], []),
    ("FMI Compliance Checker", "FMU_CHECK", [], ["-h", "2e-5", "-n", "100", "-s", STOP, "-o", os.devnull]),
]
# Libraries that importers need and do not bring: Debian's package, and a file that only this package has.
# libclang.so comes with the headers that bindgen reads; libclang-cpp.so, which LLVM's tools install, does not.
LIBRARIES = {
    "use_ecos": ("libtbb12", "/usr/lib/*/libtbb.so.12*"),
    "rust": ("libclang-dev", "/usr/lib/llvm-*/lib/libclang.so"),
}
# Failures that are not this FMU's fault: how to recognise each, and the words for the table.
KNOWN = {
    "fmuloader": ("undefined symbol: fmi2EnterEventMode",
                  "does not load it: it requires the Model Exchange functions in every FMU"),
    "OMSimulator": ("build.openmodelica.org",
                    "does not install here: its package on PyPI is a script that downloads the "
                    "program from another server"),
    "PyFMI": ("Getting requirements to build wheel",
              "does not install here: PyPI has only the source of version 2.5, which needs the FMI "
              "Library built beforehand; newer versions are on conda-forge"),
}


class Trouble(Exception):
    """The reason why an importer has no result, and its whole output."""

    def __init__(self, why, output=""):
        super().__init__(why)
        self.output = output or why


@dataclass
class Row:
    tool: str
    version: str = ""
    result: str = ""
    difference: float | None = None
    good: bool = True


def last_line(text):
    lines = [line.strip() for line in text.splitlines() if line.strip()]
    errors = [line for line in lines if "rror" in line and not line.startswith("note:")]
    return (errors or lines or ["no output"])[-1]


def run(command, **options):
    done = subprocess.run([str(part) for part in command], capture_output=True, text=True,
                          timeout=900, **options)
    if done.returncode != 0:
        output = done.stdout + done.stderr
        raise Trouble(last_line(output), output)
    return done.stdout


def library(importer):
    """Installs the library that an importer needs, where there is one."""
    package, file = LIBRARIES.get(importer, ("", ""))
    try:
        if package:
            install(package, file=file)
    except Failure as failure:
        raise Trouble(last_line(str(failure))) from failure


def environment(name, packages):
    """The Python of an environment with these packages."""
    folder = CACHE / name
    python = folder / "bin" / "python"
    if not (folder / ".ready").exists():
        shutil.rmtree(folder, ignore_errors=True)
        run([sys.executable, "-m", "venv", folder])
        try:
            run([python, "-m", "pip", "install", "--quiet", *packages])
        except Trouble as trouble:
            raise Trouble(f"does not install here: {trouble}", trouble.output) from trouble
        (folder / ".ready").touch()
    return python


def runs_of(runner, python):
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder) / "samples.json"
        run([python, HERE / "importers" / f"{runner}.py", FMU, out], cwd=folder)
        found = json.loads(out.read_text())
    runs = {name: [[float.fromhex(value) for value in sample] for sample in run]
            for name, run in found["runs"].items()}
    return runs, found["version"], found["note"]


def rust_programs():
    """The folder of the Rust importers, built when that is needed."""
    library("rust")
    target = ROOT / ".cache" / "rust-importers"
    run(["cargo", "build", "--locked"], cwd=HERE / "rust",
        env={**os.environ, "CARGO_TARGET_DIR": str(target)})
    return target / "debug"


def rust_version(package):
    lock = (HERE / "rust" / "Cargo.lock").read_text()
    return lock.split(f'name = "{package}"\nversion = "', 1)[1].split('"', 1)[0]


def rust_samples(program):
    start = ",".join(f"{name}={value!r}" for name, value in START.items())
    text = run([program, FMU, repr(STEP), str(STEPS), start, ",".join(OUTPUTS)])
    return [[float(value) for value in line.removeprefix("sample ").split(",")]
            for line in text.splitlines() if line.startswith("sample ")]


def orchestrator_samples(program):
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder) / "out.csv"
        start = [part for name, value in START.items() for part in ("--set", f"{name}={value!r}")]
        run([program, "simulate", FMU, *start, "--stop", STOP, "--step", STEP, "--output", out])
        rows = list(csv.DictReader(out.open()))
    return [[float(row[name]) for name in OUTPUTS] for row in rows]


def difference(samples, reference):
    """The largest relative difference; a tool may leave out the sample at the start."""
    if len(samples) not in (len(reference), len(reference) - 1):
        raise Trouble(f"{len(samples)} samples in place of {len(reference)}")
    return max(abs(ours - theirs) / max(abs(ours), 1e-300) if ours != theirs else 0.0
               for sample, expected in zip(samples, reference[-len(samples):])
               for theirs, ours in zip(sample, expected, strict=True))


def judged(row, samples, references, note):
    """Compares with the reference run that computes its step sizes as the importer does."""
    differences = {way: difference(samples, run) for way, run in references.items()}
    way = min(differences, key=differences.get)
    row.difference = differences[way]
    row.good = row.difference <= TOLERANCE
    same = "identical" if row.difference == 0.0 else f"differs by {row.difference:.0e}"
    remarks = "; ".join(filter(None, [way, note]))
    row.result = f"{same} ({remarks})" if remarks else same


def python_row(tool, runner, packages, references):
    row = Row(tool)
    try:
        python = environment(packages[0], packages)
        if runner is None:
            raise Trouble("installs, but no runner is written for it yet")
        library(runner)
        runs, row.version, note = runs_of(runner, python)
        judged(row, runs[""], references, note)
    except (Trouble, subprocess.TimeoutExpired) as trouble:
        symptom, why = KNOWN.get(tool, ("", ""))
        known = bool(why) and symptom in getattr(trouble, "output", "")
        row.result = why if known else str(trouble)
        row.good = known or runner is None
    return row


def rust_rows(references):
    rows = []
    for package, program in RUST:
        row = Row(f"Rust crate {package}")
        rows.append(row)
        try:
            row.version = rust_version(package)
            judged(row, rust_samples(rust_programs() / program), references, "")
        except Trouble as trouble:
            row.result, row.good = str(trouble), False
    return rows


def reader_rows():
    """What readers say of the FMUs of FMI 2.0: nothing at the level of a warning or above."""
    rows = []
    for tool, variable, before, after in READERS:
        row = Row(tool)
        rows.append(row)
        program = os.environ.get(variable)
        if program is None:
            row.result = f"not run: {variable} names no file"
            continue
        try:
            faults = []
            for fmu in (FMU, FMU.with_name("PlainBearingStand-me.fmu")):
                command = [*before, program, *after, fmu]
                done = subprocess.run([str(part) for part in command], capture_output=True, text=True, timeout=900)
                faults += [line for line in (done.stdout + done.stderr).splitlines()
                           if line.startswith(("[FATAL]", "[ERROR]", "[WARNING]"))]
                if done.returncode != 0 and not faults:
                    raise Trouble(last_line(done.stdout + done.stderr))
            row.result, row.good = "; ".join(faults) or "reads both FMUs of FMI 2.0 without a warning", not faults
        except (OSError, Trouble, subprocess.TimeoutExpired) as trouble:
            row.result, row.good = str(trouble), False
    return rows


def own_rows(references):
    if not ORCHESTRATOR.exists():
        return []
    row = Row("orchestrator simulate (ours)")
    try:
        row.version = run([ORCHESTRATOR, "--version"]).split()[-1]
        judged(row, orchestrator_samples(ORCHESTRATOR), references, "")
    except Trouble as trouble:
        row.result, row.good = str(trouble), False
    return [row]


def table(rows):
    yield ["Importer", "Version", "Outputs against direct C calls"]
    for row in rows:
        yield [row.tool, row.version or "-", row.result]


def measure():
    python = environment("fmpy", ["fmpy"])
    references, _, _ = runs_of("reference", python)
    rows = own_rows(references)
    for tool, runner, packages in PYTHON:
        print(f"== {tool}", file=sys.stderr, flush=True)
        rows.append(python_row(tool, runner, packages, references))
    print("== Rust crates", file=sys.stderr, flush=True)
    return rows + rust_rows(references) + reader_rows()


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--write", action="store_true", help="write the table into docs/evidence/importers.csv")
    options = parser.parse_args()
    if not FMU.is_file():
        raise SystemExit(f"{FMU} is missing: run scripts/package-fmu first")
    rows = measure()
    print(*map(" | ".join, table(rows)), sep="\n")
    if options.write:
        with TABLE.open("w", newline="") as file:
            csv.writer(file, lineterminator="\n").writerows(table(rows))
    return 0 if all(row.good for row in rows) else 1


if __name__ == "__main__":
    sys.exit(main())
