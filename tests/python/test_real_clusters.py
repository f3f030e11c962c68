"""OpenSSH, Slurm and HyperQueue on this machine: every analysis gives the files of a run without them.

The long tests install what they need where they may.
"""

import contextlib
import os
import subprocess
import sys
import textwrap
import time

import pytest

import clusters
from test_acceptance import PROGRAM, ROOT
from test_cluster import files
from test_launcher import ANALYSES, analyse, run, single, study  # noqa: F401


@contextlib.contextmanager
def started(cluster, folder, **options):
    with contextlib.ExitStack() as stack:
        try:
            made = stack.enter_context(cluster(folder, **options))
        except clusters.Missing as missing:
            pytest.skip(str(missing))
        yield made


def same(analysis, cluster, study, folder):  # noqa: F811
    here = analyse(analysis, study, folder / "here", "--jobs", 2)
    assert analyse(analysis, study, folder / "there", *cluster.options, prefix=cluster.prefix, **cluster.environment) == here


@pytest.fixture(scope="module", params=["ssh", "slurm", "hyperqueue"])
def cluster(request, tmp_path_factory):
    options = {"install": True} if request.param == "ssh" else {}
    with started(getattr(clusters, request.param), tmp_path_factory.mktemp("clusters") / "one", **options) as made:
        yield made


def test_a_study_by_ssh(study, tmp_path):  # noqa: F811
    with started(clusters.ssh, tmp_path / "ssh") as cluster:
        same("verify", cluster, study, tmp_path)


@pytest.mark.long
@pytest.mark.parametrize("analysis", ANALYSES)
def test_every_analysis_on_a_real_cluster(analysis, cluster, study, single, tmp_path):  # noqa: F811
    same(analysis, cluster, study, tmp_path)


@pytest.mark.long
def test_what_many_workers_began_one_machine_ends(study, single, tmp_path):  # noqa: F811
    out, journal = tmp_path / "out", tmp_path / "out" / "journal.txt"
    command = [PROGRAM, "verify", study, "--output", out, "--launcher", "env", "--jobs", "64"]
    begun = subprocess.Popen(command, stdout=subprocess.DEVNULL, env=os.environ | {"FAULTY_PAUSE": "1"})
    # Some points are done while others are under way.
    while not journal.exists() or len(journal.read_text().splitlines()) < 20:
        assert begun.poll() is None
        time.sleep(0.01)
    begun.kill()
    begun.wait()
    assert run("verify", study, "--output", out, "--jobs", 2, "--resume").returncode == 0
    assert files(out) == files(single)


@pytest.mark.long
def test_a_job_at_its_time_limit_goes_on_later(study, single, tmp_path):  # noqa: F811
    """The lines of docs/cluster.md; Slurm's signal comes once some points are done."""
    text = (ROOT / "docs" / "cluster.md").read_text()
    lines = textwrap.dedent(text[text.index("    orchestrator verify my.toml --launcher \"srun -n1 -c1 --exact --mem=0\" --jobs 64"):])
    lines = lines[:lines.index("esac") + 4].replace("orchestrator verify my.toml", f"{PROGRAM} verify {study} --output {tmp_path}/out")
    script, journal = tmp_path / "job.sh", tmp_path / "out" / "journal.txt"

    def submit(pause):
        script.write_text(f"#!/bin/bash\nexport FAULTY_PAUSE={pause}\n{lines.replace('--jobs 64', '--jobs 4')}\n")
        return subprocess.Popen(["sbatch", "--wait", "-n4", "-o", tmp_path / "log", script], env=environment, stdout=subprocess.PIPE)
    with started(clusters.slurm, tmp_path / "slurm") as slurm:
        environment = os.environ | slurm.environment
        job = submit(0.5)
        while not journal.exists() or len(journal.read_text().splitlines()) < 20:
            assert job.poll() is None
            time.sleep(0.05)
        subprocess.run(["scancel", "--batch", "--signal=TERM", "1"], env=environment, check=True)
        # Interrupted, as after Ctrl-C.
        assert job.wait(60) == 130
        assert "--resume goes on" in (tmp_path / "log").read_text()
        assert submit(0).wait(60) == 0
    assert files(tmp_path / "out") == files(single)


MANIFEST = """
import kubernetes_validate, sys, yaml
for part in yaml.safe_load_all(sys.stdin):
    kubernetes_validate.validate(part, kubernetes_validate.latest_version(), strict=True)
"""


@pytest.mark.long
def test_manifests_follow_their_schema(tmp_path):
    pip = [sys.executable, "-m", "pip", "install", "-q", "--target", tmp_path, "kubernetes-validate==1.37.0", "pyyaml"]
    if subprocess.run(pip, capture_output=True).returncode:
        pytest.skip("kubernetes-validate cannot be installed")
    manifest = (ROOT / "examples" / "cluster" / "kubernetes.yaml").read_text()
    for text, code in [(manifest, 0), (manifest.replace("completionMode", "completionMod"), 1)]:
        done = subprocess.run([sys.executable, "-c", MANIFEST], input=text, text=True, capture_output=True,
                              env=os.environ | {"PYTHONPATH": str(tmp_path)})
        assert done.returncode == code, done.stderr
