#!/usr/bin/env python3
"""Which legal FMUs of FMI 2.0 the crate `fmi` refuses that the orchestrator reads: the stand's own FMU, with one legal piece of XML added
each time, as other tools write it. docs/ARCHITECTURE.md rests on it. Exit code 1 when the orchestrator refuses one."""

import sys
import tempfile
import zipfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "python"))
from fmu_orchestrator._files import program  # noqa: E402
from fmu_orchestrator.importers._tools import TOOLS, Trouble, install, run  # noqa: E402

FMU, CACHE = ROOT / "dist/PlainBearingStand.fmu", ROOT / ".cache/importers"

# What is added: to which text, once.
PIECES = {
    "nothing": ("", ""),
    "xmlns:xsi on the root, as Dymola writes it":
        ("<fmiModelDescription", ' xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance"'),
    "canHandleMultipleSetPerTimeInstant of a variable":
        ("<ScalarVariable", ' canHandleMultipleSetPerTimeInstant="true"'),
    "Annotations in a variable":
        ("</ScalarVariable>", ""),
}
ANNOTATIONS = '<Annotations><Tool name="tool"/></Annotations></ScalarVariable>'


def changed(description, after, piece):
    if after == "</ScalarVariable>":
        return description.replace(after, ANNOTATIONS, 1)
    return description.replace(after, after + piece, 1) if after else description


def variant(folder, number, after, piece):
    """The stand's FMU with another description."""
    path = Path(folder) / f"variant{number}.fmu"
    with zipfile.ZipFile(FMU) as whole, zipfile.ZipFile(path, "w") as out:
        for name in whole.namelist():
            content = whole.read(name)
            if name == "modelDescription.xml":
                content = changed(content.decode(), after, piece).encode()
            out.writestr(name, content)
    return path


def answer(command):
    try:
        run(command)
        return "reads it"
    except Trouble as trouble:
        return f"refuses it: {trouble}"


def main():
    install(next(tool for tool in TOOLS if tool.crate == "fmi"), CACHE)
    importer = CACHE / "rust/debug/use-fmi"
    good = True
    with tempfile.TemporaryDirectory() as folder:
        for number, (added, (after, piece)) in enumerate(PIECES.items()):
            fmu = variant(folder, number, after, piece)
            theirs = answer([importer, fmu, "0.01", "1", "drive.speed=30", "sensor.loadForce"])
            ours = answer([program(), "inspect", fmu])
            good &= ours == "reads it"
            print(f"{added}\n  fmi: {theirs}\n  orchestrator: {ours}")
    return 0 if good else 1


if __name__ == "__main__":
    sys.exit(main())
