"""Packs a study into each FMU of a folder, verifies what it carries, and looks whether the FMU came to harm: the other entries byte
for byte, FMPy's validation, and a simulation by FMPy before and after. Prints a line an FMU, then the counts; exit code 1 when
something is wrong.

    packed_fmus.py FOLDER [--keep DIR] [--repetitions N]

`--keep` keeps the packed FMUs, for other programs. With `--repetitions` the study of the first FMU is verified so many times, with
other numbers of processes, other isolation and load beside it, and each result is compared with the first: any difference is a false
alarm."""

import argparse
import itertools
import os
import subprocess
import sys
import tempfile
import zipfile
from collections import Counter
from pathlib import Path

import fmpy
from fmpy.validation import validate_fmu

from foreign_fmus import environment, observed, schedule, study, varied
from test_acceptance import PROGRAM

POINTS = 8
MANIFEST = "extra/org.fmi-standard.fmi-ls-ref/fmi-ls-manifest.xml"
WAYS = [*itertools.product(("1", "2", "4"), ("fresh", "shared", "none"), (False, True))]


def run(*arguments, folder, more=None, nice=0):
    return subprocess.run(["nice", f"-n{nice}", PROGRAM, *map(str, arguments)], cwd=folder, text=True, capture_output=True,
                          errors="replace", timeout=900, env={**os.environ, **(more or {})})


def findings(fmu):
    try:
        return [str(problem) for problem in validate_fmu(str(fmu))]
    except Exception as error:
        return [str(error)[:80]]


def simulated(fmu, kind, times, outputs):
    """The bytes of FMPy's result."""
    start, stop, step = times
    try:
        names = [variable.name for variable in outputs]
        return fmpy.simulate_fmu(str(fmu), fmi_type=kind, start_time=start, stop_time=stop, output_interval=step, output=names,
                                 validate=False, timeout=60).tobytes()
    except Exception as error:
        return str(error)[:80]


def harm(fmu, carrier, kind, times, outputs):
    """What is other than before."""
    with zipfile.ZipFile(fmu) as before, zipfile.ZipFile(carrier) as after:
        names = [name for name in dict.fromkeys(before.namelist()) if name != MANIFEST]
        told = [f"{name} is another one" for name in names if before.read(name) != after.read(name)]
    if findings(fmu) != findings(carrier):
        told.append("FMPy's validation finds something else")
    first, again, packed = (simulated(one, kind, times, outputs) for one in (fmu, fmu, carrier))
    if first == again and first != packed:
        told.append("FMPy gets another result")
    return told


def packed(fmu, carrier, folder):
    """Packs a study into an FMU; returns what happened, in words, and what is wrong."""
    try:
        description = fmpy.read_model_description(str(fmu), validate=False)
    except Exception as error:
        return f"FMPy cannot read it: {str(error)[:80]}", []
    kind = "CoSimulation" if description.coSimulation else "ModelExchange"
    if not (description.coSimulation or description.modelExchange):
        return "Scheduled Execution only", []
    inputs, outputs, times = varied(description), observed(description), schedule(description, kind)
    if not (inputs and outputs):
        return "nothing to vary or to observe", []
    study(fmu, kind == "CoSimulation", times, inputs, outputs, POINTS, folder)
    more = environment(fmu)
    done = run("verify", "study.toml", "--points-from", "points.csv", "--validation", "--point-timeout", 30, "--output", "out", folder=folder, more=more)
    if done.returncode not in (0, 1):
        return f"not run: {done.stderr.strip()[-120:]}", []
    verdict = done.returncode
    done = run("pack", "study.toml", "--from", "out", "--output", carrier, folder=folder, more=more)
    if done.returncode:
        return "not packed", [done.stderr.strip()[-160:]]
    wrong = harm(fmu, carrier, kind, times, outputs)
    done = run("verify", carrier, "--point-timeout", 30, "--output", "there", folder=folder, more=more)
    met = "The carried result is met again" in done.stdout
    if not met or done.returncode != verdict:
        lines = [line for line in (done.stdout + done.stderr).splitlines() if "differ" in line or "changed" in line or "error" in line]
        wrong.append(f"verify: exit code {done.returncode}: {' | '.join(lines)[:300]}")
    return "met again" if met else "not met again", wrong


def repeated(carrier, folder, times):
    """How many of so many verifications and comparisons find a difference."""
    first, wrong = folder / "first", []
    run("verify", carrier, "--output", first, folder=folder)
    for number in range(times):
        jobs, isolation, loaded = WAYS[number % len(WAYS)]
        load = subprocess.Popen([sys.executable, "-c", "while True: pass"]) if loaded else None
        try:
            done = run("verify", carrier, "--jobs", jobs, "--isolation", isolation, "--output", "again", "--force", folder=folder,
                       nice=number % 2 * 19)
            compared = run("compare", first, "again", "--strict", folder=folder)
        finally:
            if load:
                load.kill()
                load.wait()
        if "No difference" not in done.stdout or compared.returncode:
            wrong.append(f"repetition {number}: {done.stdout[-200:]}{compared.stdout[-200:]}")
        if (number + 1) % 50 == 0:
            print(f"{number + 1} repetitions of {carrier.name}: {len(wrong)} false alarms", flush=True)
    return wrong


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--keep", type=Path)
    parser.add_argument("--repetitions", type=int, default=0)
    options = parser.parse_args()
    counts, faults, first = Counter(), [], None
    with tempfile.TemporaryDirectory() as work:
        keep = (options.keep or Path(work) / "packed").resolve()
        keep.mkdir(parents=True, exist_ok=True)
        for number, fmu in enumerate(sorted(options.folder.resolve().glob("*.fmu"))):
            folder = Path(work) / str(number)
            folder.mkdir()
            how, wrong = packed(fmu, keep / fmu.name, folder)
            counts[how.split(":")[0]] += 1
            faults += wrong
            first = first or (keep / fmu.name if how == "met again" else None)
            print(f"{fmu.name}: {'; '.join([how, *wrong])}", flush=True)
        if options.repetitions and first:
            wrong = repeated(first, Path(work), options.repetitions)
            faults += wrong
            print(*wrong[:3], sep="\n")
    print(", ".join(f"{count} {what}" for what, count in counts.items()), f"; {len(faults)} wrong", sep="")
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
