"""A system of FMUs becomes one, which gives what a master gives that steps them one by one."""

import json
import subprocess
import sys
import zipfile

import fmpy
import numpy as np
import pytest
from conftest import FMU2Stand
from python_package import ENVIRONMENT, command

from fmu_orchestrator import inspect

STEP, STOP = 1e-3, 0.1
# Two stands, the second in a system of its own: a wider bush, the first one's load as an external force.
SYSTEM = """<?xml version="1.0"?>
<a:SystemStructureDescription name="rig" version="1.0" xmlns:a="http://ssp-standard.org/SSP1/SystemStructureDescription"
 xmlns:c="http://ssp-standard.org/SSP1/SystemStructureCommon" xmlns:v="http://ssp-standard.org/SSP1/SystemStructureParameterValues">
<a:System name="rig">
 <a:Connectors><a:Connector name="speed" kind="input"><c:Real unit="rad/s"/></a:Connector>
  <a:Connector name="torque" kind="output"><c:Real unit="N.m"/></a:Connector></a:Connectors>
 <a:ParameterBindings><a:ParameterBinding source="resources/rig.ssv"/>
  <a:ParameterBinding source="resources/width.ssv"><a:ParameterMapping><m:ParameterMapping version="1.0"
   xmlns:m="http://ssp-standard.org/SSP1/SystemStructureParameterMapping"><m:MappingEntry source="B" target="outer.second.bearing.width">
   <c:LinearTransformation factor="0.001"/></m:MappingEntry></m:ParameterMapping></a:ParameterMapping></a:ParameterBinding></a:ParameterBindings>
 <a:Elements>
  <a:Component name="first" source="resources/stand.fmu"><a:Connectors>
   <a:Connector name="drive.speed" kind="input"/><a:Connector name="sensor.loadForce" kind="output"><c:Real unit="N"/></a:Connector>
  </a:Connectors></a:Component>
  <a:System name="outer">
   <a:Connectors><a:Connector name="force" kind="input"/><a:Connector name="M" kind="output"/></a:Connectors>
   <a:Elements><a:Component name="second" source="resources/stand.fmu"><a:ParameterBindings><a:ParameterBinding><a:ParameterValues>
    <v:ParameterSet version="1.0" name="s"><v:Parameters><v:Parameter name="bearing.film"><v:Enumeration value="Mobility"/></v:Parameter>
     <v:Parameter name="load.preload"><v:Real value="7"/></v:Parameter><v:Parameter name="load.eccentricity"><v:Real value="0"/></v:Parameter>
    </v:Parameters></v:ParameterSet></a:ParameterValues></a:ParameterBinding></a:ParameterBindings></a:Component></a:Elements>
   <a:Connections><a:Connection startConnector="force" endElement="second" endConnector="load.externalForce"/>
    <a:Connection startElement="second" startConnector="sensor.frictionTorque" endConnector="M"/></a:Connections>
  </a:System>
 </a:Elements>
 <a:Connections><a:Connection startConnector="speed" endElement="first" endConnector="drive.speed"/>
  <a:Connection startElement="first" startConnector="sensor.loadForce" endElement="outer" endConnector="force"/>
  <a:Connection startElement="outer" startConnector="M" endConnector="torque"/></a:Connections>
</a:System>
<a:DefaultExperiment startTime="0" stopTime="2"/>
</a:SystemStructureDescription>"""
SET = """<v:ParameterSet version="2.0" name="rig" xmlns:v="http://ssp-standard.org/SSP1/SystemStructureParameterValues"
 xmlns:c="http://ssp-standard.org/SSP1/SystemStructureCommon"><v:Parameters>
 <v:Parameter name="speed"><v:Real value="300" unit="rpm"/></v:Parameter>
 <v:Parameter name="outer.second.load.preload"><v:Real value="0"/></v:Parameter>
 <v:Parameter name="outer.second.load.springOffset"><v:Real value="0"/></v:Parameter>
 <v:Parameter name="first.bearing.radialClearance"><v:Real value="22" unit="um"/></v:Parameter></v:Parameters>
 <v:Units><c:Unit name="rpm"><c:BaseUnit s="-1" rad="1" factor="0.10471975511965977"/></c:Unit>
 <c:Unit name="um"><c:BaseUnit m="1" factor="1e-6"/></c:Unit></v:Units></v:ParameterSet>"""
