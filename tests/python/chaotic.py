"""A launcher to hosts on which everything happens: it starts the command as if it were on another machine.

    chaotic.py FOLDER SEED FAULTS HOST COMMAND...

The first FAULTS starts in FOLDER meet one fault each, of a kind and at a moment that the seed, the host and the number of its start
give. `log` tells what happened when.
"""

import fcntl
import json
import os
import random
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

# At the start.
PASSWORD = "asks for a password"
EARLY = ["refuses", PASSWORD, "has a full disk"]
# After some bytes of the worker's answers.
LATE = ["dies", "kills the worker", "reboots", "hangs", "suspends the worker", "stalls", "loses the link", "cuts a frame",
        "alters a bit", "prints in between", "ends at its time limit"]
LONGEST = 2500


class Start:
    """One start on a host."""

    def __init__(self, folder, seed, faults, host):
        self.folder, self.host = Path(folder), host
        with (self.folder / "count").open("a+") as file:
            fcntl.flock(file, fcntl.LOCK_EX)
            file.seek(0)
            before = file.read().split()
            file.write(f"{host}\n")
        number = before.count(host)
        dice = random.Random(f"{seed} {host} {number}")
        # Two starts in a row do not fail: a host that never works is another matter.
        early = number % 2 == 1 and dice.random() < 0.5
        self.fault = None
        if len(before) < int(faults):
            # A launcher that waits for a person waits as long as others work: one host is enough.
            self.fault = dice.choice([fault for fault in EARLY if host == "node0" or fault != PASSWORD] if early else LATE)
        self.moment = dice.randrange(LONGEST)
        self.stall = dice.uniform(0.5, 2)
        self.shift = dice.choice([-1, 1]) * dice.randrange(100_000)
        self.talk = "".join(f"Module {k} loaded\n" for k in range(dice.randrange(4)))
        self.disk = self.folder / f"disk-{host}"
        self.disk.mkdir(exist_ok=True)
        self.log("starts")

    def log(self, what):
        with (self.folder / "log").open("a") as file:
            file.write(json.dumps([time.monotonic(), self.host, what]) + "\n")

    def run(self, command):
        os.write(1, self.talk.encode())
        if self.fault in EARLY:
            self.log(self.fault)
        if self.fault == "refuses":
            sys.exit(f"{self.host}: connection refused")
        if self.fault == PASSWORD:
            os.write(1, b"password: ")
            time.sleep(1000)
        full = self.fault == "has a full disk"
        # Its clock differs, where that can be feigned.
        clock = os.environ.get("CHAOTIC_CLOCK")
        clock = {"LD_PRELOAD": clock, "FAKETIME": f"{self.shift:+d}s", "FAKETIME_DONT_FAKE_MONOTONIC": "1"} if clock else {}
        environment = os.environ | clock | {
            "TMPDIR": os.environ["CHAOTIC_FULL"] if full else str(self.disk), "CHAOTIC_HOST": f"{self.folder}/{self.host}"}
        # What ends this launcher's group does not reach another machine.
        worker = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, env=environment, start_new_session=True)
        threading.Thread(target=self.pass_orders_on, args=[worker.stdin], daemon=True).start()
        passed = 0
        while part := worker.stdout.read1(64):
            passed += len(part)
            if self.fault in LATE and passed > self.moment:
                self.log(self.fault)
                self.strike(worker, part)
                self.fault = None
            os.write(1, part)
        sys.exit(worker.wait())

    def pass_orders_on(self, to):
        with to:
            while part := os.read(0, 1 << 16):
                to.write(part)
                to.flush()

    def strike(self, worker, part):
        fault = self.fault
        if fault == "kills the worker":
            worker.kill()
        elif fault == "reboots":
            os.killpg(worker.pid, signal.SIGKILL)
        elif fault == "ends at its time limit":
            os.killpg(worker.pid, signal.SIGTERM)
            return
        elif fault == "suspends the worker":
            worker.send_signal(signal.SIGSTOP)
            time.sleep(1000)
        elif fault == "hangs":
            time.sleep(1000)
        elif fault == "stalls":
            # Shorter or longer than it is waited for; then all goes on.
            time.sleep(self.stall * float(os.environ["CHAOTIC_PATIENCE"]))
            return
        elif fault == "loses the link":
            # Nobody tells the worker: its input stays open.
            subprocess.Popen(["sleep", "1000"], stdin=worker.stdout, stdout=worker.stdin, stderr=subprocess.DEVNULL,
                             start_new_session=True, env={"CHAOTIC_LINK": str(self.folder)})
        elif fault == "cuts a frame":
            os.write(1, part[:len(part) // 2])
        elif fault == "alters a bit":
            os.write(1, part[:-1] + bytes([part[-1] ^ 1]))
            return
        elif fault == "prints in between":
            os.write(1, b"\nnode is going down for maintenance\n" * 20)
            return
        os._exit(255)


if __name__ == "__main__":
    Start(*sys.argv[1:5]).run(sys.argv[5:])
