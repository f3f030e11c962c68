"""The gate for build servers: the commands of docs/ci.md and the steps of the action, in a project with a model."""

import os
import re
import shutil
import subprocess
import xml.etree.ElementTree as ET

import pytest
import yaml
from test_acceptance import PROGRAM, ROOT

STUDY = """
fmu = "model.fmu"
[simulation]
stop = 1
step = 0.1
[design]
points = 12
seed = 1
[fixed]
"thermal.isothermal" = true
[parameters."load.preload"]
distribution = "normal"
mean = 48
deviation = 0.5
unit = "N"
[criteria.load]
variable = "sensor.loadForceMean"
nominal = 750
tolerance = "10 %"
unit = "N"
"""
KNOWN = ROOT / "docs/ci.md"


def blocks(kind):
    return re.findall(rf"^```{kind}\n([\s\S]*?)^```", KNOWN.read_text(encoding="utf-8"), re.MULTILINE)


def commands():
    return [line for block in blocks("sh") for line in block.splitlines()]


@pytest.fixture
def project(fmu, tmp_path):
    shutil.copy(fmu, tmp_path / "model.fmu")
    (tmp_path / "study.toml").write_text(STUDY)
    (tmp_path / "known.toml").write_text("")
    (tmp_path / "verified").mkdir()
    return tmp_path


def run(lines, folder, **environment):
    return subprocess.run(["bash", "-e", "-c", "\n".join(lines)], cwd=folder, text=True, capture_output=True,
                          env={**os.environ, "PATH": f"{PROGRAM.parent}:{os.environ['PATH']}", **environment})


def counts(file):
    """The attributes of a suite that any reader of JUnit XML needs, which must be those of its tests."""
    suite = ET.parse(file).getroot().find("testsuite")
    cases = suite.findall("testcase")
    assert len(cases) == int(suite.get("tests")) > 0
    assert all(case.get("classname") and case.get("name") and case.get("time") for case in cases)
    for name, element in (("failures", "failure"), ("errors", "error"), ("skipped", "skipped")):
        found = [case for case in cases if case.find(element) is not None]
        assert int(suite.get(name)) == len(found)
        assert all(case.find(element).get("message") for case in found)
    return int(suite.get("tests")), int(suite.get("failures")) + int(suite.get("errors"))


def test_the_commands_of_the_page_work(project):
    check, verify, compare, keep = commands()
    done = run([check, verify, keep, compare], project)
    assert done.returncode == 0, done.stdout + done.stderr
    for name in ("check", "verify", "compare"):
        assert counts(project / f"results/{name}.xml")[1] == 0
    assert (project / "results/compare.html").is_file()
    # A model that changed: a study of another tolerance of time would do; here the load.
    study = (project / "study.toml").read_text().replace("[fixed]", "[fixed]\n\"load.stiffness\" = 105")
    (project / "study.toml").write_text(study)
    done = run([verify.replace("--strict", "--strict --force")], project)
    assert done.returncode == 0, done.stdout + done.stderr
    done = run([compare], project)
    assert done.returncode == 1 and "load changed at 12 points" in done.stdout, done.stdout + done.stderr
    assert counts(project / "results/compare.xml")[1] == 1


def test_a_known_finding_is_written_as_the_page_shows_it(project):
    [known] = blocks("toml")
    (project / "known.toml").write_text(known)
    done = run(commands()[:1], project)
    assert done.returncode == 0 and "unit-defined of bearing.width is left to ignore" in done.stderr, done.stdout + done.stderr


def test_gitlab_runs_the_same_commands():
    [job] = [yaml.safe_load(block)["fmu"] for block in blocks("yaml") if block.startswith("fmu:")]
    assert job["script"][1:] == commands()[:3]
    assert job["artifacts"]["when"] == "always" and job["artifacts"]["reports"]["junit"] == "results/*.xml"


def test_the_page_is_short():
    assert len(KNOWN.read_text(encoding="utf-8").split()) <= 400


def steps():
    action = yaml.safe_load((ROOT / "action.yml").read_text(encoding="utf-8"))
    return action["inputs"], action["runs"]["steps"]


def test_the_steps_of_the_action_work(project):
    """As the runner does: the inputs' values in the environment that a step names."""
    inputs, all_steps = steps()
    values = {name: about.get("default") for name, about in inputs.items()}
    values |= {"fmu": "model.fmu", "study": "study.toml", "baseline": "verified", "ignore": "known.toml"}
    install, *rest, pages = all_steps
    assert "pip" in install["run"] and pages["uses"].startswith("actions/upload-artifact@")

    def environment(step):
        filled = {name: re.sub(r"\$\{\{ inputs\.([\w-]+) \}\}", lambda m: values[m[1]], text)
                  for name, text in step["env"].items()}
        assert not any("${{" in text for text in filled.values()), filled
        return filled

    check, verify, compare = rest
    for step in (check, verify):
        done = run([step["run"]], project, **environment(step))
        assert done.returncode == 0, done.stdout + done.stderr
    for file in ("points.csv", "summary.json"):
        shutil.copy(project / values["output"] / file, project / "verified")
    done = run([compare["run"]], project, **environment(compare))
    assert done.returncode == 0 and done.stdout.startswith("No difference"), done.stdout + done.stderr
    for step in rest:
        # Inputs reach the shell as values, never as its text.
        assert step["shell"] == "bash" and "${{" not in step["run"]


def test_the_actions_parts_are_pinned():
    for step in steps()[1]:
        assert "run" in step or re.fullmatch(r"[\w/-]+@[0-9a-f]{40}", step["uses"]), step
