"""Real clusters on this machine: OpenSSH, Slurm, HyperQueue. Each is started in a folder, and ended with all that it started."""

import contextlib
import getpass
import os
import shutil
import signal
import socket
import subprocess
import sys
import time
from dataclasses import dataclass, field
from pathlib import Path

from test_acceptance import ROOT

PATH = os.environ["PATH"] + ":/usr/sbin:/sbin"


CALL_BACK = ROOT / "examples" / "cluster" / "call_back.py"
SUBMIT = """
import sys
from hyperqueue import Client, Job
job = Job()
job.program(sys.argv[2:], stdout=None, stderr=None)
Client(sys.argv[1]).submit(job)
"""
SERVE = """
import signal, sys
from hyperqueue.cluster import LocalCluster, WorkerConfig
with LocalCluster(sys.argv[1]) as cluster:
    cluster.start_worker(WorkerConfig(cores=4))
    signal.sigwait([signal.SIGTERM])
"""


class Missing(Exception):
    """Why there can be no such cluster here."""


@dataclass
class Cluster:
    """How a run gets its workers there: its last options, what stands before it, and its environment."""
    options: list
    prefix: list = field(default_factory=list)
    environment: dict = field(default_factory=dict)


def need(*commands, packages=()):
    """Sees that the commands are there; installs Debian packages where it may."""
    def missing():
        return [command for command in commands if not shutil.which(command, path=PATH)]
    if missing() and packages and os.geteuid() == 0 and shutil.which("apt-get"):
        silent = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
        subprocess.run(["apt-get", "update", "-qq"], **silent)
        subprocess.run(["apt-get", "install", "-y", "-qq", "--no-install-recommends", *packages], **silent,
                       env=os.environ | {"DEBIAN_FRONTEND": "noninteractive"})
    if missing():
        raise Missing(f"{', '.join(missing())} is not installed")


def free_ports(count):
    """Ports that nobody listens at."""
    with contextlib.ExitStack() as stack:
        sockets = [stack.enter_context(socket.socket()) for _ in range(count)]
        for one in sockets:
            one.bind(("127.0.0.1", 0))
        return [one.getsockname()[1] for one in sockets]


@contextlib.contextmanager
def daemons(folder):
    """Starts programs that stay in the foreground, and ends them with all that they have started."""
    running = []

    def start(*command, **environment):
        log = (folder / f"{Path(command[0]).name}-{len(running)}.log").open("w")
        running.append(subprocess.Popen([str(word) for word in command], stdout=log, stderr=log, stdin=subprocess.DEVNULL,
                                        start_new_session=True, env=os.environ | {"PATH": PATH} | environment))
    try:
        yield start
    finally:
        for one in reversed(running):
            one.send_signal(signal.SIGTERM)
        for one in running:
            try:
                one.wait(10)
            except subprocess.TimeoutExpired:
                pass
            with contextlib.suppress(ProcessLookupError):
                os.killpg(one.pid, signal.SIGKILL)
            one.wait()


def wait_for(what, ready, seconds=60):
    end = time.monotonic() + seconds
    while not ready():
        if time.monotonic() > end:
            raise Missing(f"{what} did not come within {seconds} s")
        time.sleep(0.1)


@contextlib.contextmanager
def ssh(folder, install=False):
    """An ssh server for this user, and two hosts, both of which are this machine."""
    need("sshd", "ssh", "ssh-keygen", packages=["openssh-server", "openssh-client"] if install else ())
    folder.mkdir()
    [port] = free_ports(1)
    for key in ("host", "user"):
        subprocess.run(["ssh-keygen", "-q", "-t", "ed25519", "-N", "", "-f", folder / key], check=True)
    if os.geteuid() == 0:
        Path("/run/sshd").mkdir(exist_ok=True)
    (folder / "sshd_config").write_text(f"""
Port {port}
ListenAddress 127.0.0.1
HostKey {folder}/host
AuthorizedKeysFile {folder}/user.pub
PidFile none
StrictModes no
UsePAM no
MaxStartups 100
""")
    (folder / "config").write_text(f"""
Host *
  HostName 127.0.0.1
  Port {port}
  User {getpass.getuser()}
  IdentityFile {folder}/user
  IdentitiesOnly yes
  BatchMode yes
  StrictHostKeyChecking no
  UserKnownHostsFile /dev/null
  LogLevel ERROR
""")
    launcher = f"ssh -F {folder}/config {{host}}"
    with daemons(folder) as start:
        start(shutil.which("sshd", path=PATH), "-D", "-e", "-f", folder / "sshd_config")
        here = launcher.format(host="here").split()
        wait_for("sshd", lambda: subprocess.run([*here, "true"], capture_output=True).returncode == 0, 20)
        hosts = folder / "hosts"
        hosts.write_text("node1 2\nnode2 2\n")
        yield Cluster(["--launcher", launcher, "--hosts", hosts, "--ship"])


