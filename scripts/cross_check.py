"""What the FMI project's cross-check asks for (rules, version 4.1); see scripts/cross-check."""

import os
import shutil
import subprocess
import sys
import tomllib
import zipfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from fmpy import read_model_description, simulate_fmu
from fmpy.util import read_csv, read_ref_opt_file, validate_result

ROOT = Path(__file__).resolve().parent.parent
PLACE = Path(os.environ.get("CROSS_CHECK", ROOT / "dist" / "cross-check"))
ORCHESTRATOR = os.environ["ORCHESTRATOR"]
VERSION = tomllib.loads((ROOT / "Cargo.toml").read_text())["workspace"]["package"]["version"]
# The rules know no others.
PLATFORMS = ("linux64", "win64", "darwin64")
LARGEST = 1_000_000
MOST_VARIABLES = 10
# A reference solution is found again when it is met within this share of each variable's range.
RELATIVE_TOLERANCE = 1e-4
# As fmpy judges imports.
MOST_OUTSIDE = 0.1


@dataclass
class Example:
    """An FMU that is published, and the run that is its reference."""

    name: str
    title: str
    stop: float
    step: float
    record: list[str]
    inputs: dict[str, list[tuple[float, float]]]

    def options(self):
        return (
            f"StartTime, 0.0\nStopTime, {self.stop}\nStepSize, {self.step}\nRelTol, {RELATIVE_TOLERANCE}\n"
            f"OutputIntervalLength, {self.step}\n"
        )

    def input_table(self):
        times = sorted({time for points in self.inputs.values() for time, _ in points})
        rows = [",".join(f'"{name}"' for name in ["time", *self.inputs])]
        for time in times:
            values = [np.interp(time, *zip(*points, strict=True)) for points in self.inputs.values()]
            rows.append(",".join(repr(float(number)) for number in [time, *values]))
        return "\n".join(rows) + "\n"


EXAMPLES = [
    Example(
        "PlainBearingStand",
        "A plain-bearing test stand. The shaft speeds up, and a force is added to the load.",
        10.0, 0.01,
        [f"sensor.{name}" for name in ("loadForce", "frictionTorque", "frictionCoefficient", "bearingTemperature",
                                       "oilTemperature")],
        {"drive.speed": [(0, 20), (2, 20), (6, 60), (10, 60)], "load.externalForce": [(0, 0), (4, 0), (8, 300), (10, 300)],
         "thermal.ambientTemperature": [(0, 295.15)]},
    ),
    Example("Tank", "A tank of water that drains through a hole while water flows in.", 200.0, 0.5, ["level", "outflow"],
            {"inflow": [(0, 0), (50, 0.004), (120, 0.004), (200, 0.0)]}),
    Example("Lag", "A first-order lag that follows a ramp.", 10.0, 0.01, ["output", "feed"],
            {"input": [(0, 0), (1, 0), (4, 2), (10, -1)], "inverted": [(0, 0)]}),
]


class Wrong(Exception):
    """A rule that is not met, or a run that failed."""


def run(*command):
    done = subprocess.run([str(part) for part in command], cwd=ROOT, text=True, capture_output=True)
    if done.returncode != 0:
        raise Wrong(done.stderr.strip().splitlines()[-1] if done.stderr.strip() else f"exit code {done.returncode}")
    return done.stdout


def simulate(fmu, output, record, options, inputs=None):
    """A run of the orchestrator; its table, with the names in quotes as the rules want them."""
    more = ["--input", inputs] if inputs else []
    step = options["StepSize"] or options.get("OutputIntervalLength") or (options["StopTime"] - options["StartTime"]) / 1000
    run(ORCHESTRATOR, "simulate", fmu, "--start", options["StartTime"], "--stop", options["StopTime"], "--step", step,
        "--record", ",".join(record), "--output", output, *more)
    head, rows = output.read_text().split("\n", 1)
    output.write_text(",".join(f'"{name.strip(chr(34))}"' for name in head.split(",")) + "\n" + rows)


