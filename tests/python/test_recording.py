"""From the recordings of a simulated rig to a study: the commands of docs/recordings.md on examples/recording."""

import json
import math
import os
import random
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


def test_the_engine_of_the_documents(tmp_path):
    """The settings of docs/recordings.md, on a noisy speed at 1 kHz and a logger of temperatures with a clock of its own."""
    noise = random.Random(1)
    settings = (ROOT / "docs" / "recordings.md").read_text().split("```toml\n")[1].split("```")[0]
    (tmp_path / "engine.toml").write_text(settings)
    rows = ["t [ms],n [1/min],U_p [V]"]
    for k in range(60_000):
        # The speed steps up by 50 rpm within a second.
        speed = 3000 + min(max(k / 1000 - 30, 0), 1) * 50 + noise.gauss(0, 5)
        rows.append(f"{k},{speed:.2f},{2 + 0.1 * math.sin(k / 1000) + noise.gauss(0, 0.01):.4f}")
    (tmp_path / "fast.csv").write_text("\n".join(rows) + "\n")
    rows = ["Prüfstand 7", "Bediener;Meier", "", "Zeit;T_oel;T_wasser", "s;°C;°C"]
    rows += [f"{k};{80 + noise.gauss(0, 0.2):.2f};OVR".replace(".", ",") for k in range(60)]
    (tmp_path / "slow.txt").write_text("\n".join(rows) + "\n", encoding="cp1252")
    subprocess.run([sys.executable, "-m", "fmu_orchestrator", "convert", "slow.txt"], cwd=tmp_path, check=True, capture_output=True,
                   env={**os.environ, "PYTHONPATH": str(ROOT / "python")})
    command = [PROGRAM, "synchronise", "fast.csv", "slow.csv", "--settings", "engine.toml", "--case", "idle", "--output", "out"]
    subprocess.run(command, cwd=tmp_path, check=True, capture_output=True)
    case = tomllib.loads((tmp_path / "out" / "case.toml").read_text())["cases"][0]
    assert case["criteria"]["p_oil"]["reference"]["file"] == "out/case.csv"
    assert case["criteria"]["T_oil"]["reference"]["file"] == "out/case-2.csv"
    assert case["criteria"]["T_oil"]["window"] == {"from": 2.0, "to": 59.8}
    speed = case["inputs"]["engine.speed"]
    assert speed["unit"] == "rpm"
    corners = [[float(cell) for cell in row.split(",")] for row in (tmp_path / speed["file"]).read_text().splitlines()[1:]]
    assert 4 <= len(corners) < 100
    # The angle within the run, in turns: the noise adds up to 5 rpm / 60 times the root of 60,000 ms / 1000, and that four times.
    pairs = zip(corners, corners[1:])
    turns = sum((after[0] - before[0]) * (after[1] + before[1]) / 120 for before, after in pairs)
    assert abs(turns - (59.999 * 3000 + 50 * (0.5 + 28.999)) / 60) < 4 * 5 / 60 * math.sqrt(60_000) / 1000
    criteria = tomllib.loads((tmp_path / "out" / "criteria.toml").read_text())["criteria"]
    assert abs(criteria["p_oil"]["nominal"] - 3.2) < 0.02 and abs(criteria["T_oil"]["nominal"] - 80) < 0.1
