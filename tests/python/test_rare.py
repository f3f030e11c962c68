"""Rare shares (`verify --rare`) against a closed form and OpenTURNS' subset simulation, on a model in C."""

import csv
import json
import subprocess
import zipfile

import numpy as np
import openturns as ot
import pytest
from scipy import integrate, special
from test_acceptance import PROGRAM, ROOT

SOURCE = ROOT / "orchestrator" / "tests" / "fixtures" / "functions.c"
NOMINAL, TOLERANCE = 16, 1
DESCRIPTION = """<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="2.0" modelName="Functions" guid="functions"><CoSimulation modelIdentifier="functions"/>
<DefaultExperiment startTime="0" stopTime="1" stepSize="1"/><ModelVariables>
<ScalarVariable name="x1" valueReference="1" causality="parameter" variability="fixed"><Real start="0.5"/></ScalarVariable>
<ScalarVariable name="x2" valueReference="2" causality="parameter" variability="fixed"><Real start="0.5"/></ScalarVariable>
<ScalarVariable name="product" valueReference="105" causality="output"><Real/></ScalarVariable>
</ModelVariables><ModelStructure><Outputs><Unknown index="3"/></Outputs></ModelStructure></fmiModelDescription>"""
STUDY = f"""fmu = "functions.fmu"
[parameters.x1]
distribution = "normal"
mean = 0
deviation = 1
[parameters.x2]
distribution = "normal"
mean = 0
deviation = 1
[criteria.P]
variable = "product"
nominal = {NOMINAL}
tolerance = {TOLERANCE}
"""


@pytest.fixture(scope="module")
def found(tmp_path_factory):
    folder = tmp_path_factory.mktemp("rare")
    binary = folder / "functions.so"
    subprocess.run(["cc", "-shared", "-fPIC", "-O2", "-o", binary, SOURCE, "-lm"], check=True)
    with zipfile.ZipFile(folder / "functions.fmu", "w") as fmu:
        fmu.writestr("modelDescription.xml", DESCRIPTION)
        fmu.write(binary, "binaries/linux64/functions.so")
    (folder / "study.toml").write_text(STUDY)
    call = [PROGRAM, "verify", "study.toml", "--rare", "--points", "100000", "--output", "out"]
    subprocess.run(call, cwd=folder, check=True, capture_output=True)
    with (folder / "out" / "rare.csv").open() as file:
        rows = list(csv.DictReader(file))
    return json.loads((folder / "out" / "rare.json").read_text()), rows


def exact():
    """The product of two standard normal numbers has the density K0(|z|) / pi."""
    low, high = NOMINAL - TOLERANCE, NOMINAL + TOLERANCE
    return integrate.quad(lambda z: special.k0(z) / np.pi, low, high, epsrel=1e-10, epsabs=0)[0]


def test_the_share_is_the_closed_form(found):
    result, _ = found
    # Four standard errors.
    assert result["relative_error"] < 0.06
    assert abs(np.log(result["share"] / exact())) < 4 * result["relative_error"]


def test_both_regions_are_found_and_are_equal(found):
    result, rows = found
    assert len(result["regions"]) == 2
    weights = np.array([float(row["weight"]) for row in rows])
    positive = np.array([float(row["x1"]) > 0 for row in rows])
    assert abs(weights[positive].sum() / weights.sum() - 0.5) < 0.1
    products = np.array([float(row["x1"]) * float(row["x2"]) for row in rows])
    assert np.all(np.abs(products - NOMINAL) <= TOLERANCE)


def test_openturns_agrees(found):
    result, _ = found
    ot.RandomGenerator.SetSeed(1)
    inputs = ot.RandomVector(ot.Normal(2))
    function = ot.SymbolicFunction(["a", "b"], [f"abs(a * b - {NOMINAL}) / {TOLERANCE} - 1"])
    event = ot.ThresholdEvent(ot.CompositeRandomVector(function, inputs), ot.Less(), 0)
    search = ot.SubsetSampling(event)
    search.setMaximumOuterSampling(20000)
    search.setBlockSize(1)
    search.run()
    theirs = search.getResult()
    error = theirs.getCoefficientOfVariation()
    assert error < 0.5
    assert abs(np.log(result["share"] / theirs.getProbabilityEstimate())) < 4 * error
