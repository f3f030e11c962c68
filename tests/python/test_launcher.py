"""Workers that a command starts: whatever becomes of them, the files are those of a run on one machine."""

import json
import os
import shutil
import signal
import subprocess
import sys
import time
import zipfile
from pathlib import Path

import pytest
import python_package  # noqa: F401  (where fmu_orchestrator is found)
from faulty import Workshop
from fmu_orchestrator import Study
from test_acceptance import PROGRAM, orchestrator
from test_cluster import files

POINTS = 120
LAUNCHED = Path(__file__).with_name("launched.py")
IDENTIFY = """
fmu = "{fmu}"
[identify]
starts = 2
[identify.free.rate]
min = 0.5
max = 2
[identify.measured.y]
variable = "y"
value = 0.5
accuracy = 0.01
"""
ANALYSES = {
    "verify": ("verify",),
    # How many points run again afterwards depends on how long the others took.
    "until": ("verify", "--until", "ci 0.04", "--extra-runs", 0),
    "sensitivity": ("sensitivity", "--base", 16),
    "identify": ("identify",),
    "robustness": ("robustness", "--from", "{verified}", "--confirm", 20),
}


def run(*arguments, prefix=(), **environment):
    command = [*map(str, prefix), PROGRAM, *map(str, arguments)]
    return subprocess.run(command, capture_output=True, text=True, env=os.environ | environment)


@pytest.fixture(scope="module")
def study(tmp_path_factory):
    folder = tmp_path_factory.mktemp("launcher")
    file = folder / "study.toml"
    Workshop(folder).study(file)
    file.write_text(file.read_text().replace("sobol", "monte-carlo").replace("points = 40", f"points = {POINTS}"))
    (folder / "identify.toml").write_text(IDENTIFY.format(fmu=folder / "healthy.fmu"))
    return file


@pytest.fixture(scope="module")
def single(study):
    """The folder of a run on this machine alone."""
    orchestrator("verify", study, "--output", study.parent / "single", "--jobs", 2)
    return study.parent / "single"


def faulty(faults, folder):
    folder.mkdir(exist_ok=True)
    return f"{sys.executable} {LAUNCHED} {faults} {folder}"


def launched(study, folder, command, *options, **environment):
    options = ["--jobs", 2, *options] if "--hosts" not in options else options
    done = run("verify", study, "--output", folder, "--launcher", command, *options, **environment)
    assert done.returncode == 0, done.stderr
    return done


def test_a_launcher_may_print_lines(study, single, tmp_path):
    command = "sh -c 'echo Welcome; echo fmu-points worker on $HOSTNAME; printf \"loading modules ...\"; exec \"$@\"' --"
    assert launched(study, tmp_path / "out", command).stderr == ""
    assert files(tmp_path / "out") == files(single)
    assert sum(json.loads((tmp_path / "out" / "summary.json").read_text())["run"]["hosts"].values()) == POINTS


def test_hosts(study, single, tmp_path):
    hosts = tmp_path / "hosts"
    hosts.write_text("node1 2  # the large one\nnode2\n")
    # Each command waits for the others, so that none comes when the points are done.
    wait = f"cd {tmp_path}; echo $0 >> starts; until [ $(wc -l < starts) -ge 3 ]; do sleep 0.05; done"
    command = f"sh -c '{wait}; exec \"$@\"' {{host}}"
    launched(study, tmp_path / "out", command, "--hosts", hosts)
    assert files(tmp_path / "out") == files(single)
    assert sorted((tmp_path / "starts").read_text().split()) == ["node1", "node1", "node2"]
    run = json.loads((tmp_path / "out" / "summary.json").read_text())["run"]
    assert run["jobs"] == 3 and sum(run["hosts"].values()) == POINTS
    # A worker that comes late may find no point left.
    assert run["hosts"].keys() <= {"node1", "node2"}


def test_a_host_that_refuses_is_tried_again_while_others_may_come(study, single, tmp_path):
    """One host refuses three times, and the other one starts only then."""
    hosts, starts = tmp_path / "hosts", tmp_path / "starts"
    hosts.write_text("refuses\nwaits\n")
    wait = f"until [ -e {starts} ] && [ $(wc -l < {starts}) -ge 3 ]; do sleep 0.05; done"
    command = f"sh -c 'if [ $0 = refuses ]; then echo >> {starts}; exit 255; fi; {wait}; exec \"$@\"' {{host}}"
    launched(study, tmp_path / "out", command, "--hosts", hosts)
    assert files(tmp_path / "out") == files(single)


def analyse(analysis, study, folder, *more, prefix=(), **environment):
    """Runs an analysis; its files by name."""
    name, *options = [str(word).format(verified=study.parent / "single") for word in ANALYSES[analysis]]
    file = study.with_name("identify.toml") if name == "identify" else study
    done = run(name, file, *options, "--output", folder, *more, prefix=prefix, **environment)
    assert done.returncode == 0, done.stderr
    kept = [file for file in sorted(folder.iterdir()) if file.suffix in (".csv", ".json", ".toml", ".ssv")]
    texts = {file.name: file.read_bytes() for file in kept}
    if name == "verify":
        texts["summary.json"] = files(folder)[-1]
    assert texts
    return texts