def build(example, file):
    """The FMU, packed for this machine; the stand for all platforms that dist/ has it for."""
    stand = ROOT / "dist" / "PlainBearingStand.fmu"
    if example.name == "PlainBearingStand":
        if not stand.is_file():
            run(ROOT / "scripts" / "package-fmu")
        shutil.copyfile(stand, file)
        return
    package = {"Tank": "own-model", "Lag": "lag"}[example.name]
    # The tests build what they share with others.
    profile = os.environ.get("PROFILE", "release")
    run("cargo", "run", "--locked", "--quiet", "--package", package, "--", "--profile", profile, "--output", file)


def check_table(file, names, options):
    """The rules of csv files; the values."""
    text = file.read_text()
    if len(text) > LARGEST:
        raise Wrong(f"{file.name}: {len(text)} bytes, more than {LARGEST}")
    head = text.split("\n", 1)[0]
    wanted = ",".join(f'"{name}"' for name in ["time", *names])
    if head != wanted:
        raise Wrong(f"{file.name}: the first line is {head}, and should be {wanted}")
    table = read_csv(file)
    time = table["time"]
    if time[0] != options["StartTime"] or abs(time[-1] - options["StopTime"]) > 1e-9 * options["StopTime"]:
        raise Wrong(f"{file.name}: runs from {time[0]} to {time[-1]} s, not over the time of the options")
    if np.any(np.diff(time) < 0):
        raise Wrong(f"{file.name}: the time falls")
    if not all(np.all(np.isfinite(table[name])) for name in table.dtype.names):
        raise Wrong(f"{file.name}: not all values are finite")
    return table


def check_export(folder, example):
    """Every rule that can be checked here. fmpy has to find the reference solution."""
    fmu = folder / f"{example.name}.fmu"
    options = read_ref_opt_file(folder / f"{example.name}_ref.opt")
    known = {variable.name: variable for variable in read_model_description(fmu, validate=True).modelVariables}
    for name in example.record:
        if name not in known:
            raise Wrong(f"{example.name}: no variable `{name}`")
    inputs = {name for name, variable in known.items() if variable.causality == "input"}
    if inputs != set(example.inputs):
        raise Wrong(f"{example.name}: its inputs are {', '.join(sorted(inputs))}")
    if len(example.record) > MOST_VARIABLES:
        raise Wrong(f"{example.name}: {len(example.record)} variables, more than {MOST_VARIABLES}")
    check_table(folder / f"{example.name}_in.csv", example.inputs, options)
    reference = check_table(folder / f"{example.name}_ref.csv", example.record, options)
    found = simulate_fmu(fmu, validate=True, stop_time=options["StopTime"], step_size=options["StepSize"],
                         output_interval=options["StepSize"], input=read_csv(folder / f"{example.name}_in.csv"),
                         output=example.record)
    worst = 0.0
    for name in example.record:
        again = np.interp(reference["time"], found["time"], found[name])
        extent = np.ptp(reference[name]) or abs(reference[name][0]) or 1.0
        worst = max(worst, float(np.max(np.abs(again - reference[name])) / extent))
    if not worst <= RELATIVE_TOLERANCE:
        raise Wrong(f"{example.name}: fmpy is off by {worst:.2g} of a variable's range")
    return worst


