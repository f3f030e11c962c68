#!/usr/bin/env python3
"""Prints what scripts/mutants left in results/mutants, and writes docs/mutation.md when all parts are there.

Exit code 1 when a mutant of the parts just run (the arguments) survives that equivalent.txt does not explain.
"""

import json
import sys
from dataclasses import dataclass, field
from pathlib import Path

HERE = Path(__file__).resolve().parent
ROOT = HERE.parent.parent
RESULTS = ROOT / "results" / "mutants"
PAGE = ROOT / "docs" / "mutation.md"
PARTS = ["solver", "statistics", "verdict", "design"]

HEAD = """# Mutation testing

Written by `scripts/mutants`; edits are lost. It changes the code that decides results, one operator, constant or return
value at a time (cargo-mutants), and runs the unit tests of that code. A mutant is *caught* when a test fails or never
ends, *unviable* when it does not compile. One that *survives* shows a test that is missing, unless it is *equivalent*:
no input makes it behave differently. `scripts/mutation/equivalent.txt` says why.

| part | files | mutants | caught | unviable | equivalent | survive |
|---|---|---|---|---|---|---|
"""


@dataclass
class Part:
    """The mutants of one part."""

    name: str
    files: set = field(default_factory=set)
    counts: dict = field(default_factory=lambda: {"caught": 0, "unviable": 0, "equivalent": 0, "survive": 0})
    survivors: list = field(default_factory=list)


def equivalents():
    """The reasons, by file, function, change and the code that is changed."""
    reasons = {}
    for line in (HERE / "equivalent.txt").read_text(encoding="utf-8").splitlines():
        if line and not line.startswith("#"):
            *key, reason = [cell.strip() for cell in line.split(" | ")]
            reasons[tuple(key)] = reason
    return reasons


def place(mutant):
    """Where a mutant is, without line numbers, which every edit above it changes: the code from the place on."""
    start = mutant["span"]["start"]
    line = (ROOT / mutant["file"]).read_text(encoding="utf-8").splitlines()[start["line"] - 1]
    return mutant["file"], change(mutant), line[start["column"] - 1:].strip()


def change(mutant):
    """The mutation as cargo-mutants words it, without its place."""
    return mutant["name"].split(": ", 1)[1]


def read(name, reasons):
    path = RESULTS / name / "mutants.out" / "outcomes.json"
    if not path.is_file():
        return None
    part = Part(name)
    for outcome in json.loads(path.read_text(encoding="utf-8"))["outcomes"]:
        if outcome["scenario"] == "Baseline":
            continue
        mutant, summary = outcome["scenario"]["Mutant"], outcome["summary"]
        part.files.add(mutant["file"])
        if summary in ("CaughtMutant", "Timeout"):
            part.counts["caught"] += 1
        elif summary == "Unviable":
            part.counts["unviable"] += 1
        elif place(mutant) in reasons:
            part.counts["equivalent"] += 1
        else:
            part.counts["survive"] += 1
            part.survivors.append(place(mutant))
    return part


def cells(line):
    """A row of the survivors; a bar would end a cell."""
    file, what, code = (cell.replace("|", "\\|") for cell in line)
    return f"`{file}` | {what} | `{code}`"


def page(parts):
    text = HEAD
    for part in parts:
        files = "<br>".join(f"`{file}`" for file in sorted(part.files))
        total = sum(part.counts.values())
        text += f"| {part.name} | {files} | {total} | " + " | ".join(map(str, part.counts.values())) + " |\n"
    survivors = [line for part in parts for line in part.survivors]
    if survivors:
        text += "\n## Survivors\n\n| file | mutation | code |\n|---|---|---|\n"
        text += "".join(f"| {cells(line)} |\n" for line in survivors)
    return text


def main():
    reasons = equivalents()
    parts = [part for part in (read(name, reasons) for name in PARTS) if part]
    print(page(parts))
    if len(parts) == len(PARTS):
        PAGE.write_text(page(parts), encoding="utf-8")
    else:
        print(f"docs/mutation.md is not written: only {', '.join(part.name for part in parts)} ran here")
    alive = [line for part in parts if part.name in sys.argv[1:] for line in part.survivors]
    for line in alive:
        print("survives: " + " | ".join(line))
    return 1 if alive else 0


if __name__ == "__main__":
    sys.exit(main())
