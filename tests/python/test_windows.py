"""The program for Windows under wine, against the one for this machine; run with scripts/platforms/test-windows.

Both run the same studies. What they write has to be the same to the last byte, except for paths, times and versions; the
stand's own results may differ by the rounding of the C library's functions.
"""

import json
import os
import re
import signal
import subprocess
import sys
import time
import zipfile
from pathlib import Path

import pytest
from test_acceptance import PROGRAM, ROOT, rows

sys.path.insert(0, str(ROOT / "scripts"))
from platforms import host  # noqa: E402

pytestmark = pytest.mark.windows
EXE = os.environ.get("ORCHESTRATOR_EXE", "")
MODEL = ROOT / "tests/anywhere/model.c"
DESCRIPTION = """<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="2.0" modelName="anywhere" guid="anywhere">
  <CoSimulation modelIdentifier="anywhere" canHandleVariableCommunicationStepSize="true"/>
  <DefaultExperiment startTime="0" stopTime="1" stepSize="0.03125"/>
  <ModelVariables>
    <ScalarVariable name="rate" valueReference="0" causality="parameter" variability="fixed"><Real start="1"/></ScalarVariable>
    <ScalarVariable name="fault" valueReference="1" causality="parameter" variability="fixed"><Integer start="0"/></ScalarVariable>
    <ScalarVariable name="y" valueReference="2" causality="output"><Real/></ScalarVariable>
    <ScalarVariable name="sum" valueReference="3" causality="output"><Real/></ScalarVariable>
  </ModelVariables>
  <ModelStructure><Outputs><Unknown index="3"/><Unknown index="4"/></Outputs></ModelStructure>
</fmiModelDescription>
"""
STUDY = """
fmu = "anywhere.fmu"
[parameters.rate]
distribution = "uniform"
min = 0.125
max = 4
[parameters.fault]
distribution = "uniform"
min = 0
max = 6
[criteria.y]
variable = "y"
nominal = 0.9
tolerance = 0.2
[criteria.sum]
variable = "sum"
statistic = "mean"
nominal = 1
tolerance = 1
"""
WRITES_TO_NULL, EXITS, LOOPS, TAKES_MEMORY, OVERFLOWS_ITS_STACK, LEAVES_A_CHILD = range(1, 7)


def command(windows):
    return [host.wine(), EXE] if windows else [PROGRAM]


def run(folder, windows, *arguments, code=0, **environment):
    done = subprocess.run([*command(windows), *map(str, arguments)], cwd=folder, capture_output=True, text=True, timeout=580,
                          env={**os.environ, **host.quiet(), **environment})
    assert done.returncode == code, (done.returncode, done.stdout, done.stderr)
    return done


@pytest.fixture(scope="module", autouse=True)
def programs():
    if not EXE:
        pytest.skip("run scripts/platforms/test-windows")
    assert host.wine() and Path(EXE).is_file()
    host.wine_ready()


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A folder with the FMU for both platforms, its study, and a wine that has made its own files."""
    folder = tmp_path_factory.mktemp("windows")
    library, dll = folder / "anywhere.so", folder / "anywhere.dll"
    subprocess.run(["cc", "-O1", "-ffp-contract=off", "-shared", "-fPIC", "-o", library, MODEL], check=True)
    subprocess.run(["x86_64-w64-mingw32-gcc", "-O1", "-ffp-contract=off", "-shared", "-o", dll, MODEL], check=True)
    with zipfile.ZipFile(folder / "anywhere.fmu", "w") as fmu:
        fmu.writestr("modelDescription.xml", DESCRIPTION)
        fmu.write(library, "binaries/linux64/anywhere.so")
        fmu.write(dll, "binaries/win64/anywhere.dll")
    (folder / "study.toml").write_text(STUDY)
    run(folder, True, "--version")
    return folder


def table(folder, faults, points=24):
    lines = [f"{point},{0.125 + point / 16},{faults.get(point, 0)}" for point in range(1, points + 1)]
    (folder / "points.csv").write_text("\n".join(["point,rate,fault", *lines]) + "\n")


def both(folder, name, *arguments, code=0):
    """The results' folders of both programs."""
    found = []
    for windows in (False, True):
        output = folder / f"{name}-{'windows' if windows else 'here'}"
        run(folder, windows, *arguments, "--output", output.name, code=code)
        found.append(output)
    return found


# What belongs to the machine, the moment and the way to the results.
OWN = re.compile(r"^run$|version|path|folder|file|fmu$|study$|audit|isolation|reproducib|platform|summary_sha|digest")


def alike(one, other, place="summary"):
    """Whether two summaries tell the same: numbers to the rounding of the C libraries' functions."""
    if isinstance(one, dict):
        assert one.keys() == other.keys(), place
        for key in one:
            if not OWN.search(key):
                alike(one[key], other[key], f"{place}.{key}")
    elif isinstance(one, list):
        assert len(one) == len(other), place
        for number, (item, same) in enumerate(zip(one, other, strict=True)):
            alike(item, same, f"{place}.{number}")
    elif isinstance(one, float):
        assert one == pytest.approx(other, rel=1e-11), place
    else:
        assert one == other, place


def test_the_same_bytes_from_both(folder):
    table(folder, {})
    here, there = both(folder, "same", "verify", "study.toml", "--points-from", "points.csv")
    assert (here / "points.csv").read_bytes() == (there / "points.csv").read_bytes()
    summaries = [json.loads((place / "summary.json").read_text()) for place in (here, there)]
    alike(*summaries)
    assert summaries[0]["points"] == 24


