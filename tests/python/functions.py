"""The analytic functions of orchestrator/tests/fixtures/functions.c as an FMU."""

import subprocess
import zipfile

from python_package import ROOT

SOURCE = ROOT / "orchestrator" / "tests" / "fixtures" / "functions.c"
REFERENCES = {"wave": 101, "product": 105, "linear": 108, "sum": 111}


def variables(parameters, outputs):
    """The parameters x1, x2 and so on, then outputs by their names in the source."""
    for k in range(1, parameters + 1):
        yield (f'<ScalarVariable name="x{k}" valueReference="{k}" causality="parameter" variability="fixed">'
               '<Real start="0.5"/></ScalarVariable>')
    for name in outputs:
        yield f'<ScalarVariable name="{name}" valueReference="{REFERENCES[name]}" causality="output"><Real/></ScalarVariable>'


def pack(folder, parameters, *outputs):
    """Builds functions.fmu in a folder."""
    binary = folder / "functions.so"
    subprocess.run(["cc", "-shared", "-fPIC", "-O2", "-o", binary, SOURCE, "-lm"], check=True)
    unknowns = "".join(f'<Unknown index="{parameters + k}"/>' for k in range(1, len(outputs) + 1))
    description = f"""<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="2.0" modelName="Functions" guid="functions"><CoSimulation modelIdentifier="functions"/>
<DefaultExperiment startTime="0" stopTime="1" stepSize="1"/><ModelVariables>{"".join(variables(parameters, outputs))}
</ModelVariables><ModelStructure><Outputs>{unknowns}</Outputs></ModelStructure></fmiModelDescription>"""
    with zipfile.ZipFile(folder / "functions.fmu", "w") as fmu:
        fmu.writestr("modelDescription.xml", description)
        fmu.write(binary, "binaries/linux64/functions.so")