@contextlib.contextmanager
def slurm(folder, nodes=4, cpus=2):
    """Slurm with some nodes, all on this machine, and an allocation of four tasks."""
    need("slurmd", "slurmctld", "srun", "salloc", "munged", packages=["slurmd", "slurmctld", "slurm-client", "munge"])
    if os.geteuid() != 0:
        raise Missing("slurmd needs root")
    folder.mkdir()
    host = socket.gethostname().split(".")[0]
    control, *ports = free_ports(1 + nodes)
    key = folder / "munge.key"
    key.write_bytes(os.urandom(128))
    key.chmod(0o400)
    conf = folder / "slurm.conf"
    conf.write_text(f"""
ClusterName=test
SlurmctldHost={host}(127.0.0.1)
SlurmctldPort={control}
SlurmUser=root
AuthType=auth/munge
AuthInfo=socket={folder}/munge.socket
CredType=cred/munge
StateSaveLocation={folder}
SlurmdSpoolDir={folder}/%n
SlurmdPidFile={folder}/%n.pid
SlurmctldPidFile={folder}/slurmctld.pid
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
SelectType=select/cons_tres
SelectTypeParameters=CR_Core
SlurmdParameters=config_overrides
ReturnToService=2
MpiDefault=none
MailProg=/bin/true
KillWait=5
""" + "".join(f"NodeName=node{k} NodeHostname={host} NodeAddr=127.0.0.1 Port={port} CPUs={cpus} RealMemory=1000\n"
              for k, port in enumerate(ports)) + "PartitionName=all Nodes=ALL Default=YES MaxTime=INFINITE State=UP\n")
    environment = {"SLURM_CONF": str(conf)}
    with daemons(folder) as start:
        start("munged", "-F", "--force", f"--key-file={key}", f"--socket={folder}/munge.socket", f"--pid-file={folder}/munge.pid",
              f"--log-file={folder}/munge.log", f"--seed-file={folder}/munge.seed")
        wait_for("munged", (folder / "munge.socket").exists, 20)
        start("slurmctld", "-D", "-f", conf)
        for k in range(nodes):
            (folder / f"node{k}").mkdir()
            start("slurmd", "-D", "-N", f"node{k}", "-f", conf)

        def idle():
            told = subprocess.run(["sinfo", "-h", "-N", "-o", "%t"], capture_output=True, text=True, env=os.environ | environment)
            return told.stdout.split() == ["idle"] * nodes
        wait_for("Slurm", idle)
        yield Cluster(["--launcher", "srun -n1 -c1 --exact --mem=0", "--jobs", 4], ["salloc", "-Q", "-n", "4"], environment)


@contextlib.contextmanager
def hyperqueue(folder):
    """The local cluster of HyperQueue, whose tasks call back."""
    folder.mkdir()
    packages, server, submit = folder / "packages", folder / "server", folder / "submit.py"
    pip = [sys.executable, "-m", "pip", "install", "-q", "--target", packages, "hyperqueue==0.27.0", "setuptools<81"]
    if subprocess.run(pip, capture_output=True).returncode:
        raise Missing("hyperqueue cannot be installed")
    submit.write_text(SUBMIT)
    environment = {"PYTHONPATH": str(packages)}
    with daemons(folder) as start:
        start(sys.executable, "-c", SERVE, server, **environment)
        wait_for("HyperQueue", (server / "hq-current").exists)
        # The secrets lie in the working directory.
        launcher = f"env -C {folder} {sys.executable} {CALL_BACK} '{sys.executable} {submit} {server}'"
        yield Cluster(["--launcher", launcher, "--jobs", 4], environment=environment)
