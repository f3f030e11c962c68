#!/usr/bin/env python3
"""Takes over what scripts/evidence/mutants left in results/mutants into runs.json, and writes docs/evidence/mutation.md from it.

A part that was not run now keeps its earlier row. Exit code 1 when a mutant of the parts just run (the arguments)
survives that equivalent.toml does not explain.
"""

import datetime
import json
import sys
import tomllib
from pathlib import Path

HERE = Path(__file__).resolve().parent
ROOT = HERE.parents[2]
RESULTS = ROOT / "results" / "mutants"
RUNS = HERE / "runs.json"
PAGE = ROOT / "docs/evidence/mutation.md"
PARTS = ["solver", "statistics", "distribution", "design", "conformity", "verdict", "sensitivity"]

HEAD = """# Mutation testing

Written by `scripts/evidence/mutants`; edits are lost. It changes the code that decides results, one operator, constant or return
value at a time (cargo-mutants), and runs its unit tests. A mutant that *survives* shows a missing test; an *equivalent* one behaves as before
(`scripts/evidence/mutation/equivalent.toml` says why); an *unviable* one does not compile. *Tried* are a random sample.

| part | date | mutants | tried | caught | unviable | equivalent | survive |
|---|---|---|---|---|---|---|---|
"""


def equivalents():
    """The reasons, by file, function, change and the code that is changed."""
    text = (HERE / "equivalent.toml").read_text(encoding="utf-8")
    entries = tomllib.loads(text)["equivalent"]
    return {(entry["file"], entry["change"], entry["code"]): entry["why"] for entry in entries}


def place(mutant):
    """Where a mutant is, without line numbers, which every edit above it changes: the code from the place on."""
    start = mutant["span"]["start"]
    line = (ROOT / mutant["file"]).read_text(encoding="utf-8").splitlines()[start["line"] - 1]
    return mutant["file"], change(mutant), line[start["column"] - 1:].strip()


def change(mutant):
    """The mutation as cargo-mutants words it, without its place."""
    return mutant["name"].split(": ", 1)[1]


def known(name):
    """The mutants of a part by their names, with the place and the outcome of those that were tried.

    A part that goes on (MUTANTS_AGAIN) leaves out what it has caught before: `known.json` keeps it.
    """
    folder = RESULTS / name
    store = folder / "known.json"
    mutants = json.loads(store.read_text(encoding="utf-8")) if store.is_file() else {}
    # A run that was interrupted has not come here: its results are those before the last ones.
    for last in filter(Path.is_dir, [folder / "mutants.out.old", folder / "mutants.out"]):
        for mutant in json.loads((last / "mutants.json").read_text(encoding="utf-8")):
            mutants.setdefault(mutant["name"], None)
        for outcome in json.loads((last / "outcomes.json").read_text(encoding="utf-8"))["outcomes"]:
            if outcome["scenario"] != "Baseline":
                mutant = outcome["scenario"]["Mutant"]
                mutants[mutant["name"]] = [place(mutant), outcome["summary"]]
    now = folder / "now.json"
    if now.is_file():
        names = {mutant["name"] for mutant in json.loads(now.read_text(encoding="utf-8"))}
        mutants = {name: known for name, known in mutants.items() if name in names}
    store.write_text(json.dumps(mutants, indent=1) + "\n", encoding="utf-8")
    return mutants


def read(name, reasons):
    """The counts and survivors of a part that was just run."""
    mutants = known(name)
    outcomes = [outcome for outcome in mutants.values() if outcome]
    run = {
        "date": datetime.date.today().isoformat(),
        "files": sorted({mutant.split(":")[0] for mutant in mutants}),
        "mutants": len(mutants),
        "tried": len(outcomes), "caught": 0, "unviable": 0, "equivalent": 0, "survivors": [],
    }
    for where, summary in outcomes:
        if summary in ("CaughtMutant", "Timeout"):
            run["caught"] += 1
        elif summary == "Unviable":
            run["unviable"] += 1
        elif tuple(where) in reasons:
            run["equivalent"] += 1
        else:
            run["survivors"].append(where)
    return run


def code(text):
    """Code in a cell of a table: a bar would end the cell."""
    return "`" + text.replace("|", "\\|") + "`"


def page(runs):
    text = HEAD
    for name in PARTS:
        if name not in runs:
            text += f"| {name} | not run yet | | | | | | |\n"
            continue
        run = runs[name]
        counts = [run[key] for key in ("mutants", "tried", "caught", "unviable", "equivalent")]
        cells = [name, run["date"], *counts, len(run["survivors"])]
        text += "| " + " | ".join(map(str, cells)) + " |\n"
    survivors = [line for name in PARTS for line in runs.get(name, {}).get("survivors", [])]
    if survivors:
        text += "\n## Survivors\n\n| file | mutation | code |\n|---|---|---|\n"
        for file, what, where in survivors:
            text += f"| `{file}` | {what.replace('|', chr(92) + '|')} | {code(where)} |\n"
    return text


def main():
    reasons = equivalents()
    runs = json.loads(RUNS.read_text(encoding="utf-8")) if RUNS.is_file() else {}
    now = {name: read(name, reasons) for name in sys.argv[1:]}
    runs |= now
    RUNS.write_text(json.dumps(runs, indent=1, sort_keys=True) + "\n", encoding="utf-8")
    PAGE.write_text(page(runs), encoding="utf-8")
    print(page(runs))
    alive = [line for run in now.values() for line in run["survivors"]]
    for line in alive:
        print("survives: " + " | ".join(line))
    return 1 if alive else 0


if __name__ == "__main__":
    sys.exit(main())
