"""The stand with a study packed into it: other tools take it as before."""

import subprocess
import zipfile

import fmpy
from fmpy.validation import validate_fmu
from lxml import etree
from test_acceptance import PROGRAM
from test_ci import STUDY

FOLDER = "extra/org.fmi-standard.fmi-ls-ref/"
MANIFEST = FOLDER + "fmi-ls-manifest.xml"
# The roles of 1.0.0-alpha.1.
ROLES = {"document", "parameter", "experiment/validation", "experiment/uncertainty-analysis", "result", "report", "other"}


def test_a_packed_study_harms_no_other_tool(fmu, tmp_path):
    def run(*arguments):
        done = subprocess.run([PROGRAM, *arguments], cwd=tmp_path, text=True, capture_output=True)
        assert done.returncode == 0, done.stdout + done.stderr
        return done.stdout

    (tmp_path / "study.toml").write_text(STUDY)
    (tmp_path / "model.fmu").write_bytes(fmu.read_bytes())
    run("pack", "study.toml", "--output", "carrier.fmu")
    carrier = tmp_path / "carrier.fmu"
    with zipfile.ZipFile(fmu) as before, zipfile.ZipFile(carrier) as after:
        assert all(before.read(name) == after.read(name) for name in before.namelist() if name != MANIFEST)
        manifest = etree.fromstring(after.read(MANIFEST))
        sources = [related.get("source") for related in manifest]
        # The stand had a manifest of its own; each file is listed once.
        assert {related.get("source") for related in etree.fromstring(before.read(MANIFEST))} < set(sources)
        there = [name.removeprefix(FOLDER) for name in after.namelist() if name.startswith(FOLDER) and name != MANIFEST]
        assert sorted(sources) == sorted(there) and {related.get("role") for related in manifest} <= ROLES
    assert validate_fmu(str(carrier)) == []
    ours, theirs = (fmpy.simulate_fmu(str(file), stop_time=0.1) for file in (carrier, fmu))
    assert ours.tobytes() == theirs.tobytes()
    told = run("verify", "carrier.fmu", "--output", "there")
    assert "The study study, which the FMU carries, against its result: No difference" in told
