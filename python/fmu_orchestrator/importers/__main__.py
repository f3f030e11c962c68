"""Runs one scenario of FMUs in every importer that is installed here, and compares their outputs.

The reference are direct calls of the C functions (by FMPy, where it is installed), for Model Exchange `orchestrator simulate`. Nothing
is fetched but by --install. Exit code 1 where an importer refuses an FMU or differs, or a checker finds something.
"""

import argparse
import csv
import os
import re
import sys
import time
import xml.etree.ElementTree as ET
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from html import escape
from pathlib import Path

from .._errors import OrchestratorError
from .._files import HOME, PACKAGE
from .._fmu import inspect
from . import _tools
from ._tools import Answer, Missing, Scenario, Tool, Trouble

MOST_OUTPUTS, MOST_STEPS = 10, 100
# Relative to an output's largest value: two programs that step alike; two solvers.
TOLERANCE = {"CoSimulation": 1e-6, "ModelExchange": 1e-4}
GOOD, SKIPPED = ("identical", "within", "runs", "accepts it"), ("not installed", "not for it")
COLOURS = {True: "#1a7f37", False: "#b3261e", None: "#8a6100"}


@dataclass
class Row:
    """What a tool makes of an FMU."""

    fmu: str
    tool: str
    version: str = "-"
    verdict: str = ""
    words: str = ""
    seconds: float = 0.0

    @property
    def good(self) -> bool | None:
        """None where nothing was run."""
        return None if self.verdict in SKIPPED else self.verdict in GOOD

    @property
    def cell(self) -> str:
        return {"identical": "identical", "not for it": "-"}.get(self.verdict, f"{self.verdict}: {self.words}".removesuffix(": "))


def scenario(fmu: Path, options: argparse.Namespace) -> Scenario:
    """The wanted scenario, or what the FMU suggests, cut to a hundred steps and ten outputs."""
    found = inspect(fmu)
    # Elements of arrays, which other programs do not name alone, end with their index.
    scalar = [one for one in found["variables"] if one["type"] == "Real" and one.get("storage") in (None, "Float64")
              and (found["fmi_version"] == "2.0" or not one["name"].endswith("]"))]
    # Of names for the same value the first.
    real = list({one["value_reference"]: one for one in reversed(scalar)}.values())[::-1]
    names = [one["name"] for one in real if one["causality"] == "output"] or \
            [one["name"] for one in real if one["causality"] == "local"]
    experiment = found["default_experiment"] or {}
    stop = options.stop or experiment.get("stop") or 1.0
    step = options.step or experiment.get("step") or stop / MOST_STEPS
    steps = max(1, round(min(stop / step, MOST_STEPS if options.stop is None else stop / step)))
    start = {name: float(value) for name, _, value in (one.partition("=") for one in options.set)}
    return Scenario(str(fmu.resolve()), found["fmi_version"], found["interface"].replace("-", "").replace(" ", ""),
                    found["model_identifier"], found["guid"], step, steps, steps * step, start,
                    options.record.split(",") if options.record else names[:MOST_OUTPUTS],
                    {one["name"]: one["value_reference"] for one in scalar}, experiment.get("tolerance"))


def references(wanted: Scenario, environments: Path) -> Mapping[str, list[list[float]]]:
    """The runs to compare with, by the way in which they compute their step sizes."""
    tools = [_tools.REFERENCE, _tools.OWN] if wanted.kind == "CoSimulation" else [_tools.OWN]
    for tool in tools:
        try:
            return _tools.answer(tool, wanted, environments).runs
        except Trouble:
            continue
    return {}


def difference(samples: list[list[float]], reference: list[list[float]], leave: int = 0) -> float:
    """The largest difference relative to an output's largest value; a tool may leave out the sample at the start. So many samples
    at the start do not count."""
    if len(samples) not in (len(reference), len(reference) - 1):
        raise Trouble(f"{len(samples)} samples in place of {len(reference)}")
    worst, least = 0.0, len(reference) - leave
    for theirs, expected in zip(zip(*samples[-least:]), zip(*reference[-least:][-len(samples):])):
        largest = max(map(abs, expected))
        for one, other in zip(theirs, expected):
            if one != other and not (one != one and other != other):
                away = abs(one - other) / largest if largest else float("inf")
                worst = max(worst, away if away == away else float("inf"))
    return worst


