"""Tests of the FMU's files other than the binary and the model description."""

import subprocess
import sys
import zipfile
from pathlib import Path

import fmpy
import pytest
from lxml import etree

SCHEMAS = Path(fmpy.__file__).parent
FOLDER = "extra/org.fmi-standard.fmi-ls-ref/"
NAMESPACE = {"ssv": "http://ssp-standard.org/SSP1/SystemStructureParameterValues"}


@pytest.fixture(scope="module")
def archive(fmu):
    with zipfile.ZipFile(fmu) as archive:
        yield archive


def valid(text, schema):
    document = etree.fromstring(text)
    etree.XMLSchema(etree.parse(str(SCHEMAS / schema))).assertValid(document)
    return document


def test_terminals_are_made_of_the_models_variables(archive, fmu, description):
    known = {variable.name: variable for variable in description.modelVariables}
    with zipfile.ZipFile(fmu.with_name("PlainBearingStand-fmi3.fmu")) as three:
        document = valid(three.read("terminalsAndIcons/terminalsAndIcons.xml"), "schema/fmi3/fmi3TerminalsAndIcons.xsd")
        assert three.read("terminalsAndIcons/icon.png") == archive.read("model.png")
    members = [node.get("variableName") for node in document.iter("TerminalMemberVariable")]
    assert len(members) == len(set(members)) > 0 and set(members) <= set(known)
    inputs = {name for name, variable in known.items() if variable.causality == "input"}
    assert inputs <= set(members)


@pytest.mark.parametrize("suffix", ["", "-me", "-fmi3", "-me-fmi3"])
def test_terminals_name_the_version_of_the_model_description(fmu, suffix):
    """FMI Library 3 reports a fatal error where they differ."""
    with zipfile.ZipFile(fmu.with_name(f"PlainBearingStand{suffix}.fmu")) as archive:
        files = ["modelDescription.xml", *(name for name in archive.namelist() if name.endswith("/terminalsAndIcons.xml"))]
        versions = {etree.fromstring(archive.read(name)).get("fmiVersion") for name in files}
        assert len(versions) == 1 and len(files) == (2 if "fmi3" in suffix else 1)


def test_the_manifest_keeps_to_its_schema(archive):
    """The schema of FMI-LS-REF, 1.0.0-alpha.1 and 1.0.0-beta.1, in its own words."""
    manifest = etree.fromstring(archive.read(FOLDER + "fmi-ls-manifest.xml"))
    space = "{http://fmi-standard.org/fmi-ls-manifest}fmi-ls-"
    assert manifest.tag == "fmiReferences" and dict(manifest.attrib) == {
        space + "name": "org.fmi-standard.fmi-ls-ref", space + "version": "1.0.0-alpha.1",
        space + "description": "Layered Standard providing information on related files included in an FMU."}
    for related in manifest:
        assert related.tag == "Related" and len(related) == 0
        assert {"source", "role"} <= set(related.keys()) <= {"type", "source", "role", "description"}


def sets(archive):
    manifest = etree.fromstring(archive.read(FOLDER + "fmi-ls-manifest.xml"))
    for related in manifest.iter("Related"):
        content = archive.read(FOLDER + related.get("source"))
        assert related.get("role") == "parameter"
        yield related.get("source").removesuffix(".ssv"), content


def values_of(content):
    document = valid(content, "ssp/schema/SystemStructureParameterValues.xsd")
    return {node.get("name"): node[0].get("value") for node in document.iterfind(".//ssv:Parameter", NAMESPACE)}


def test_parameter_sets_are_complete_and_in_their_ranges(archive, description):
    known = {v.name: v for v in description.modelVariables if v.causality == "parameter"}
    found = dict(sets(archive))
    assert set(found) == {"rig", "paper-table3"}
    for content in found.values():
        values = values_of(content)
        assert set(values) == set(known)
        for name, variable in known.items():
            if variable.type == "Real":
                assert float(variable.min) <= float(values[name]) <= float(variable.max), name


def test_the_rigs_set_is_the_start_values(archive, description):
    values = values_of(dict(sets(archive))["rig"])
    for variable in description.modelVariables:
        if variable.causality == "parameter" and variable.type == "Real":
            assert float(values[variable.name]) == pytest.approx(float(variable.start), rel=1e-9), variable.name


def test_a_set_is_taken_by_an_importer(archive, fmu):
    """Calibration A has no asperity contact, and an oil that is thick enough without it."""
    values = values_of(dict(sets(archive))["paper-table3"])
    result = fmpy.simulate_fmu(str(fmu), stop_time=0.2, start_values=values,
                               output=["bearing.contactShare", "bearing.filmViscosity"])
    assert result["bearing.contactShare"][-1] == 0.0
    assert result["bearing.filmViscosity"][-1] > 0.1
    assert float(values["thermal.initialBearingTemperature"]) == pytest.approx(355.15)
    assert float(values["thermal.initialFilmRise"]) == -12.76


@pytest.mark.parametrize("content, says", [
    ("the library", "the file is for linux64"),
    ("a text", "the file is no 64-bit shared library"),
    ("", "the file is no 64-bit shared library"),
])
def test_a_binary_of_another_platform_is_not_packed(archive, tmp_path, content, says):
    file = tmp_path / "binary"
    library = archive.read("binaries/linux64/PlainBearingStand.so")
    file.write_bytes(library if content == "the library" else content.encode())
    script = Path(__file__).parents[2] / "scripts/package-fmu"
    for platform in ("win64", "darwin64", "aarch64-linux"):
        done = subprocess.run([sys.executable, script, "--add", f"{platform}={file}"], text=True, capture_output=True)
        assert done.returncode == 2 and says in done.stderr, done.stderr


def test_a_folder_is_no_output(tmp_path):
    script = Path(__file__).parents[2] / "scripts/package-fmu"
    done = subprocess.run([sys.executable, script, "--output", tmp_path], text=True, capture_output=True)
    assert done.returncode == 2 and "a folder; give the file" in done.stderr