WIDTH = """<v:ParameterSet version="1.0" name="w" xmlns:v="http://ssp-standard.org/SSP1/SystemStructureParameterValues"><v:Parameters>
 <v:Parameter name="B"><v:Real value="25"/></v:Parameter></v:Parameters></v:ParameterSet>"""


def pack(path, stand, system=SYSTEM):
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("SystemStructure.ssd", system)
        archive.writestr("resources/rig.ssv", SET)
        archive.writestr("resources/width.ssv", WIDTH)
        archive.write(stand, "resources/stand.fmu")
    return path


def make(ssp, output, *options):
    command = [sys.executable, "-m", "fmu_orchestrator", "system", ssp, "--step", str(STEP), "--output", output, *options]
    return subprocess.run(command, capture_output=True, text=True, env=ENVIRONMENT)


@pytest.fixture(scope="module")
def made(fmu, tmp_path_factory):
    folder = tmp_path_factory.mktemp("system")
    done = make(pack(folder / "rig.ssp", fmu), folder / "rig.fmu")
    assert (done.returncode, done.stderr) == (0, ""), done.stderr
    return folder / "rig.fmu"


def coupled(unpacked, description, step, force=0.0):
    """The two stands, one by one: all get their inputs, then all step, then all outputs are read."""
    first, second = stands = [FMU2Stand(unpacked, description) for _ in range(2)]
    for stand in stands:
        stand.setupExperiment(startTime=0.0)
    first.set("drive.speed", 300 * 0.10471975511965977)
    first.set("bearing.radialClearance", 22 * 1e-6)
    first.set("load.externalForce", force)
    for name, value in {"load.preload": 0, "load.eccentricity": 0, "load.springOffset": 0, "bearing.width": 25 * 0.001}.items():
        second.set(name, value)
    for stand in stands:
        stand.enterInitializationMode()
    first.exitInitializationMode()
    second.set("load.externalForce", *first.get("sensor.loadForce"))
    second.exitInitializationMode()
    for k in range(round(STOP / step)):
        second.set("load.externalForce", *first.get("sensor.loadForce"))
        for stand in stands:
            stand.doStep(k * step, step)
    found = [stand.get("sensor.frictionTorque")[0] for stand in stands]
    for stand in stands:
        stand.terminate()
        stand.freeInstance()
    return found


def simulated(made, *settings):
    options = [f"--set={setting}" for setting in settings]
    done = command("simulate", made, "--stop", STOP, "--record", "first.sensor.frictionTorque,torque,outer.second.bearing.width",
                   "--output", "-", *options)
    assert done.returncode == 0, done.stderr
    return [float(cell) for cell in done.stdout.split("\n\n")[0].strip().splitlines()[-1].split(",")[1:]]


def test_it_gives_what_a_master_gives_at_each_step(made, unpacked, description):
    results = {}
    for multiplier in (4, 2, 1):
        *found, width = simulated(made, f"container.ts_multiplier={multiplier}")
        results[multiplier] = found
        assert found == coupled(unpacked, description, STEP * multiplier / 4) and width == 0.025
    assert simulated(made)[:2] == results[4]
    assert len({tuple(found) for found in results.values()}) == 3


def test_what_the_host_sets_stays(made, unpacked, description):
    assert simulated(made, "first.load.externalForce=30")[:2] == coupled(unpacked, description, STEP, force=30.0)
    slower = simulated(made, "speed=200 rpm", "first.bearing.radialClearance=0.018 mm")
    assert slower[0] != simulated(made)[0]


def test_names_units_and_descriptions_are_those_of_the_fmus(made, description):
    fmpy.read_model_description(str(made), validate=True)
    known = {variable["name"]: variable for variable in inspect(made)["variables"]}
    stand = {variable.name: variable for variable in description.modelVariables}
    for name, own in [("torque", "sensor.frictionTorque"), ("speed", "drive.speed"), ("outer.second.bearing.width", "bearing.width"),
                      ("outer.second.drive.speed", "drive.speed")]:
        assert (known[name]["unit"], known[name]["description"]) == (stand[own].unit, stand[own].description)
    assert known["speed"]["start"] == pytest.approx(31.4159265)
    assert "outer.second.load.externalForce" not in known and "first.drive.speed" not in known
    assert command("check", made).returncode == 0


