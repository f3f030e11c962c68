#!/usr/bin/env python3
"""Runs the four forms of the stand and of the lag (FMI 2.0 and 3.0, Co-Simulation and Model Exchange) with the examples of the
standard and the options of `fmusim` that `python -m fmu_orchestrator.importers` does not use, and compares the results.

`fmusim` and the examples of the standard are compiled from a checkout of github.com/modelica/Reference-FMUs at commit 690a339, the
last with `fmusim`: REFERENCE_FMUS names its folder; without it the repository is cloned into .cache. They need Debian's gcc,
libxml2-dev, zlib1g-dev, libminizip-dev and libsundials-dev. With --write the table goes into docs/evidence/forms.csv. Exit code 1
when a program fails or differs.
"""

import argparse
import csv
import os
import subprocess
import sys
import tempfile
from pathlib import Path

import fmpy
import numpy as np

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "python"))
from fmu_orchestrator.importers._tools import Trouble, run  # noqa: E402

DIST = ROOT / "dist"
COMMIT = "690a339"
TABLE = ROOT / "docs/evidence/forms.csv"
OUTPUTS = ["sensor.loadForce", "sensor.frictionTorque", "sensor.bearingTemperature", "bearing.eccentricityRatio",
           "bearing.minFilmThickness", "drive.angle"]
STOP, STEP = 1.0, 0.01
# Relative tolerances: the one that the description suggests, and a tight one where the host integrates.
TOLERANCE = {"cs": 1e-6, "me": 1e-10}
FORMS = [("PlainBearingStand.fmu", 2, "cs"), ("PlainBearingStand-fmi3.fmu", 3, "cs"),
         ("PlainBearingStand-me.fmu", 2, "me"), ("PlainBearingStand-me-fmi3.fmu", 3, "me")]
HEADS = ["FMI 2.0 Co-Simulation", "FMI 3.0 Co-Simulation", "FMI 2.0 Model Exchange", "FMI 3.0 Model Exchange"]
# The standard's examples: their names, the interface, and the solver's step, s. The explicit Euler method of those for Model Exchange
# needs a short one.
EXAMPLES = [("simulate_fmi2_cs", 2, "cs", 0.01), ("simulate_fmi3_cs", 3, "cs", 0.01), ("cs_early_return", 3, "cs", 0.001),
            ("cs_intermediate_update", 3, "cs", 0.001), ("simulate_fmi2_me", 2, "me", 2e-5), ("simulate_fmi3_me", 3, "me", 2e-5)]

# It adds a step to the time that the FMU has returned, so that its second step begins one step late, which the stand refuses; the first
# step is compared.
LATE, LATE_STEP = {"cs_intermediate_update"}, "a step must begin where the last one ended"


def checkout():
    """The folder of the Reference FMUs."""
    given = os.environ.get("REFERENCE_FMUS")
    folder = Path(given) if given else ROOT / ".cache/reference-fmus"
    if not folder.is_dir():
        run(["git", "clone", "--quiet", "https://github.com/modelica/Reference-FMUs", folder])
        run(["git", "-C", folder, "checkout", "--quiet", COMMIT])
    if not (folder / "fmusim").is_dir():
        raise Trouble(f"{folder} has no folder fmusim: check commit {COMMIT} out")
    return folder


def fmusim(folder, into):
    """Compiles fmusim with Debian's libraries. (Its SUNDIALS is older: there the communicator is a pointer.)"""
    program = into / "fmusim"
    sources = [folder / "src" / f"{name}.c" for name in
               ("FMI", "FMI1", "FMI2", "FMI3", "structured_variable_name.yy", "structured_variable_name.tab")]
    run(["gcc", "-w", "-DSUN_COMM_NULL=NULL", '-DFMUSIM_VERSION="0"', f"-I{folder}/include", f"-I{folder}/fmusim",
         "-I/usr/include/libxml2", "-I/usr/include/minizip", *sources, *sorted((folder / "fmusim").glob("*.c")), "-o", program,
         "-lxml2", "-lz", "-lminizip", "-lsundials_cvode", "-lsundials_nvecserial", "-lsundials_sunmatrixdense",
         "-lsundials_sunlinsoldense", "-ldl", "-lm"])
    return program


