"""Past one machine: the example for Dask, with a worker that is killed, gives the files of a single run."""

import json
import os
import shutil
import signal
import sys
import threading

from distributed import Client, LocalCluster

from test_acceptance import PROGRAM, ROOT, orchestrator

sys.path.insert(0, str(ROOT / "examples" / "cluster"))
import dask_shards  # noqa: E402

# Some milliseconds a point: long enough to be killed in the middle.
STUDY = """
fmu = "{fmu}"
[simulation]
stop = 10
step = 0.001
[design]
method = "halton"
points = 120
[parameters."bearing.radialClearance"]
distribution = "normal"
mean = 0.02
deviation = 0.002
unit = "mm"
[criteria.P]
variable = "sensor.frictionPower"
statistic = "mean"
nominal = 14
tolerance = "50 %"
"""


def files(folder):
    summary = json.loads((folder / "summary.json").read_text())
    # How the points were computed may differ; what came out may not.
    for how in ["run", "isolation", "audits", "audits_of_shared", "audit_mismatches", "reproducibility"]:
        summary.pop(how)
    return [(folder / name).read_bytes() for name in ["points.csv", "best.ssv", "best.srmd"]] + [summary]


def kill_one(client, processes, folder, killed, over):
    """Kills a Dask worker that is at work as soon as a part has finished a point, unless all is over before."""
    while not over.wait(0.005):
        begun = [journal for journal in folder.glob("shard-*/journal.txt")
                 if len(journal.read_text().splitlines()) > 1]
        busy = [address for address, tasks in client.processing().items() if tasks] if begun else []
        if busy:
            os.kill(processes[busy[0]], signal.SIGKILL)
            killed.append(busy[0])
            return


def test_a_lost_dask_worker_costs_nothing(fmu, tmp_path):
    study = tmp_path / "study.toml"
    study.write_text(STUDY.format(fmu=fmu))
    orchestrator("verify", study, "--output", tmp_path / "single")
    killed = []
    for _ in range(10):
        with LocalCluster(n_workers=3, threads_per_worker=1, dashboard_address=None) as cluster, Client(cluster) as client:
            processes = client.run(os.getpid)
            over = threading.Event()
            arguments = client, processes, tmp_path / "dask", killed, over
            thread = threading.Thread(target=kill_one, args=arguments, daemon=True)
            thread.start()
            code = dask_shards.run(client, str(PROGRAM), study, tmp_path / "dask", 6)
            over.set()
            thread.join()
        assert code == 0
        if killed:
            break
        # On a busy machine all parts may be done before it is seen that one has begun.
        shutil.rmtree(tmp_path / "dask")
    assert len(killed) == 1
    assert files(tmp_path / "dask") == files(tmp_path / "single")