def test_the_step_check_halves_the_steps_inside(made, tmp_path):
    (tmp_path / "study.toml").write_text(f"""
fmu = "{made}"
[simulation]
stop = {STOP}
[design]
method = "monte-carlo"
points = 3
[parameters."first.bearing.radialClearance"]
distribution = "uniform"
min = 20
max = 24
unit = "um"
[criteria.M]
variable = "torque"
nominal = 0.38
tolerance = "50 %"
unit = "N.m"
""")
    done = command("verify", tmp_path / "study.toml", "--output", tmp_path / "out", "--validation")
    assert done.returncode == 0, done.stderr
    of_torque = json.loads((tmp_path / "out" / "summary.json").read_text())["validation"]["M"]
    change = abs(np.subtract(simulated(made)[1], simulated(made, "container.ts_multiplier=2")[1]))
    assert change > 0 and 0.5 < of_torque["u_num"] / change < 5


@pytest.mark.parametrize(("before", "after", "words"), [
    ('name="first" source', 'name="first" type="application/x-ssp-package" source', ["first: it is no FMU (application/x-ssp-package)"]),
    ("resources/stand.fmu", "resources/none.fmu", ["first", "resources/none.fmu", "not in the archive"]),
    ('endElement="outer" endConnector="force"/>', 'endElement="outer" endConnector="force"><c:LinearTransformation factor="2"/></a:Connection>',
     ["first.sensor.loadForce -> outer.force", "it transforms values", "put an FMU"]),
    ('startConnector="sensor.loadForce"', 'startConnector="sensor.frictionTorque"',
     ["first.sensor.frictionTorque -> outer.second.load.externalForce", "N.m is not known to be N"]),
    ('endElement="first" endConnector="drive.speed"', 'endElement="first" endConnector="drive.sped"', ["first.drive.sped", "no such connector"]),
    ('<c:Real unit="N"/>', '<c:Real unit="kg"/>', ["first.sensor.loadForce", "unit kg is not the FMU's, N"]),
    ('<a:System name="outer">', '<a:SignalDictionaryReference name="bus"/><a:System name="outer">', ["bus: a SignalDictionaryReference"]),
    ("resources/rig.ssv", "resources/none.ssv", ["resources/none.ssv"]),
    ("</a:Elements>", "</a:Element>", ["SystemStructure.ssd: no XML"]),
    ('source="resources/stand.fmu"', 'source="resources/rig.ssv"', ["first: resources/rig.ssv is no FMU"]),
])
def test_what_it_cannot_honour_is_refused_in_a_line(fmu, tmp_path, before, after, words):
    assert before in SYSTEM
    system = SYSTEM.replace(before, after)
    if "unit kg" in words[-1]:
        system = system.replace("</a:System>\n<a:Def", '</a:System>\n<a:Units><c:Unit name="kg"><c:BaseUnit kg="1" factor="2"/></c:Unit></a:Units><a:Def')
    done = make(pack(tmp_path / "rig.ssp", fmu, system), tmp_path / "rig.fmu")
    last = done.stderr.strip().splitlines()[-1]
    assert done.returncode == 2 and last.startswith("error: ") and all(word in last for word in ["rig.ssp", *words]), done.stderr
    assert not (tmp_path / "rig.fmu").exists()


def test_fmus_of_fmi_3_give_the_same(fmu, made, tmp_path):
    done = make(pack(tmp_path / "rig.ssp", fmu.with_name("PlainBearingStand-fmi3.fmu")), tmp_path / "three.fmu")
    assert done.returncode == 0, done.stderr
    assert simulated(tmp_path / "three.fmu") == simulated(made)
    assert command("check", tmp_path / "three.fmu").returncode == 0


def test_a_file_that_is_there_stays(made):
    held = made.read_bytes()
    done = make(made.with_name("rig.ssp"), made)
    assert done.returncode == 2 and "--force" in done.stderr and made.read_bytes() == held
