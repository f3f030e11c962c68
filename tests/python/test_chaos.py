"""Sixty faults of machines, links and launchers at random moments: nothing is lost, nothing counts twice, nothing stays behind."""

import contextlib
import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

import clusters
from chaotic import PASSWORD
from faulty import Workshop
from test_acceptance import PROGRAM, orchestrator
from test_cluster import files
from test_launcher import run

CHAOTIC = Path(__file__).with_name("chaotic.py")
FAULTS, HOSTS, POINTS, PAUSE, PATIENCE = 60, 6, 4000, 0.05, 4
# The longest batch, which is computed again; and what passes after a fault until the next start on its host: the silence that is
# suffered, the end of the launcher, and the pause after two faults in a row.
BATCH, GAP = 2, PATIENCE + 2.5 + 2


def marked(text):
    """The processes with this in their environment."""
    found = []
    for environment in Path("/proc").glob("[0-9]*/environ"):
        with contextlib.suppress(OSError):
            if text.encode() in environment.read_bytes():
                found.append(int(environment.parent.name))
    return found


def end(pids, number):
    for pid in pids:
        with contextlib.suppress(ProcessLookupError):
            os.kill(pid, number)


@contextlib.contextmanager
def full_disk(folder):
    """A disk without room; where none can be made, a folder that is not there."""
    disk = folder / "full"
    if os.geteuid() == 0:
        disk.mkdir()
        mounted = subprocess.run(["mount", "-t", "tmpfs", "-o", "size=16k", "full", disk]).returncode == 0
        if mounted:
            try:
                yield disk
            finally:
                subprocess.run(["umount", "-l", disk], check=True)
            return
    yield disk / "none"


def feigned_clocks():
    """A library that shifts a process's clock, where there is one."""
    with contextlib.suppress(clusters.Missing):
        clusters.need("faketime", packages=["faketime"])
    return next(map(str, Path("/usr/lib").glob("*/faketime/libfaketime.so.1")), "")


@pytest.mark.long
@pytest.mark.parametrize("seed", [42])
def test_sixty_faults_cost_only_time(seed, tmp_path):
    study, hosts, chaos = tmp_path / "study.toml", tmp_path / "hosts", tmp_path / "chaos"
    chaos.mkdir()
    Workshop(tmp_path).study(study)
    study.write_text(study.read_text().replace("points = 40", f"points = {POINTS}"))
    hosts.write_text("".join(f"node{k}\n" for k in range(HOSTS)))
    orchestrator("verify", study, "--output", tmp_path / "single", "--extra-runs", 0)

    def launched(faults, folder, points, **environment):
        command = f"{sys.executable} {CHAOTIC} {chaos} {seed} {faults} {{host}}"
        begun = time.monotonic()
        done = run("verify", study, "--output", folder, "--points", points, "--extra-runs", 0, "--launcher", command, "--hosts", hosts,
                   "--launcher-timeout", PATIENCE, "--ship", FAULTY_PAUSE=str(PAUSE), CHAOTIC_PATIENCE=str(PATIENCE), **environment)
        assert done.returncode == 0, done.stderr
        return time.monotonic() - begun, done.stderr
    plain, _ = launched(0, tmp_path / "plain", POINTS // 8)
    (chaos / "count").unlink()
    (chaos / "log").unlink()
    with full_disk(tmp_path) as full:
        took, said = launched(FAULTS, tmp_path / "out", POINTS, CHAOTIC_FULL=str(full), CHAOTIC_CLOCK=feigned_clocks())
    ended = time.monotonic()
    log = [json.loads(line) for line in (chaos / "log").read_text().splitlines()]
    happened = [what for _, _, what in log if what != "starts"]
    print(f"\n{len(happened)} faults in {took:.1f} s, of {8 * plain:.1f} s without:",
          {what: happened.count(what) for what in sorted(set(happened))}, said)

    assert files(tmp_path / "out") == files(tmp_path / "single")
    counted = json.loads((tmp_path / "out" / "summary.json").read_text())["run"]
    assert (counted["computed"], sum(counted["hosts"].values())) == (POINTS, POINTS)
    # The last ones may find no point left.
    assert len(happened) >= FAULTS - HOSTS and len(set(happened)) >= 12

    gaps = [min((start for start, there, what in log if there == host and what == "starts" and start > begun), default=begun) - begun
            for begun, host, what in log if what not in ("starts", PASSWORD)]
    # A busy machine may take a while for a start.
    assert max(gaps) < 2 * GAP
    # One host may wait for its password until the end.
    assert took < (8 * plain * HOSTS + sum(gap + BATCH for gap in gaps)) / (HOSTS - 1) + GAP

    # A suspended one cannot end.
    assert marked(f"CHAOTIC_HOST={chaos}")
    end(marked(f"CHAOTIC_HOST={chaos}"), signal.SIGCONT)
    # One whose link was lost before the first order does not know how long to wait, and takes a minute.
    clusters.wait_for("the end of all workers", lambda: not marked(f"CHAOTIC_HOST={chaos}"), 70)
    print(f"the last worker ended {time.monotonic() - ended:.1f} s after the run")
    end(marked(f"CHAOTIC_LINK={chaos}"), signal.SIGKILL)
    # What killed workers had unpacked, the next ones there remove.
    launched(0, tmp_path / "after", HOSTS)
    left = [path for disk in chaos.glob("disk-*") for path in disk.iterdir()]
    assert left == []


@pytest.mark.long
def test_a_worker_that_gets_no_order_ends():
    """Its link was lost without a word: its input stays open."""
    with subprocess.Popen([PROGRAM, "fmu-points-remote"], stdin=subprocess.PIPE, stdout=subprocess.PIPE) as worker:
        assert worker.wait(70) == 1
