"""OpenSSH, Slurm and HyperQueue on this machine: every analysis gives the files of a run without them.

The long tests install what they need where they may.
"""

import contextlib

import pytest

import clusters
from test_launcher import ANALYSES, analyse, study, single  # noqa: F401


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