def export(example):
    """Writes one FMU with its files for every platform that it has, and checks what can run here."""
    first = None
    work = PLACE / "work"
    work.mkdir(parents=True, exist_ok=True)
    fmu = work / f"{example.name}.fmu"
    build(example, fmu)
    inside = {name.split("/")[1] for name in zipfile.ZipFile(fmu).namelist() if name.startswith("binaries/")}
    for platform in [name for name in PLATFORMS if name in inside]:
        folder = PLACE / "fmus" / "2.0" / "cs" / platform / "fmu-export" / VERSION / example.name
        folder.mkdir(parents=True)
        shutil.copyfile(fmu, folder / fmu.name)
        options = folder / f"{example.name}_ref.opt"
        options.write_text(example.options())
        inputs = folder / f"{example.name}_in.csv"
        inputs.write_text(example.input_table())
        reference = folder / f"{example.name}_ref.csv"
        if first is None:
            simulate(fmu, reference, example.record, read_ref_opt_file(options), inputs)
            first = reference
        else:
            shutil.copyfile(first, reference)
        (folder / "README.md").write_text(
            f"# {example.name}\n\n{example.title}\n\nExported by fmu-export {VERSION}. No licence check, no other libraries.\n"
            f"The reference solution is that of `orchestrator simulate` {VERSION} with the inputs of `{example.name}_in.csv`\n"
            f"(linear between its rows) and steps of {example.step} s.\n"
        )
        worst = check_export(folder, example)
        print(f"{platform:9} {example.name:18} rules met; fmpy finds the reference within {worst:.1e} of each range")
    if first is None:
        raise Wrong(f"{example.name}: holds {', '.join(sorted(inside))}, none of {', '.join(PLATFORMS)}")


def export_all():
    shutil.rmtree(PLACE / "fmus", ignore_errors=True)
    for example in EXAMPLES:
        export(example)
    shutil.rmtree(PLACE / "work")
    print(f"written to {os.path.relpath(PLACE / 'fmus')}")


def try_import(folder, name):
    """Simulates an FMU of another tool as its reference was; `passed` or why not."""
    if not (folder / f"{name}.fmu").is_file():
        return "rejected", "the FMU is not public"
    try:
        options = read_ref_opt_file(folder / f"{name}_ref.opt")
        reference = read_csv(folder / f"{name}_ref.csv")
    except Exception as error:  # Files of others: any mistake is possible.
        return "rejected", f"its reference breaks the rules: {error}"
    inputs = folder / f"{name}_in.csv"
    output = PLACE / "work" / "out.csv"
    output.parent.mkdir(parents=True, exist_ok=True)
    try:
        simulate(folder / f"{name}.fmu", output, list(reference.dtype.names[1:]), options, inputs if inputs.is_file() else None)
    except Wrong as wrong:
        return "failed", str(wrong)
    # The share of values outside of the reference's band (10 % of its range), the greatest of all variables.
    share = validate_result(read_csv(output), reference, options["StopTime"])
    if share > MOST_OUTSIDE:
        return "failed", f"{share:.0%} of a variable's values lie outside of the reference's band"
    return "passed", ""


def import_all(repository):
    fmus = Path(repository) / "fmus" / "2.0" / "cs" / "linux64"
    if not fmus.is_dir():
        raise Wrong(f"{repository}: no folder fmus/2.0/cs/linux64; give a checkout of the cross-check repository")
    shutil.rmtree(PLACE / "results", ignore_errors=True)
    counts = {}
    for folder in sorted(path for path in fmus.glob("*/*/*") if path.is_dir()):
        outcome, why = try_import(folder, folder.name)
        counts[outcome] = counts.get(outcome, 0) + 1
        tool, version = folder.parts[-3:-1]
        place = PLACE / "results" / "2.0" / "cs" / "linux64" / "plain-bearing-orchestrator" / VERSION / tool / version / folder.name
        place.mkdir(parents=True)
        (place / outcome).touch()
        if why:
            (place / "README.md").write_text(f"`orchestrator simulate`: {why}\n")
        print(f"{outcome:9} {tool} {version} {folder.name}  {why}", flush=True)
    shutil.rmtree(PLACE / "work", ignore_errors=True)
    print(", ".join(f"{count} {outcome}" for outcome, count in sorted(counts.items())) or "no FMU there")


if __name__ == "__main__":
    try:
        export_all() if sys.argv[1] == "export" else import_all(sys.argv[2])
    except Wrong as wrong:
        sys.exit(f"cross-check: {wrong}")