def columns(path, names):
    """The columns of a table, the time first."""
    with open(path, encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    return np.array([[float(row[name]) for name in ("time", *names)] for row in rows])


def by_fmusim(program, fmu, kind, names, start=(), options=()):
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder) / "out.csv"
        solver = ["--solver", "cvode"] if kind == "me" else []
        variables = [part for name in names for part in ("--output-variable", name)]
        values = [part for name, value in start for part in ("--start-value", name, repr(value))]
        run([program, "--interface-type", kind, "--stop-time", STOP, "--output-interval", STEP, "--tolerance", TOLERANCE[kind],
             "--output-file", out, *solver, *variables, *values, *options, fmu])
        return columns(out, names)


def by_fmpy(fmu, kind, names, tolerance=None):
    result = fmpy.simulate_fmu(str(fmu), fmi_type={"cs": "CoSimulation", "me": "ModelExchange"}[kind], stop_time=STOP,
                               output_interval=STEP, relative_tolerance=tolerance or TOLERANCE[kind], output=names)
    return np.array([[row[name] for name in ("time", *names)] for row in result])


def glue(fmu, step, names):
    """What the examples want to know of a model: config.h, and the recording of variables."""
    description = fmpy.read_model_description(str(fmu))
    references = {variable.name: variable.valueReference for variable in description.modelVariables}
    real = "fmi2Real" if description.fmiVersion == "2.0" else "fmi3Float64"
    get = "FMI2GetReal(S, r, N, v)" if description.fmiVersion == "2.0" else "FMI3GetFloat64(S, r, N, v, N)"
    config = f"""#define MODEL_IDENTIFIER {description.modelName}
#define INSTANTIATION_TOKEN "{description.guid}"
#define FIXED_SOLVER_STEP {step!r}
#define DEFAULT_STOP_TIME {STOP!r}
#define NX {description.numberOfContinuousStates}
#define NZ 0
"""
    source = f"""#define NO_INPUTS
#include "util.h"
#define N {len(names)}
FILE *createOutputFile(const char *name) {{
    FILE *file = fopen(name, "w");
    if (file) fputs("time,{','.join(names)}\\n", file);
    return file;
}}
FMIStatus recordVariables(FMIInstance *S, double time, FILE *file) {{
    const unsigned int r[N] = {{ {', '.join(str(references[name]) for name in names)} }};
    {real} v[N] = {{ 0 }};
    FMIStatus status = {get};
    fprintf(file, "%.17g", time);
    for (int i = 0; i < N; i++) fprintf(file, ",%.17g", v[i]);
    fprintf(file, "\\n");
    return status;
}}
"""
    return config, source


def by_example(folder, name, version, fmu, step, names):
    """Compiles one of the standard's examples for an FMU and runs it."""
    with tempfile.TemporaryDirectory() as work:
        work = Path(work)
        config, source = glue(fmu, step, names)
        (work / "config.h").write_text(config)
        (work / "glue.c").write_text(source)
        fmpy.extract(str(fmu), str(work / "PlainBearingStand"))
        run(["gcc", "-w", f"-DFMI_VERSION={version}", f"-I{work}", f"-I{folder}/include", f"-I{folder}/examples",
             folder / "examples" / f"{name}.c", work / "glue.c", folder / "src/FMI.c", folder / f"src/FMI{version}.c", "-o",
             work / "example", "-ldl", "-lm"])
        done = subprocess.run([work / "example"], cwd=work, capture_output=True, text=True, timeout=900)
        if done.returncode != 0 and not (name in LATE and LATE_STEP in done.stdout):
            raise Trouble(f"{name}: {done.stdout}{done.stderr}")
        return columns(next(work.glob("*_out.csv")), names)


def apart(found, expected):
    """The largest difference of two tables with the same times, relative to the largest value of each column."""
    if len(found) != len(expected) or np.abs(found[:, 0] - expected[:, 0]).max() > 1e-12:
        raise Trouble(f"{len(found)} rows in place of {len(expected)}, or other times")
    return float((np.abs(found - expected).max(axis=0) / np.abs(expected).max(axis=0)).max())


