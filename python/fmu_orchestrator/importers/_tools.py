"""The importers and checkers: what each takes, where it comes from, and how it is asked."""

import csv
import importlib.util
import json
import os
import shutil
import subprocess
import sys
import tempfile
import warnings
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass, field
from pathlib import Path

from .._errors import OrchestratorError, OrchestratorWarning
from .._fmu import simulate

HERE = Path(__file__).resolve().parent
CALL = "python -m fmu_orchestrator.importers"
PATIENCE = 300.0  # s, for a run
OLD, NEW, EXCHANGE, NEWER_EXCHANGE = "2.0 CoSimulation", "3.0 CoSimulation", "2.0 ModelExchange", "3.0 ModelExchange"
STEPPED, ALL = (OLD, NEW), (OLD, NEW, EXCHANGE, NEWER_EXCHANGE)


class Trouble(Exception):
    """The reason why a tool has no result, and its whole output."""

    def __init__(self, why: str, output: str = "") -> None:
        super().__init__(why)
        self.output = output or why


class Missing(Trouble):
    """It is not installed; the reason says how it is."""


@dataclass(frozen=True)
class Scenario:
    """What every importer does: from 0 s, at these communication points, with these start values and outputs."""

    fmu: str
    version: str
    kind: str
    identifier: str
    guid: str
    step: float
    steps: int
    stop: float
    start: Mapping[str, float]
    outputs: Sequence[str]
    references: Mapping[str, int]
    suggested: float | None = None
    """The FMU's tolerance for its own solver."""
    tolerance: float = 1e-8
    """Of solvers, relative."""


@dataclass
class Answer:
    """What a tool has said: samples by the name of the run, or findings."""

    version: str = ""
    note: str = ""
    runs: dict[str, list[list[float]]] = field(default_factory=dict)
    findings: list[str] = field(default_factory=list)


@dataclass(frozen=True)
class Tool:
    """An importer or a checker."""

    name: str
    forms: tuple[str, ...]
    runner: str = ""
    """A script in ``runners/``, or a program of ``rust/``."""
    packages: tuple[str, ...] = ()
    """What pip installs; the first one names the environment."""
    module: str = ""
    crate: str = ""
    variable: str = ""
    """Names the file or folder of a tool that no registry has."""
    source: str = ""
    ask: Callable[["Tool", Scenario, Path], Answer] | None = None
    """For what is no runner."""
    checks: bool = False
    """It reads an FMU, and has no values to compare."""
    limit: tuple[str, str] = ("", "")
    """How its own limit shows, which is no fault of an FMU, and words for it."""


def _last_line(text: str) -> str:
    # What Python says while it ends is no reason.
    lines = [line.strip() for line in text.partition("Exception ignored in")[0].splitlines() if line.strip() and not line.startswith("note:")]
    errors = [line for line in lines if "rror" in line]
    return (errors or lines or ["it said nothing"])[-1]


def _start(command: Sequence[object], cwd: str | None = None, env: Mapping[str, str] | None = None) -> "subprocess.CompletedProcess[str]":
    # What has no folder of its own installs, which takes as long as it takes.
    patience = PATIENCE if cwd else None
    try:
        return subprocess.run([str(part) for part in command], cwd=cwd, env=env, stdin=subprocess.DEVNULL, capture_output=True,
                              text=True, errors="replace", timeout=patience)
    except subprocess.TimeoutExpired:
        raise Trouble(f"no end after {PATIENCE:g} s") from None
    except OSError as error:
        raise Trouble(str(error)) from error


def run(command: Sequence[object], cwd: str | None = None, env: Mapping[str, str] | None = None) -> str:
    """A command's standard output."""
    done = _start(command, cwd, env)
    output = done.stdout + done.stderr
    if done.returncode < 0:
        raise Trouble(f"ends by signal {-done.returncode}", output)
    if done.returncode:
        raise Trouble(_last_line(output), output)
    return done.stdout


def python_of(tool: Tool, environments: Path) -> Path:
    """The Python that has a tool's packages."""
    if not tool.packages or (tool.module and importlib.util.find_spec(tool.module)):
        return Path(sys.executable)
    folder = environments / tool.packages[0]
    if not (folder / ".ready").exists():
        raise _not_there(tool)
    return folder / ("Scripts/python.exe" if os.name == "nt" else "bin/python")


def _not_there(tool: Tool) -> Missing:
    how = f"{tool.variable} names {tool.source}" if tool.variable else f'{CALL} --install --only "{tool.name}"'
    return Missing(f"not installed: {how}")


