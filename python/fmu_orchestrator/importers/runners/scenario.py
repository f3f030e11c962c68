"""The run that every importer does, as the caller wrote it down: `RUNNER.py SCENARIO.json ANSWER.json`."""

import importlib.metadata
import json
import sys
from pathlib import Path

_given = json.loads(Path(sys.argv[1]).read_text(encoding="utf-8"))
FMU: str = _given["fmu"]
VERSION, KIND, IDENTIFIER, GUID = (_given[key] for key in ("version", "kind", "identifier", "guid"))
STEP, STEPS, STOP, TOLERANCE, SUGGESTED = (_given[key] for key in ("step", "steps", "stop", "tolerance", "suggested"))
START, OUTPUTS, REFERENCES = _given["start"], _given["outputs"], _given["references"]
PROGRAM = _given["program"]  # the library of importers that are in no registry


def report(package, samples=(), note="", findings=()):
    """Hands back the samples, a list of output values a communication point; of a checker, its findings.

    A tool that tells nothing of the start gives one sample fewer. Several runs go by their names.
    """
    version = importlib.metadata.version(package) if package else ""
    runs = samples if isinstance(samples, dict) else {"": samples}
    exact = {name: [[float(value).hex() for value in sample] for sample in run] for name, run in runs.items()}
    answer = {"version": version, "note": note, "runs": exact, "findings": [str(finding) for finding in findings]}
    Path(sys.argv[2]).write_text(json.dumps(answer), encoding="utf-8")
