#!/usr/bin/env python3
"""What importers do against FMI 2.0 with legal FMUs of ours: strict.c, which writes down each offence. With `--write` into
docs/evidence/importer-errors.csv. Exit code 1 when the orchestrator offends."""

import csv
import os
import subprocess
import sys
import tempfile
import zipfile
from argparse import Namespace
from pathlib import Path

HERE = Path(__file__).resolve().parent
ROOT = HERE.parents[1]
sys.path.insert(0, str(ROOT / "python"))
from fmu_orchestrator.importers import _tools  # noqa: E402
from fmu_orchestrator.importers.__main__ import asked, references, scenario  # noqa: E402

TABLE, ENVIRONMENTS = ROOT / "docs/evidence/importer-errors.csv", ROOT / ".cache/importers"
# Offences: in words, and the sentence of FMI 2.0.
RULES = {
    "fixed": ("sets a fixed parameter after the initialisation", "2.2.7: The value of the variable is fixed after initialization"),
    "type": ("sets an Integer by fmi2SetReal", "2.1.2: Handle and base type uniquely identify the value of a variable"),
    "end": ("calls fmi2DoStep after the FMU has ended the simulation",
            "4.2.3: fmi2Terminated returns fmi2True, if the slave wants to terminate the simulation"),
    "callbacks": ("changes the callback functions", "2.1.5: It is not allowed to change these functions between fmi2Instantiate and "
                  "fmi2Terminate calls"),
    "warning": ("takes fmi2Warning for an error", "2.1.3: things are not quite right, but the computation can continue"),
    "memory": ("crashes: allocateMemory returns another address", "2.1.5: allocateMemory returns a pointer to space for a vector "
               "of nobj objects, each of size \"size\" or NULL"),
}
# Variants: the compiler's options, start values, and what a refusal offends against.
VARIANTS = {
    "plain": ([], [], ""),
    "a start value": ([], ["rate=2"], ""),
    "warnings": (["-DWARNS"], [], "warning"),
    "an end": (["-DENDS"], [], ""),
    "the functions of Model Exchange": (["-DEXCHANGE"], [], "memory"),
}
DESCRIPTION = """<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="2.0" modelName="strict" guid="strict">
  <CoSimulation modelIdentifier="strict" canHandleVariableCommunicationStepSize="true" canBeInstantiatedOnlyOncePerProcess="true"/>
  <LogCategories><Category name="status"/></LogCategories>
  <DefaultExperiment startTime="0" stopTime="1" stepSize="0.05"/>
  <ModelVariables>
    <ScalarVariable name="rate" valueReference="0" causality="parameter" variability="fixed"><Real start="1"/></ScalarVariable>
    <ScalarVariable name="count" valueReference="1" causality="parameter" variability="fixed"><Integer start="0"/></ScalarVariable>
    <ScalarVariable name="y" valueReference="2" causality="output"><Real/></ScalarVariable>
    <ScalarVariable name="level" valueReference="3" causality="input"><Real start="0"/></ScalarVariable>
  </ModelVariables>
  <ModelStructure><Outputs><Unknown index="3"/></Outputs><InitialUnknowns><Unknown index="3"/></InitialUnknowns></ModelStructure>
</fmiModelDescription>
"""


def built(folder, flags):
    """The FMU of a variant."""
    library, fmu = folder / "strict.so", folder / "strict.fmu"
    subprocess.run(["cc", "-O1", "-fPIC", "-shared", *flags, HERE / "strict.c", "-o", library, "-lm"], check=True)
    with zipfile.ZipFile(fmu, "w") as archive:
        archive.writestr("modelDescription.xml", DESCRIPTION)
        archive.write(library, "binaries/linux64/strict.so")
    return fmu


def offences(folder, flags, start, rule):
    """The offences by tool: its version and the rules."""
    options = Namespace(stop=None, step=None, set=start, record=None, tolerance=None, since=0.0, environments=ENVIRONMENTS)
    wanted = scenario(built(folder, flags), options)
    expected, log = references(wanted, ENVIRONMENTS), folder / "offences"
    os.environ["STRICT_LOG"] = str(log)
    for tool in _tools.TOOLS:
        log.unlink(missing_ok=True)
        row = asked(tool, wanted, expected, options)
        told = set(log.read_text().split("\n")) if log.exists() else set()
        refused = {rule} if rule and row.verdict == "refused" else set()
        yield row, sorted((told & set(RULES)) | refused)


def version(name):
    """What is installed of a tool."""
    tool = next(tool for tool in _tools.TOOLS if tool.name == name)
    if not tool.packages:
        return tool.source or _tools.crate_version(tool)
    asks = f"import importlib.metadata; print(importlib.metadata.version({tool.packages[0]!r}))"
    return _tools.run([_tools.python_of(tool, ENVIRONMENTS), "-c", asks]).strip()


def main():
    found = {}
    for variant, (flags, start, rule) in VARIANTS.items():
        with tempfile.TemporaryDirectory() as folder:
            for row, told in offences(Path(folder), flags, start, rule):
                print(f"{variant}: {row.tool}: {row.cell}" + "".join(f"; it {RULES[name][0]}" for name in told), flush=True)
                for name in told:
                    found.setdefault((row.tool, name), variant)
    if "--write" in sys.argv:
        with TABLE.open("w", newline="") as out:
            writer = csv.writer(out, lineterminator="\n")
            writer.writerow(["importer", "version", "strict.c with", "what it does", "FMI 2.0"])
            writer.writerows([tool, version(tool), variant, *RULES[name]] for (tool, name), variant in sorted(found.items()))
    return any(tool == _tools.OWN.name for tool, _ in found)


if __name__ == "__main__":
    sys.exit(main())
