"""Past one machine: the example for Dask, with a worker that is killed, gives the files of a single run."""

import json
import os
import signal
import threading
import time

from faulty import Workshop
from test_acceptance import PROGRAM, ROOT, orchestrator


def files(folder):
    summary = json.loads((folder / "summary.json").read_text())
    # How the points were computed may differ; what came out may not.
    for how in ["run", "isolation", "reproducibility"]:
        summary.pop(how)
    return [(folder / name).read_bytes() for name in ["points.csv", "best.ssv"]] + [summary]


def kill_one(client, processes, folder, held, killed):
    """Kills a Dask worker that is at work once a part has finished a point; then the points that wait go on."""
    while not killed:
        begun = [journal for journal in folder.glob("shard-*/journal.txt")
                 if len(journal.read_text().splitlines()) > 1]
        busy = [address for address, tasks in client.processing().items() if tasks] if begun else []
        if busy:
            os.kill(processes[busy[0]], signal.SIGKILL)
            killed.append(busy[0])
        time.sleep(0.005)
    held.unlink()


def test_a_lost_dask_worker_costs_nothing(tmp_path, monkeypatch):
    # Other tests take `files` from here: they need not wait for Dask.
    monkeypatch.syspath_prepend(ROOT / "examples" / "cluster")
    import dask_shards
    from distributed import Client, LocalCluster
    monkeypatch.setenv("FAULTY_FOLDER", str(tmp_path))
    study, held, killed = tmp_path / "study.toml", tmp_path / "held", []
    Workshop(tmp_path).study(study)
    orchestrator("verify", study, "--output", tmp_path / "single")
    held.touch()
    with LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as cluster, Client(cluster) as client:
        arguments = client, client.run(os.getpid), tmp_path / "dask", held, killed
        thread = threading.Thread(target=kill_one, args=arguments, daemon=True)
        thread.start()
        assert dask_shards.run(client, str(PROGRAM), study, tmp_path / "dask", 6) == 0
        thread.join()
    assert len(killed) == 1
    assert files(tmp_path / "dask") == files(tmp_path / "single")