def install(tool: Tool, environments: Path) -> None:
    """Installs what pip or cargo can, into a folder of its own."""
    if tool.crate:
        run(["cargo", "build", "--locked", "--manifest-path", HERE / "rust/Cargo.toml", "--bin", tool.runner],
            env={**os.environ, "CARGO_TARGET_DIR": str(environments / "rust")})
    folder = environments / (tool.packages or ("none",))[0]
    if tool.packages and not (folder / ".ready").exists():
        shutil.rmtree(folder, ignore_errors=True)
        run([sys.executable, "-m", "venv", folder])
        python = folder / ("Scripts/python.exe" if os.name == "nt" else "bin/python")
        try:
            run([python, "-m", "pip", "install", "--quiet", *tool.packages])
        except Trouble as trouble:
            raise Trouble(f"does not install: {trouble}", trouble.output) from trouble
        (folder / ".ready").touch()


def answer(tool: Tool, scenario: Scenario, environments: Path) -> Answer:
    """Runs the scenario in a tool."""
    if tool.variable and tool.variable not in os.environ:
        raise _not_there(tool)
    if tool.ask:
        return tool.ask(tool, scenario, environments)
    return by_rust(tool, scenario, environments) if tool.crate else by_python(tool, scenario, environments)


def by_python(tool: Tool, scenario: Scenario, environments: Path) -> Answer:
    """By a script in the tool's environment."""
    with tempfile.TemporaryDirectory() as folder:
        given, out = Path(folder) / "scenario.json", Path(folder) / "answer.json"
        given.write_text(json.dumps(asdict(scenario) | {"program": os.environ.get(tool.variable, "")}), encoding="utf-8")
        run([python_of(tool, environments), HERE / "runners" / f"{tool.runner}.py", given, out], cwd=folder)
        found = Answer(**json.loads(out.read_text(encoding="utf-8")))
    found.runs = {name: [[float.fromhex(str(value)) for value in sample] for sample in samples]
                  for name, samples in found.runs.items()}
    return found


def by_rust(tool: Tool, scenario: Scenario, environments: Path) -> Answer:
    """By a program that is built with the crate."""
    program = environments / "rust/debug" / (tool.runner + (".exe" if os.name == "nt" else ""))
    if not program.is_file():
        raise _not_there(tool)
    start = ",".join(f"{name}={value!r}" for name, value in scenario.start.items())
    with tempfile.TemporaryDirectory() as folder:
        text = run([program, scenario.fmu, repr(scenario.step), scenario.steps, start, ",".join(scenario.outputs)], cwd=folder)
    samples = [[float(value) for value in line.removeprefix("sample ").split(",") if value] for line in text.splitlines()
               if line.startswith("sample ")]
    return Answer(crate_version(tool), runs={"": samples})


def crate_version(tool: Tool) -> str:
    """The version of a tool's crate that is built."""
    lock = (HERE / "rust/Cargo.lock").read_text(encoding="utf-8")
    return lock.split(f'name = "{tool.crate}"\nversion = "', 1)[1].split('"', 1)[0]


def by_orchestrator(tool: Tool, scenario: Scenario, environments: Path) -> Answer:
    """By our own program."""
    try:
        warnings.simplefilter("ignore", OrchestratorWarning)
        table = simulate(scenario.fmu, scenario.start, start=0.0, stop=scenario.stop, step=scenario.step, record=scenario.outputs)
    except OrchestratorError as error:
        raise Trouble(str(error)) from error
    return Answer(runs={"": [[float(row[name]) for name in scenario.outputs] for row in table.rows()]})


def by_fmusim(tool: Tool, scenario: Scenario, environments: Path) -> Answer:
    """By a program that writes a table."""
    solver = ["me", "--solver", "cvode", "--tolerance", repr(scenario.tolerance)] if scenario.kind == "ModelExchange" else ["cs"]
    options = ["--interface-type", *solver]
    for name, value in scenario.start.items():
        options += ["--start-value", name, repr(value)]
    for name in scenario.outputs:
        options += ["--output-variable", name]
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder) / "out.csv"
        run([os.environ[tool.variable], *options, "--start-time", 0, "--stop-time", repr(scenario.stop), "--output-interval",
             repr(scenario.step), "--output-file", out, scenario.fmu], cwd=folder)
        with out.open(encoding="utf-8") as file:
            rows = list(csv.DictReader(file))
    # Rows more stand at events.
    steps = [(float(row["time"]) / scenario.step, row) for row in rows]
    at = {round(step): row for step, row in steps if abs(step - round(step)) < 1e-6}
    return Answer(runs={"": [[float(at[i][name]) for name in scenario.outputs] for i in sorted(at)]})


