"""A study as shards on a Dask cluster.

    python dask_shards.py STUDY.toml OUTPUT --shards 8 [--scheduler tcp://HOST:8786 | --workers 3]

Every task computes one part of the points with `orchestrator verify --shard I/N --resume`, so a part whose Dask
worker was lost goes on where it was, on another worker. OUTPUT must lie on a disk that all workers share.
An empty Dask task costs about 3 ms: let a part hold thousands of points. Needs `pip install distributed`.
"""

import argparse
import shutil
import subprocess
from pathlib import Path

from distributed import Client, LocalCluster, as_completed

# A part must not outlive the worker that looks after it: its folder would stay locked.
TIED = ["setpriv", "--pdeathsig", "KILL"] if shutil.which("setpriv") else []


def part(program, study, output, number, of):
    """Computes one part; returns its folder."""
    folder = Path(output) / f"shard-{number}"
    command = [program, "verify", study, "--shard", f"{number}/{of}", "--output", folder, "--jobs", 1, "--resume"]
    done = subprocess.run([*TIED, *map(str, command)], capture_output=True, text=True)
    if done.returncode:
        raise RuntimeError(f"part {number}: {done.stderr.strip()}")
    return str(folder)


def run(client, program, study, output, shards):
    """Computes all parts on a cluster and joins them; returns the exit code: 0 when the model is verified."""
    study, output = Path(study).resolve(), Path(output).resolve()
    tasks = [client.submit(part, program, study, output, number, shards, retries=3, pure=False)
             for number in range(1, shards + 1)]
    folders = [task.result() for task in as_completed(tasks)]
    return subprocess.run([program, "merge", *folders, "--output", output]).returncode


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("study")
    parser.add_argument("output")
    parser.add_argument("--shards", type=int, default=8)
    parser.add_argument("--scheduler", help="the address of a cluster; one on this machine otherwise")
    parser.add_argument("--workers", type=int, help="of the cluster on this machine")
    parser.add_argument("--program", default="orchestrator")
    options = parser.parse_args()
    cluster = options.scheduler or LocalCluster(n_workers=options.workers, threads_per_worker=1,
                                                dashboard_address=None)
    with Client(cluster) as client:
        return run(client, options.program, options.study, options.output, options.shards)


if __name__ == "__main__":
    raise SystemExit(main())
