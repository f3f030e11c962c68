"""`summary.json` keeps to its schema, and has no key that the schema does not name."""

import json
import re

import jsonschema
import pytest
from test_acceptance import ROOT, orchestrator

SCHEMA = json.loads((ROOT / "studies" / "summary.schema.json").read_text())


def strict(schema):
    """The same schema, which refuses keys that it does not name."""
    if isinstance(schema, list):
        return [strict(part) for part in schema]
    if not isinstance(schema, dict):
        return schema
    schema = {key: strict(part) for key, part in schema.items()}
    if "properties" in schema:
        schema.setdefault("additionalProperties", False)
    return schema


STRICT = strict(SCHEMA)
# A distribution's numbers are keys beside its name.
STRICT["$defs"]["parameter-summary"]["additionalProperties"] = True


def check(folder):
    jsonschema.Draft202012Validator.check_schema(SCHEMA)
    summary = json.loads((folder / "summary.json").read_text())
    jsonschema.Draft202012Validator(STRICT).validate(summary)
    return summary


def test_the_schema_has_each_code_as_the_program_describes_it():
    source = (ROOT / "crates" / "study" / "src" / "concern.rs").read_text()
    variants = source.partition("pub enum Code {")[2].partition("\n}\n")[0]
    codes = {re.sub("(?<!^)(?=[A-Z])", "-", name).lower(): text for text, name in re.findall(r"/// (.*)\n    (\w+),", variants)}
    assert len(codes) > 20 and "other" not in codes
    assert {code["const"]: code["description"] for code in SCHEMA["$defs"]["code"]["oneOf"]} == codes


@pytest.mark.parametrize("study", ["paper-table1", "paper-table3", "rig"])
def test_shipped_studies_keep_to_the_schema(study, tmp_path):
    done = tmp_path / "out"
    orchestrator("verify", f"studies/{study}.toml", "--output", done, code=1 if study == "paper-table1" else 0)
    summary = check(done)
    if study != "rig":
        assert {concern["code"] for concern in summary["concerns"]} == {"still-moves", "swings"}


def test_a_study_with_most_keys_keeps_to_the_schema(tmp_path):
    text = (ROOT / "studies" / "paper-table3.toml").read_text()
    text = text.replace('fmu = "', f'fmu = "{ROOT}/studies/')
    text += '\n[verdict]\nshare = "5 %"\nrisk = "40 %"\n[dossier]\nresponsible = "A. Tester"\ntested = 2025-05-12\n'
    text += '[[uncertainty-correlations]]\nbetween = ["T_oil", "F_N"]\ncoefficient = 0.5\n'
    study = tmp_path / "study.toml"
    study.write_text(text)
    orchestrator("verify", study, "--validation", "--points", 20, "--output", tmp_path / "out", code=3)
    summary = check(tmp_path / "out")
    assert summary["required"]["share"] == 0.05
    assert summary["dossier"]["tested"] == "2025-05-12"


@pytest.mark.parametrize("fmu", ["PlainBearingStand", "PlainBearingStand-me-fmi3"])
def test_a_starting_study_runs_at_once_and_verifies_nothing(fmu, tmp_path):
    study = tmp_path / "studies" / "new.toml"
    study.parent.mkdir()
    (tmp_path / "model.fmu").symlink_to(ROOT / "dist" / f"{fmu}.fmu")
    orchestrator("init", tmp_path / "model.fmu", "--stop", 1, "--step", 0.01, "--output", study)
    text = study.read_text()
    assert len(text.splitlines()) <= 60 and 'fmu = "../model.fmu"' in text
    said = orchestrator("verify", study, "--points", 8, "--output", tmp_path / "out", code=1)
    assert said.startswith("? No measured value yet\n") and "erified" not in said
    summary = check(tmp_path / "out")
    assert summary["verdict"] == "not verified" and summary["failed"] == 0
    assert summary["verdict_words"].startswith("no measured value yet: ")
    concern = summary["concerns"][0]
    assert (concern["code"], concern["severity"]) == ("nominal-from-model", "warning")
    assert {criterion["nominal_from"] for criterion in summary["criteria"].values()} == {"model"}
