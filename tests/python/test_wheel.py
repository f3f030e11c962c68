"""The wheel, built and installed where there is nothing else; run with `pytest -m long`."""

import json
import os
import subprocess
import sys
import time
import zipfile

import faulty
import pytest
from test_acceptance import ROOT, TABLE3, orchestrator, rows

pytestmark = pytest.mark.long
LARGEST = 20_000_000


def build():
    # Left by earlier builds: `pip install dist/*.whl` would fail with it.
    (ROOT / "dist").mkdir(exist_ok=True)
    (ROOT / "dist/fmu_orchestrator-0.0.0-py3-none-win_amd64.whl").touch()
    done = subprocess.run([ROOT / "scripts/wheel"], cwd=ROOT, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr
    [made] = (ROOT / "dist").glob("*.whl")
    return made, done.stdout


@pytest.fixture(scope="module")
def wheel():
    return build()[0]


@pytest.fixture(scope="module")
def bare(wheel, tmp_path_factory):
    """An empty virtual environment with the wheel, and nothing of Rust on its path."""
    folder = tmp_path_factory.mktemp("bare")
    python = folder / "venv/bin/python"
    begun = time.monotonic()
    subprocess.run([sys._base_executable, "-m", "venv", folder / "venv"], check=True)
    made = time.monotonic()
    subprocess.run([python, "-m", "pip", "install", "--quiet", "--no-index", wheel], check=True)
    print(f"\nvirtual environment {made - begun:.1f} s, wheel {time.monotonic() - made:.1f} s")
    environment = {"PATH": f"{python.parent}{os.pathsep}/usr/bin{os.pathsep}/bin", "HOME": str(folder)}

    def run(*command, code=0):
        done = subprocess.run([str(part) for part in command], cwd=folder, env=environment, capture_output=True, text=True)
        assert done.returncode == code, done.stderr
        return done.stdout

    run.folder, run.environment = folder, environment
    return run


def test_the_same_sources_give_the_same_bytes(wheel):
    before = wheel.read_bytes()
    again, said = build()
    assert again == wheel and wheel.read_bytes() == before
    assert "glibc 2.17" in said and "left out" in said


def test_what_the_wheel_holds(wheel):
    assert "manylinux_2_17_x86_64" in wheel.name
    with zipfile.ZipFile(wheel) as archive:
        names = {entry.filename: entry for entry in archive.infolist()}
        program = names["fmu_orchestrator/bin/orchestrator"]
        assert program.file_size <= LARGEST and program.external_attr >> 16 & 0o111
        assert {"fmu_orchestrator/py.typed", "fmu_orchestrator/studies/rig.toml",
                "fmu_orchestrator/examples/tutorial/recording.csv"} <= set(names)
        content = archive.read("fmu_orchestrator/bin/orchestrator")
        fmu = archive.read("fmu_orchestrator/dist/PlainBearingStand.fmu")
    # No folder of the machine that built it.
    assert str(ROOT).encode() not in content and os.path.expanduser("~/.cargo").encode() not in content
    assert fmu == (ROOT / "dist/PlainBearingStand.fmu").read_bytes()


def test_the_papers_verification_in_an_empty_environment(bare, tmp_path):
    begun = time.monotonic()
    said = bare("orchestrator", "verify", "paper-table3", "--verbose")
    print(f"\nverification with its report {time.monotonic() - begun:.1f} s")
    results = bare.folder / "results/paper-table3"
    orchestrator("verify", "studies/paper-table3.toml", "--output", tmp_path)
    assert (results / "points.csv").read_bytes() == (tmp_path / "points.csv").read_bytes()
    assert (results / "report.html").stat().st_size > 100_000
    verified = sum(row["verified"] == "true" for row in rows(results / "points.csv"))
    assert f"all criteria: verified {verified}" in " ".join(said.split())


def test_an_exception_of_an_fmu_is_told_from_a_wrong_address(bare, tmp_path):
    """Program and FMU have one unwinder (scripts/platforms/unwinder.py)."""
    thrower = faulty.Workshop(tmp_path).model(next(model for model in faulty.MODELS if model.name == "throws"))
    done = subprocess.run(["orchestrator", "simulate", thrower, "--set", "fault=1"], env=bare.environment, capture_output=True,
                          text=True, cwd=bare.folder)
    assert done.returncode == 2 and "SIGABRT" in done.stderr, done.stderr


def test_the_source_package_builds_where_there_is_only_rust(bare, tmp_path):
    """pip compiles program and FMU. Plain cargo takes another C library: sines may differ in the last digits."""
    [made] = subprocess.run([ROOT / ".venv/bin/python", "-m", "hatchling", "build", "--target", "sdist", "--directory", tmp_path],
                            cwd=ROOT / "python", check=True, capture_output=True, text=True).stdout.split()
    subprocess.run([sys._base_executable, "-m", "venv", tmp_path / "venv"], check=True)
    environment = {name: value for name, value in os.environ.items() if name != "CARGO_TARGET_DIR"}
    subprocess.run([tmp_path / "venv/bin/python", "-m", "pip", "install", "--quiet", made], env=environment, check=True)
    subprocess.run([tmp_path / "venv/bin/orchestrator", "verify", "paper-table3", "--output", "own"], cwd=tmp_path, check=True)
    bare("orchestrator", "verify", "paper-table3", "--output", tmp_path / "shipped")
    for own, shipped in zip(rows(tmp_path / "own/points.csv"), rows(tmp_path / "shipped/points.csv"), strict=True):
        assert float(own["P_fr"]) == pytest.approx(float(shipped["P_fr"]), rel=1e-9)


API = """
import json, sys
from fmu_orchestrator import Study, program, shipped_fmu, simulate
result = Study.load("paper-table3").judge(sys.argv[1])
torque = simulate(shipped_fmu(), stop=1, step=1)["sensor.frictionTorque"][-1]
print(json.dumps([result.verdict.verified, str(program()), torque]))
"""


def test_the_api_in_an_empty_environment(bare, fmu, tmp_path):
    verified, program, torque = json.loads(bare("python", "-c", API, TABLE3))
    assert verified == 9 and program.startswith(str(bare.folder))
    orchestrator("simulate", fmu, "--stop", 1, "--step", 1, "--output", tmp_path / "run.csv")
    assert torque == float(rows(tmp_path / "run.csv")[-1]["sensor.frictionTorque"])