@pytest.mark.parametrize("analysis", ANALYSES)
def test_every_analysis(analysis, study, single, tmp_path):
    here = analyse(analysis, study, tmp_path / "here", "--jobs", 2)
    assert analyse(analysis, study, tmp_path / "there", "--jobs", 2, "--launcher", "env") == here


@pytest.mark.parametrize("faults, options", [
    ("refuses", []),
    ("dies,garbage", []),
    ("kills,cuts", []),
    ("alters,alters,alters", []),
    # Silence shows by nothing but time.
    ("hangs,stops", ["--launcher-timeout", 5]),
])
def test_a_lost_worker_costs_nothing(faults, options, study, single, tmp_path):
    launched(study, tmp_path / "out", faulty(faults, tmp_path / "starts"), *options)
    assert files(tmp_path / "out") == files(single)
    # No faulty worker can finish the points: at least one more was started.
    assert len(list((tmp_path / "starts").iterdir())) > faults.count(",") + 1


def test_from_python(study, single, tmp_path):
    result = Study.load(study).verify(launcher="env", jobs=2, output=tmp_path / "out", progress=False)
    assert files(result.folder) == files(single)


def test_a_run_without_workers_goes_on_later(study, single, tmp_path):
    """Every worker is lost: the run ends, and another one completes it."""
    out = tmp_path / "out"
    done = run("verify", study, "--output", out, "--jobs", 1, "--launcher", "false")
    assert done.returncode == 2
    launched(study, out, faulty("garbage", tmp_path / "starts"), "--resume")
    assert files(out) == files(single)


@pytest.mark.parametrize("command, words, options", [
    ("false", "exit status: 1", []),
    ("no-such-launcher", "No such file", []),
    ("sh -c 'echo Permission denied, please try again. >&2; exit 255' --", "Permission denied, please try again.", []),
    ("sh -c 'exec \"$@\" < /dev/null' --", "the launcher ended", []),
    # These would wait for ever.
    ("sh -c 'printf \"password: \"; exec sleep 100' --", "no worker started within 2 s: password:", ["--launcher-timeout", 2]),
    ("yes", "no worker started within 1 s", ["--launcher-timeout", 1]),
])
def test_a_launcher_that_starts_no_worker(command, words, options, study, tmp_path):
    done = run("verify", study, "--output", tmp_path, "--jobs", 2, "--launcher", command, *options)
    assert done.returncode == 2
    assert words in done.stderr and done.stderr.count("error: ") == 1
    assert len(done.stderr.splitlines()) <= 2, done.stderr


def test_nohup_keeps_a_run_when_its_user_leaves(study, single, tmp_path):
    out, held = tmp_path / "out", tmp_path / "held"
    held.touch()
    command = ["nohup", PROGRAM, "verify", study, "--output", out, "--launcher", "env", "--jobs", "2"]
    begun = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
                             env=os.environ | {"FAULTY_FOLDER": str(tmp_path)})
    # Points wait in the middle of the run: its handlers are set.
    while not (tmp_path / "begun").exists() or (tmp_path / "begun").stat().st_size <= 20:
        assert begun.poll() is None
        time.sleep(0.01)
    begun.send_signal(signal.SIGHUP)
    held.unlink()
    assert begun.wait() == 0
    assert files(out) == files(single)


def test_another_build_is_told(study, tmp_path):
    other = tmp_path / "orchestrator"
    shutil.copy(PROGRAM, other)
    with other.open("ab") as file:
        file.write(b"other")
    done = run("verify", study, "--output", tmp_path / "out", "--launcher", "env", "--worker-program", other)
    assert done.returncode == 2 and "another build" in done.stderr


def test_a_shipped_fmu_leaves_nothing(study, single, tmp_path):
    node = tmp_path / "node"
    node.mkdir()
    launched(study, tmp_path / "out", f"env TMPDIR={node}", "--ship")
    assert files(tmp_path / "out") == files(single)
    assert list(node.iterdir()) == []


def test_an_fmu_is_sent_once(study, tmp_path):
    """However many messages that takes."""
    large, orders = tmp_path / "large.fmu", tmp_path / "orders"
    shutil.copy(study.parent / "healthy.fmu", large)
    with zipfile.ZipFile(large, "a") as archive:
        archive.writestr("resources/data.bin", os.urandom(3 << 20))
    done = run("verify", study, "--output", tmp_path / "out", "--fmu", large, "--extra-runs", 0, "--jobs", 1, "--ship",
               "--launcher", f"sh -c 'tee {orders} | \"$@\"' --")
    assert done.returncode == 0, done.stderr
    assert orders.stat().st_size < 1.1 * large.stat().st_size


@pytest.mark.parametrize("options", [["--hosts", "x"], ["--ship"], ["--launcher", ""], ["--launcher", "env", "--isolation", "none"],
                                     ["--launcher", "env", "--launcher-timeout", "0"]])
def test_mistakes(options, study, tmp_path):
    assert run("verify", study, "--output", tmp_path, *options).returncode == 2
