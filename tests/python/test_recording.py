"""From the recordings of a simulated rig to a study: the commands of docs/recordings.md on examples/recording."""

import json
import os
import shutil
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest
from conftest import ROOT

PROGRAM = Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target")) / os.environ.get("PROFILE", "debug") / "orchestrator"
EXAMPLE = ROOT / "examples" / "recording"
# What record.py has.
CLEARANCE, STIFFNESS, LATE = 21.0, 103.0, 17.2


def test_recordings_become_a_study(fmu, tmp_path):
    def run(*arguments):
        return subprocess.run([str(argument) for argument in arguments], cwd=tmp_path, check=True, capture_output=True,
                              text=True, env={**os.environ, "ORCHESTRATOR": str(PROGRAM)}).stdout

    for file in EXAMPLE.iterdir():
        shutil.copy(file, tmp_path)
    run(sys.executable, "record.py", ".", 2, fmu)
    cases = []
    for rpm, held_out in [(300, []), (450, ["--held-out"])]:
        run(PROGRAM, "synchronise", f"{rpm}rpm.csv", "--settings", "signals.toml", "--case", f"{rpm} rpm",
            "--output", str(rpm), *held_out)
        text = (tmp_path / str(rpm) / "case.toml").read_text()
        cases.append(text)
        case = tomllib.loads(text)["cases"][0]
        assert case.get("held-out", False) == bool(held_out)
        # The jackknife's interval is about 0.3 ms to both sides, and the lag of the model is known to 0.1 ms.
        assert float(case["criteria"]["M"]["delay"].removesuffix(" ms")) == pytest.approx(LATE, abs=0.6)
        estimate = case["criteria"]["M"]["reference"]["noise-estimate"]
        assert estimate["freedom"] > 50 and abs(estimate["correlation"]) < 0.5
        # Two spikes and two lost samples.
        table = tmp_path / str(rpm) / "case.csv"
        lines = table.read_text().splitlines()
        assert len(lines) == 1 + 601 - 4
        # A third of the rows is enough here, and takes a third of the time.
        table.write_text("\n".join([lines[0], *lines[1::3]]) + "\n")
    head = (EXAMPLE / "head.toml").read_text().replace("step = 0.005", "step = 0.01").replace("PlainBearingStand.fmu", str(fmu))
    (tmp_path / "study.toml").write_text("\n".join([head, *cases]))

    run(PROGRAM, "identify", "study.toml", "--starts", 1, "--output", "found")
    found = json.loads((tmp_path / "found" / "identification.json").read_text())
    # The zero error of the recorded speed and what is left of the delay are found with the parameters.
    assert [parameter["name"] for parameter in found["free"][2:]] == ["drive.speed/offset", "300 rpm/M/lag"]
    late = float(tomllib.loads(cases[0])["cases"][0]["criteria"]["M"]["delay"].removesuffix(" ms"))
    for parameter, truth in zip(found["free"], [CLEARANCE, STIFFNESS, 0.0, 1e-3 * (LATE - late)], strict=True):
        low, high = parameter["interval"]
        assert low < truth < high

    run(PROGRAM, "verify", "study.toml", "--points", 16, "--output", "space")
    summary = json.loads((tmp_path / "space" / "summary.json").read_text())
    assert summary["cases"]["450 rpm"]["held_out"] and summary["verified"] > 0
    assert all(criterion["risk"] for criterion in summary["criteria"].values())
    assert 0 < summary["risk"]["conformance_probability"] < 1
    page = (tmp_path / "space" / "report.html").read_text()
    assert "verified points" in page and 'class="verified"' in page