def test_each_failure_costs_its_own_point(folder):
    faults = {3: WRITES_TO_NULL, 7: EXITS, 11: LOOPS, 15: TAKES_MEMORY, 19: OVERFLOWS_ITS_STACK, 22: LEAVES_A_CHILD}
    table(folder, faults)
    here, there = both(folder, "faults", "verify", "study.toml", "--points-from", "points.csv", "--jobs", "2",
                       "--point-timeout", "3", "--memory-limit", "300MB")
    ours, theirs = rows(here / "points.csv"), rows(there / "points.csv")
    for one, other in zip(ours, theirs, strict=True):
        point = int(one["point"])
        if point not in faults or point == 22:
            assert one == other and one["status"] == "ok", (one, other)
    status = {point: theirs[point - 1]["status"] for point in faults}
    assert "access violation (0xC0000005)" in status[3] and "about to write" in status[3]
    assert "7" in status[7] and "no licence on Sundays" in status[7]
    assert status[11].startswith("timeout") and status[15].startswith("out of memory")
    # Windows ends it with an exception, wine with the code 0.
    assert status[19].startswith(("crashed", "exited")) and "overflowed its stack" in status[19]


def processes(name):
    """The processes whose command line has the name."""
    found = []
    for entry in Path("/proc").iterdir():
        try:
            if entry.name.isdigit() and name.encode() in (entry / "cmdline").read_bytes():
                found.append(int(entry.name))
        except OSError:
            continue
    return found


def test_ctrl_c_ends_a_run_that_can_go_on(folder):
    table(folder, {}, points=200)
    environment = {**os.environ, **host.quiet(), "FAULTY_PAUSE": "0.2"}
    arguments = ["verify", "study.toml", "--points-from", "points.csv", "--jobs", "2", "--output", "ended"]
    process = subprocess.Popen([*command(True), *arguments], cwd=folder, env=environment, stdout=subprocess.PIPE,
                               stderr=subprocess.PIPE, text=True)
    journal = folder / "ended"
    until = time.monotonic() + 120
    while time.monotonic() < until and not any(file.stat().st_size > 2000 for file in journal.glob("*journal*")):
        time.sleep(0.1)
    process.send_signal(signal.SIGINT)
    _, said = process.communicate(timeout=60)
    assert process.returncode == 130 and "--resume goes on" in said, (process.returncode, said)
    until = time.monotonic() + 20
    while processes("orchestrator.exe") and time.monotonic() < until:
        time.sleep(0.1)
    assert not processes("orchestrator.exe")
    run(folder, True, *arguments, "--resume")
    run(folder, False, *arguments[:-1], "whole")
    assert (folder / "ended/points.csv").read_bytes() == (folder / "whole/points.csv").read_bytes()


def test_the_end_of_the_program_ends_its_workers(folder):
    table(folder, {5: LOOPS}, points=12)
    arguments = ["verify", "study.toml", "--points-from", "points.csv", "--jobs", "1", "--output", "killed"]
    process = subprocess.Popen([*command(True), *arguments], cwd=folder, env={**os.environ, **host.quiet()},
                               stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    until = time.monotonic() + 60
    while time.monotonic() < until and len(processes("orchestrator.exe")) < 3:
        time.sleep(0.1)
    assert len(processes("orchestrator.exe")) >= 3
    process.kill()
    process.wait()
    until = time.monotonic() + 20
    while processes("orchestrator.exe") and time.monotonic() < until:
        time.sleep(0.1)
    assert not processes("orchestrator.exe")


def test_the_papers_verification(folder):
    """Sampled points and the stand's results: within the rounding of the C libraries' functions; the verdict is the same."""
    study = folder / "paper-table3.toml"
    text = (ROOT / "studies/paper-table3.toml").read_text()
    study.write_text(re.sub(r'(?m)^fmu = .*$', f"fmu = '{os.path.relpath(ROOT / 'dist/PlainBearingStand.fmu', folder)}'", text))
    here, there = both(folder, "paper", "verify", study.name)
    ours, theirs = rows(here / "points.csv"), rows(there / "points.csv")
    assert len(ours) == len(theirs) == 50
    largest = 0.0
    for one, other in zip(ours, theirs, strict=True):
        assert one.keys() == other.keys()
        for key, text in one.items():
            try:
                value, same = float(text), float(other[key])
            except ValueError:
                assert text == other[key], (one["point"], key)
                continue
            largest = max(largest, abs(value - same) / max(abs(value), 1e-300))
    print(f"\nlargest relative difference {largest:.1e}; points.csv the same: "
          f"{(here / 'points.csv').read_bytes() == (there / 'points.csv').read_bytes()}")
    assert largest < 1e-11
    assert (there / "report.html").stat().st_size > 100_000


def test_the_commands_for_one_fmu(folder):
    said = [run(folder, windows, "check", "anywhere.fmu", code=1).stdout for windows in (False, True)]
    assert said[1].splitlines()[:1] == said[0].splitlines()[:1]
    described = [json.loads(run(folder, windows, "inspect", "anywhere.fmu", "--json").stdout) for windows in (False, True)]
    alike(*described, "inspect")
    for windows in (False, True):
        run(folder, windows, "simulate", "anywhere.fmu", "--set", "rate=2", "--output", f"one-{windows}.csv")
    assert (folder / "one-False.csv").read_bytes() == (folder / "one-True.csv").read_bytes()
    done = run(folder, True, "verify", "missing.toml", code=2)
    assert done.stderr.startswith("error: ") and "missing.toml" in done.stderr