def by_checker(tool: Tool, scenario: Scenario, environments: Path) -> Answer:
    """By the Compliance Checker. Its explicit Euler method for Model Exchange needs short steps."""
    step = scenario.step / (500 if scenario.kind == "ModelExchange" else 1)
    with tempfile.TemporaryDirectory() as folder:
        done = _start([os.environ[tool.variable], "-h", step, "-n", "100", "-s", scenario.stop, "-o", os.devnull, scenario.fmu], cwd=folder)
    lines = (done.stdout + done.stderr).splitlines()
    # It warns of attributes that may be missing.
    faults = [line for line in lines if line.startswith(("[FATAL]", "[ERROR]", "[WARNING]")) and "returning default value" not in line]
    return Answer(findings=faults or ([f"ends with {done.returncode}"] if done.returncode else []))


def by_vdmcheck(tool: Tool, scenario: Scenario, environments: Path) -> Answer:
    """By the model of the standard in VDM: a script for each version of FMI."""
    script = Path(os.environ[tool.variable]) / f"VDMCheck{scenario.version[0]}.sh"
    with tempfile.TemporaryDirectory() as folder:
        done = _start(["bash", script, scenario.fmu], cwd=folder)
    said = [line for line in done.stdout.splitlines() if line.strip()]
    if "No errors found." in said:
        return Answer()
    return Answer(findings=[line for line in said if line != "Errors found."] or [_last_line(done.stdout + done.stderr)])


FMPY = Tool("FMPy", ALL, "use_fmpy", ("fmpy",), "fmpy")
REFERENCE = Tool("FMPy, calling the C functions", STEPPED, "reference", ("fmpy",), "fmpy")
OWN = Tool("orchestrator simulate", ALL, ask=by_orchestrator)
TOOLS = [
    OWN,
    FMPY,
    Tool("fmusim", ALL, variable="FMUSIM", source="the program of modelica/Reference-FMUs at 690a339", ask=by_fmusim),
    Tool("fmi4c", STEPPED, "use_fmi4c", variable="FMI4C", source="libfmi4c.so of robbr48/fmi4c"),
    Tool("libcosim (libcosimpy)", (OLD,), "use_libcosimpy", ("libcosimpy",), "libcosimpy"),
    Tool("ECOS (ecospy)", STEPPED, "use_ecos", ("ecospy",), "ecospy"),
    Tool("FMU Manipulation Toolbox", STEPPED, "use_toolbox", ("fmu-manipulation-toolbox", "fmpy")),
    Tool("GEMSEO (gemseo-fmu)", STEPPED, "use_gemseo", ("gemseo-fmu",), "gemseo_fmu",
         limit=("SimpleType.__init__() got an unexpected keyword argument 'description'", "the FMPy that it brings does not know "
                "descriptions of types in FMI 3.0")),
    Tool("PathSim (pathsim-fmi)", STEPPED, "use_pathsim", ("pathsim-fmi",), "pathsim_fmi",
         limit=("in get_outputs_as_array", "reads outputs of every type as real numbers")),
    Tool("estim8", (OLD,), "use_estim8", ("estim8", "psutil"), "estim8"),
    Tool("fmuloader", (OLD,), "use_fmuloader", ("fmuloader",), "fmuloader",
         limit=("undefined symbol: fmi2EnterEventMode", "requires the Model Exchange functions in every FMU")),
    Tool("Rust crate fmi", (OLD,), "use-fmi", crate="fmi"),
    Tool("Rust crate fmi-sim", STEPPED, "use-fmi-sim", crate="fmi-sim",
         limit=('UnknownField { name: "BaseUnit"', "does not know all exponents of units in FMI 3.0")),
    Tool("Rust crate fmi-rs", (OLD,), "use-fmi-rs", crate="fmi-rs"),
    Tool("Rust crate fmu-runner", (OLD,), "use-fmu-runner", crate="fmu-runner"),
    Tool("PyFMI", ALL, "", ("pyfmi",), "pyfmi", limit=("Getting requirements to build wheel", "PyPI has only the source of 2.5, which "
         "needs the FMI Library built beforehand")),
    Tool("OMSimulator", ALL, "", ("omsimulator",), limit=("build.openmodelica.org", "its package on PyPI downloads the program from "
         "another server")),
    Tool("FMI Library", ALL, "use_fmilibrary", variable="FMI_LIBRARY", source="libfmilib_shared.so of modelon-community/fmi-library",
         checks=True),
    Tool("FMI Compliance Checker", (OLD, EXCHANGE), variable="FMU_CHECK", source="the program of modelica-tools/FMUComplianceChecker",
         ask=by_checker, checks=True),
    Tool("VDMCheck", ALL, variable="VDMCHECK", source="a folder with VDMCheck2.sh and VDMCheck3.sh of "
         "INTO-CPS-Association/FMI-VDM-Model", ask=by_vdmcheck, checks=True),
    Tool("FMPy validation", ALL, "check_fmpy", ("fmpy",), "fmpy", checks=True),
]
