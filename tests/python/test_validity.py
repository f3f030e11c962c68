"""Points of foreign FMUs that say, in the log category `validity`, that they go beyond what their model is valid for."""

import csv
import json
import re
import subprocess
import zipfile

import pytest
from conftest import ROOT
from test_acceptance import PROGRAM, orchestrator
from test_summary_schema import check

DESCRIPTION = """<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="3.0" modelName="three" instantiationToken="three">
  <CoSimulation modelIdentifier="three" canHandleVariableCommunicationStepSize="true"/>
  <LogCategories><Category name="validity"/></LogCategories>
  <DefaultExperiment startTime="0" stopTime="1" stepSize="0.1"/>
  <ModelVariables>
    <Float64 name="time" valueReference="0" causality="independent" variability="continuous"/>
    <Float64 name="x" valueReference="1" causality="parameter" variability="tunable" start="1"/>
    <Float64 name="y" valueReference="2" causality="output"/>
  </ModelVariables>
  <ModelStructure><Output valueReference="2"/><InitialUnknown valueReference="2"/></ModelStructure>
</fmiModelDescription>
"""
STUDY = """
fmu = "three.fmu"
[design]
method = "monte-carlo"
points = 200
seed = 1
[parameters.x]
distribution = "uniform"
min = 0
max = 1.25
[criteria.y]
variable = "y"
nominal = 0.6
tolerance = {tolerance}
"""
IDENTIFY = """
fmu = "three.fmu"
[identify]
starts = 2
[identify.free.x]
min = 0
max = 2
[identify.measured.y]
variable = "y"
value = 1.2
accuracy = "1 %"
"""


@pytest.fixture
def study(tmp_path):
    binary = tmp_path / "three.so"
    source = ROOT / "tests" / "validity" / "three.c"
    subprocess.run(["cc", "-O1", "-fPIC", "-shared", source, "-o", binary], check=True)
    with zipfile.ZipFile(tmp_path / "three.fmu", "w") as archive:
        archive.writestr("modelDescription.xml", DESCRIPTION)
        archive.write(binary, "binaries/x86_64-linux/three.so")
    (tmp_path / "study.toml").write_text(STUDY.format(tolerance=0.5))
    return tmp_path / "study.toml"


def rows(folder, name):
    with (folder / name).open() as file:
        return list(csv.DictReader(file))


def beyond(folder):
    """The points whose y exceeds 1, and those of them that meet all criteria."""
    points = [row for row in rows(folder, "points.csv") if float(row["x"]) > 1]
    return {row["point"] for row in points}, sum(row["verified"] == "true" for row in points)


def test_points_beyond_the_model_are_counted_and_told(study):
    out = study.parent / "out"
    said = " ".join(orchestrator("verify", study, "--output", out, "--verbose").split())
    summary = check(out)
    points, verified = beyond(out)
    assert len(points) > 20 and verified > 5
    validity = summary["validity"]
    assert (validity["points"], validity["verified"]) == (len(points), verified)
    (limit,) = validity["limits"]
    assert (limit["points"], limit["verified"]) == (len(points), verified)
    assert limit["first"]["point"] == min(int(point) for point in points)
    assert "is beyond 1" in limit["first"]["message"]
    assert summary["warnings"]["points"] == 0
    (concern,) = [concern for concern in summary["concerns"] if concern["code"] == "beyond-validity"]
    text = concern["text"]
    assert f"{len(points)} of 200 points, {verified} of the {summary['verified']} that meet all criteria, went" in text
    assert "is beyond 1" in text and re.search(r"They lie mostly where x is above (1|0\.9\d+) \(so are 100 % of these", text)
    assert text in said
    words = f"Of the {summary['verified']} points that meet all criteria {verified} went beyond"
    assert words in said and words in (out / "report.html").read_text()


def test_the_counts_are_those_of_any_processes_and_shards(study):
    folder = study.parent
    orchestrator("verify", study, "--output", folder / "whole")
    # In a process that other points have used, the FMU was reset, and listens no more by itself.
    for name, options in {"used": ["--isolation", "shared"], "here": ["--isolation", "none"]}.items():
        orchestrator("verify", study, "--output", folder / name, *options)
    parts = []
    for part in ("1/2", "2/2"):
        parts.append(folder / f"part-{part[0]}")
        orchestrator("verify", study, "--shard", part, "--output", parts[-1])
    orchestrator("merge", *parts, "--output", folder / "merged")
    for name in ("used", "here", "merged"):
        assert (folder / name / "points.csv").read_bytes() == (folder / "whole" / "points.csv").read_bytes()
        summaries = [json.loads((folder / of / "summary.json").read_text()) for of in (name, "whole")]
        assert summaries[0]["validity"] == summaries[1]["validity"]


def test_nothing_is_left_where_no_point_goes_beyond(study):
    out = study.parent / "out"
    orchestrator("verify", study, "--output", out)
    study.write_text(study.read_text().replace("max = 1.25", "max = 0.9"))
    said = orchestrator("verify", study, "--output", out, "--force")
    summary = check(out)
    assert summary["validity"] == {"points": 0, "verified": 0, "limits": []}
    assert "beyond" not in said and "beyond" not in json.dumps(summary["concerns"])


def test_simulate_and_identify_tell_it(study):
    folder = study.parent
    command = [PROGRAM, "simulate", "three.fmu", "--set", "x=1.25"]
    run = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=True)
    assert run.stderr.count("beyond what the model is valid for") == 1
    assert "at 0.9 s: y = 1.125 is beyond 1" in run.stderr
    study.write_text(IDENTIFY)
    said = orchestrator("identify", study, "--output", folder / "found")
    told = json.loads((folder / "found" / "identification.json").read_text())["beyond_validity"]
    assert "went beyond what the model says it is valid for: at " in told and f"warning: {told}" in said
