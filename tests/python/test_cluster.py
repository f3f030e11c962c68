"""Past one machine: the example for Dask, with a worker that is killed, gives the files of a single run."""

import json
import os
import signal
import sys
import threading
import time

from distributed import Client, LocalCluster

from test_acceptance import PROGRAM, ROOT, orchestrator

sys.path.insert(0, str(ROOT / "examples" / "cluster"))
import dask_shards  # noqa: E402

# Some 10 ms a point: long enough to be killed in the middle.
STUDY = """
fmu = "{fmu}"
[simulation]
stop = 20
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
    summary.pop("run")
    return [(folder / name).read_bytes() for name in ["points.csv", "best.ssv", "best.srmd"]] + [summary]


def kill_one(client, folder, killed):
    """Kills the Dask worker of the first part that has finished a point."""
    end = time.monotonic() + 60
    while time.monotonic() < end and not killed:
        for journal in folder.glob("shard-*/journal.txt"):
            number = int(journal.parent.name.split("-")[1])
            if len(journal.read_text().splitlines()) < 2:
                continue
            processing = client.run(worker_pid)
            for address, tasks in client.processing().items():
                if tasks and not killed:
                    os.kill(processing[address], signal.SIGKILL)
                    killed.append(number)
        time.sleep(0.005)


def worker_pid():
    return os.getpid()


def test_a_lost_dask_worker_costs_nothing(fmu, tmp_path):
    study = tmp_path / "study.toml"
    study.write_text(STUDY.format(fmu=fmu))
    orchestrator("verify", study, "--output", tmp_path / "single")
    killed = []
    with LocalCluster(n_workers=3, threads_per_worker=1, dashboard_address=None) as cluster, Client(cluster) as client:
        thread = threading.Thread(target=kill_one, args=(client, tmp_path / "dask", killed))
        thread.start()
        code = dask_shards.run(client, str(PROGRAM), study, tmp_path / "dask", 6)
        thread.join()
    assert code == 0 and len(killed) == 1
    assert files(tmp_path / "dask") == files(tmp_path / "single")