def cell(found, expected, bound):
    difference = apart(found, expected)
    words = "identical" if difference == 0.0 else f"{difference:.0e}"
    return words, difference <= bound


def forms(program, folder):
    """The rows of the table: a name, and a cell with its verdict for each form."""
    # Of all forms: those of Co-Simulation, at the same tolerance or, for Model Exchange, at the tight one.
    expected = {kind: by_fmpy(DIST / FORMS[0][0], "cs", OUTPUTS, tolerance) for kind, tolerance in TOLERANCE.items()}
    rows = []
    updates = by_fmusim(program, DIST / FORMS[1][0], "cs", OUTPUTS, options=["--record-intermediate-values"])
    regular = updates[[np.abs(updates[:, 0] - time).argmin() for time in expected["cs"][:, 0]]]
    rows.append(("fmusim --record-intermediate-values", [None, cell(regular, expected["cs"], 1e-6), None, None]))
    for name, version, kind, step in EXAMPLES:
        print(f"== {name}", file=sys.stderr, flush=True)
        at = [(form[1], form[2]) for form in FORMS].index((version, kind))
        found = by_example(folder, name, version, DIST / FORMS[at][0], step, OUTPUTS)
        # The last row: examples without a tolerance, and the explicit Euler method, are not near the reference to the last digit.
        last = found[[-1]]
        near = expected[kind][[np.abs(expected[kind][:, 0] - last[0, 0]).argmin()]]
        cells = [None] * len(FORMS)
        words, good = cell(last, near, 1e-6 if kind == "cs" else 1e-3)
        cells[at] = (f"{words} at {last[0, 0]:.3g} s", good)
        rows.append((f"example {name}", cells))
    return rows


def lag(program):
    """The four forms of the example `lag` in fmusim: the largest error against the exact solution."""
    errors = {}
    with tempfile.TemporaryDirectory() as folder:
        for version in (2, 3):
            for kind, option in (("cs", []), ("me", ["--exchange"])):
                fmu = Path(folder) / f"lag-{version}-{kind}.fmu"
                run(["cargo", "run", "--manifest-path", ROOT / "Cargo.toml", "--locked", "--quiet", "--package", "lag", "--",
                     "--profile", "dev", "--fmi", version, *option, "--output", fmu])
                found = by_fmusim(program, fmu, kind, ["output"], [("input", 3.0)])
                exact = 6.0 - 5.0 * np.exp(-found[:, 0] / 0.5)
                errors[version, kind] = float(np.abs(found[:, 1] - exact).max())
    return errors


def table(rows, errors):
    """The lines of the file: a program each, and the errors of `lag`."""
    yield ["Program", *HEADS]
    for name, cells in rows:
        yield [name, *("-" if one is None else one[0] for one in cells)]
    yield ["example lag in fmusim, against its exact solution", *(f"{errors[form[1], form[2]]:.0e}" for form in FORMS)]


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--write", action="store_true", help="write the table into docs/evidence/forms.csv")
    options = parser.parse_args()
    folder = checkout()
    with tempfile.TemporaryDirectory() as into:
        program = fmusim(folder, Path(into))
        rows = forms(program, folder)
        errors = lag(program)
        # The events, arrays and the clock of the thermostat, by its own tests.
        run([sys.executable, "-m", "pytest", "-q", "-k", "fmusim", ROOT / "tests/python/test_thermostat.py"],
            env={**os.environ, "FMUSIM": str(program)})
    lines = list(table(rows, errors))
    print(*map(" | ".join, lines), sep="\n")
    if options.write:
        with TABLE.open("w", newline="") as file:
            csv.writer(file, lineterminator="\n").writerows(lines)
    exact = all(error <= (1e-14 if kind == "cs" else 1e-8) for (_, kind), error in errors.items())
    return 0 if exact and all(good for _, cells in rows for one in cells if one for good in one[1:]) else 1


if __name__ == "__main__":
    try:
        sys.exit(main())
    except (Trouble, subprocess.TimeoutExpired) as trouble:
        sys.exit(f"error: {getattr(trouble, 'output', trouble)}")