def judge(row: Row, answer: Answer, expected: Mapping[str, list[list[float]]], tolerance: float, leave: int) -> None:
    """Compares with the reference run that computes its step sizes as the importer does."""
    row.version = answer.version or "-"
    if not next(iter(expected.values()), [[0.0]])[0]:
        row.verdict, row.words = "runs", "the FMU has no real variables to compare"
        return
    away = {way: difference(answer.runs[""], run, leave) for way, run in expected.items()}
    if not away:
        row.verdict, row.words = "refused", "it runs, but no reference does"
        return
    way = min(away, key=lambda name: away[name])
    row.verdict = "identical" if away[way] == 0.0 else "within" if away[way] <= tolerance else "differs"
    row.words = "; ".join(filter(None, [f"{away[way]:.0e}" if away[way] else "", way, answer.note]))


def asked(tool: Tool, wanted: Scenario, expected: Mapping[str, list[list[float]]], options: argparse.Namespace) -> Row:
    """A tool's row for an FMU."""
    row = Row(Path(wanted.fmu).name, tool.name)
    begin = time.monotonic()
    try:
        if f"{wanted.version} {wanted.kind}" not in tool.forms:
            row.verdict, row.words = "not for it", "it takes " + ", ".join(tool.forms)
        elif not (tool.runner or tool.ask):
            raise Missing(f"not installed: {tool.limit[1]}")
        else:
            answer = _tools.answer(tool, wanted, options.environments)
            if tool.checks:
                row.version, row.verdict = answer.version or "-", "finds" if answer.findings else "accepts it"
                row.words = "; ".join(answer.findings) or answer.note
            else:
                leave = round(options.since / wanted.step) if wanted.kind == "ModelExchange" else 0
                judge(row, answer, expected, options.tolerance or TOLERANCE[wanted.kind], leave)
    except (Trouble, LookupError, ValueError) as trouble:  # the last two: an answer that is none
        symptom, limit = tool.limit
        own = bool(symptom) and symptom in getattr(trouble, "output", "")
        row.verdict = "not installed" if isinstance(trouble, Missing) else "not for it" if own else "refused"
        row.words = limit if own else str(trouble).removeprefix("not installed: ")
    # Without the folders of this machine.
    row.words = " ".join(re.sub(r"(/[\w.~-]+){2,}/(?=[\w.~-])", "", row.words).split())[:300]
    row.seconds = time.monotonic() - begin
    return row


def junit(rows: list[Row], file: Path) -> None:
    """A test a row."""
    suites = ET.Element("testsuites")
    for fmu in dict.fromkeys(row.fmu for row in rows):
        own = [row for row in rows if row.fmu == fmu]
        failures, skipped = (str(sum(row.good is kind for row in own)) for kind in (False, None))
        suite = ET.SubElement(suites, "testsuite", name=fmu, errors="0", tests=str(len(own)), failures=failures, skipped=skipped)
        for row in own:
            test = ET.SubElement(suite, "testcase", classname=f"importers.{fmu}", name=row.tool, time=f"{row.seconds:.3f}")
            if row.good is not True:
                ET.SubElement(test, "skipped" if row.good is None else "failure", message=row.cell)
    file.parent.mkdir(parents=True, exist_ok=True)
    ET.ElementTree(suites).write(file, encoding="utf-8", xml_declaration=True)


def page(rows: Iterable[Row], file: Path) -> None:
    """A table of all rows."""
    lines = "".join(
        f"<tr><td>{escape(row.fmu)}</td><td>{escape(row.tool)}</td><td>{escape(row.version)}</td>"
        f'<td style="color: {COLOURS[row.good]}">{row.verdict}</td><td>{escape(row.words)}</td></tr>' for row in rows)
    head = "".join(f"<th>{name}</th>" for name in ("FMU", "importer", "version", "result", "difference, reason"))
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_text(
        '<!doctype html><html lang="en"><meta charset="utf-8"><title>Importers</title><style>body { font: 15px sans-serif } '
        "td, th { text-align: left; padding: 2px 12px 2px 0; vertical-align: top }</style><h1>One scenario in every importer</h1>"
        f"<p>{escape(' '.join((__doc__ or '').split(chr(10) * 2)[1].split()))}</p><table><tr>{head}</tr>{lines}</table></html>\n",
        encoding="utf-8")


