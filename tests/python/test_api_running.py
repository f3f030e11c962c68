"""Runs of the Python package: Ctrl-C, progress, and the command that it installs."""

import os
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import pytest
from faulty import Workshop
from python_package import ENVIRONMENT, same
from supervised import GRACE

from fmu_orchestrator import OrchestratorError, Study
from fmu_orchestrator._progress import Journal, Text

DEADLINE = 120.0  # s; a busy machine tells progress late
RUNNER = """
import signal, sys
from fmu_orchestrator import Interrupted, Study
# A script that runs the tests in the background may ignore it.
signal.signal(signal.SIGINT, signal.default_int_handler)
try:
    Study.load(sys.argv[1]).verify(output=sys.argv[2], jobs=2)
except Interrupted as stop:
    print(stop)
    sys.exit(77)
"""


def interrupt(arguments, journal, send, environment):
    """Sends Ctrl-C when points are done."""
    process = subprocess.Popen([sys.executable, "-c", RUNNER, *map(str, arguments)], stdout=subprocess.PIPE, text=True,
                               env=environment, start_new_session=True)
    while process.poll() is None and not (journal.is_file() and journal.read_bytes().count(b"\n") > 3):
        time.sleep(0.005)
    send(process.pid, signal.SIGINT)
    return process, process.communicate()[0]


def session(leader):
    """The processes of a session."""
    found = []
    for entry in Path("/proc").iterdir():
        try:
            # What follows the name in brackets: state, parent, group, session.
            if entry.name.isdigit() and int((entry / "stat").read_text().rpartition(")")[2].split()[3]) == leader:
                found.append(entry.name)
        except OSError:  # gone meanwhile
            continue
    return found


# A notebook's stop may reach Python alone; on a terminal Ctrl-C reaches the program, too.
@pytest.mark.parametrize("send", [os.kill, os.killpg])
def test_ctrl_c_keeps_what_is_done(send, tmp_path, monkeypatch):
    monkeypatch.setenv("FAULTY_FOLDER", str(tmp_path))
    study, folder, held = tmp_path / "study.toml", tmp_path / "out", tmp_path / "held"
    Workshop(tmp_path).study(study)
    held.touch()
    process, said = interrupt([study, folder], folder / "journal.txt", send, {**ENVIRONMENT, "FAULTY_FOLDER": str(tmp_path)})
    held.unlink()
    assert process.returncode == 77 and said.strip() == f"interrupted; resume=True goes on in {folder}"
    # Nothing of the run is left: neither its processes, which belong to its session, nor its folders.
    end = time.monotonic() + GRACE
    while session(process.pid) and time.monotonic() < end:
        time.sleep(0.01)
    assert session(process.pid) == []
    assert not list(folder.glob(".running-*"))
    done = Journal(folder, resume=True)
    assert done.look() and 0 < done.done < 40 and done.total == 40
    with pytest.raises(OrchestratorError, match="continue it with resume=True, replace it with force=True, or choose another output"):
        Study.load(study).verify(output=folder)
    whole = Study.load(study).verify(output=folder, resume=True)
    assert whole.summary["run"]["computed"] == 40 - done.done
    same(folder, Study.load(study).verify(output=tmp_path / "whole").folder)


@pytest.fixture
def held(tmp_path, monkeypatch):
    """A study of 40 points that a file holds before their end, however fast the machine is; and the file."""
    monkeypatch.setenv("FAULTY_FOLDER", str(tmp_path))
    monkeypatch.setattr("fmu_orchestrator._progress.QUIET", 0.0)
    monkeypatch.setattr("fmu_orchestrator._program.GLANCE", 0.01)
    Workshop(tmp_path).study(tmp_path / "study.toml")
    file = tmp_path / "held"
    # Where progress is not told, nothing else lets the points go.
    end = threading.Timer(DEADLINE, file.unlink, kwargs={"missing_ok": True})
    end.start()
    yield Study.load(tmp_path / "study.toml"), file
    end.cancel()


def test_progress_is_told(held, tmp_path):
    study, file = held
    told = []

    def progress(*counts):
        told.append(counts)
        file.unlink(missing_ok=True)

    for attempt in range(2):
        told.clear()
        file.touch()
        study.verify(output=tmp_path / "out", extra_runs=0, progress=progress)
        # The second run replaces the journal that is there, and does not begin with its 40 points.
        assert told and told[0][0] < 40 and {total for _, total in told} == {40}
        assert [done for done, _ in told] == sorted(done for done, _ in told)
    journal = Journal(tmp_path / "out", resume=True)
    assert journal.look() and journal.done == 40


def test_a_log_gets_a_line_now_and_then(held, tmp_path, monkeypatch, capsys):
    study, file = held
    words = Text.words

    def released(self, *counts):
        file.unlink(missing_ok=True)
        return words(self, *counts)

    monkeypatch.setattr(Text, "words", released)
    for seldom, progress, told in [(0.0, None, True), (0.0, False, False), (float("inf"), None, False)]:
        monkeypatch.setattr("fmu_orchestrator._progress.SELDOM", seldom)
        if progress is None:
            file.touch()
        study.verify(output=tmp_path / "out", extra_runs=0, progress=progress)
        lines = capsys.readouterr().err.splitlines()
        assert any(" of 40 points" in line for line in lines) == told and not any("\r" in line for line in lines), lines


def test_the_command_finds_the_packages_studies(tmp_path):
    call = [sys.executable, "-m", "fmu_orchestrator"]
    done = subprocess.run([*call, "verify", "paper-table3", "--points", "3", "--seed", "2"], cwd=tmp_path,
                          env=ENVIRONMENT, capture_output=True, text=True)
    assert done.returncode in (0, 1) and (tmp_path / "results/paper-table3/report.html").is_file(), done.stderr
    # A file of the user's own comes first, and other commands' arguments stay as they are.
    (tmp_path / "rig").write_text("none")
    for arguments in [["verify", "rig"], ["check", "paper-table3"]]:
        done = subprocess.run([*call, *arguments], cwd=tmp_path, env=ENVIRONMENT, capture_output=True, text=True)
        assert done.returncode == 2 and done.stderr.startswith(f"error: {arguments[1]}"), done.stderr
    missing = {**ENVIRONMENT, "FMU_ORCHESTRATOR_PROGRAM": str(tmp_path / "none")}
    done = subprocess.run([*call, "--help"], env=missing, capture_output=True, text=True)
    assert done.returncode == 2 and "there is no program" in done.stderr