def table(rows: list[Row], file: Path) -> None:
    """A line an FMU, a column a tool that ran; what the file has and was not run now stays."""
    versions, cells = {}, {}
    if file.exists():
        with file.open(newline="", encoding="utf-8") as kept:
            header, *lines = csv.reader(kept)
        names = [max((tool.name for tool in _tools.TOOLS if title.startswith(tool.name)), key=len, default=title) for title in header]
        versions = {name: title.removeprefix(name).strip() or "-" for name, title in zip(names[1:], header[1:])}
        cells = {(line[0], name): cell for line in lines for name, cell in zip(names[1:], line[1:])}
    for row in rows:
        cells[row.fmu, row.tool] = cells.get((row.fmu, row.tool), "") if row.verdict == "not installed" else row.cell
        if row.verdict not in SKIPPED:
            versions[row.tool] = versions.get(row.tool, "-") if row.version == "-" else row.version
    tools = [tool.name for tool in _tools.TOOLS if tool.name in versions]
    with file.open("w", newline="", encoding="utf-8") as out:
        writer = csv.writer(out, lineterminator="\n")
        writer.writerow(["FMU", *(f"{tool} {versions[tool]}".removesuffix(" -") for tool in tools)])
        writer.writerows([fmu, *(cells.get((fmu, tool), "") for tool in tools)] for fmu in dict.fromkeys(fmu for fmu, _ in cells))


def arguments() -> argparse.Namespace:
    own = (Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "fmu-orchestrator") if HOME == PACKAGE else HOME / ".cache"
    parser = argparse.ArgumentParser(prog=_tools.CALL, description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("fmus", nargs="*", type=Path, metavar="MODEL.fmu")
    parser.add_argument("--set", action="append", default=[], metavar="NAME=VALUE", help="start values, in the FMU's units")
    parser.add_argument("--stop", type=float, help="s; else as the FMU suggests, at most a hundred steps")
    parser.add_argument("--step", type=float, help="s")
    parser.add_argument("--record", metavar="NAME,NAME", help="outputs to compare; else the first ten real ones")
    parser.add_argument("--tolerance", type=float, help="relative to an output's largest value; else 1e-6, Model Exchange 1e-4")
    parser.add_argument("--since", type=float, default=0.0, help="s: solvers of Model Exchange are compared from then on")
    parser.add_argument("--only", action="append", default=[], metavar="IMPORTER", choices=[tool.name for tool in _tools.TOOLS])
    parser.add_argument("--install", action="store_true", help="first fetch those that pip and cargo can")
    parser.add_argument("--environments", type=Path, default=own / "importers", help="where they are installed")
    parser.add_argument("--output", type=Path, default=Path("results/importers"), help="folder of the page")
    parser.add_argument("--junit", type=Path, metavar="FILE")
    parser.add_argument("--csv", type=Path, metavar="FILE", help="a line an FMU; what it has and is not run now stays")
    parsed = parser.parse_args()
    if not (parsed.fmus or parsed.install):
        parser.error("name an FMU")
    return parsed


def main() -> int:
    options = arguments()
    tools = [tool for tool in _tools.TOOLS if not options.only or tool.name in options.only]
    for tool in tools if options.install else []:
        try:
            _tools.install(tool, options.environments)
        except Trouble as trouble:
            print(f"{tool.name}: {trouble}", file=sys.stderr)
    rows = []
    for fmu in options.fmus:
        wanted = scenario(fmu, options)
        expected = references(wanted, options.environments)
        for tool in tools:
            rows.append(asked(tool, wanted, expected, options))
            print(f"{rows[-1].fmu}  {tool.name}: {rows[-1].cell}", flush=True)
    if rows:
        page(rows, options.output / "importers.html")
        print(options.output / "importers.html")
    if options.junit:
        junit(rows, options.junit)
    if options.csv:
        table(rows, options.csv)
    return 1 if any(row.good is False for row in rows) else 0


if __name__ == "__main__":
    try:
        sys.exit(main())
    except OrchestratorError as error:
        sys.exit(f"error: {error}")
