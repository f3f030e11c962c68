"""A launcher with faults: it starts the command behind it, and passes on what that says, up to a fault.

    launched.py FAULTS FOLDER COMMAND...

Of the commands in FOLDER, the first one meets the first of the FAULTS after some bytes, the second one the second, and further ones
none.
"""

import os
import subprocess
import sys
import threading
import time
from pathlib import Path

AFTER = 600


def pass_orders_on(to):
    """Passes the orders on until they end, and then the worker's input."""
    with to:
        while part := os.read(0, 1 << 16):
            to.write(part)
            to.flush()


def number(folder):
    """How many commands were started in the folder before."""
    for k in range(1000):
        try:
            (Path(folder) / f"start-{k}").touch(exist_ok=False)
        except FileExistsError:
            continue
        return k


def main(faults, folder, *command):
    before, faults = number(folder), faults.split(",")
    if before >= len(faults):
        os.execvp(command[0], command)
    fault = faults[before]
    if fault == "refuses":
        print("node7: no such node", file=sys.stderr)
        sys.exit(255)
    child = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE)
    threading.Thread(target=pass_orders_on, args=[child.stdin], daemon=True).start()
    passed = 0
    while part := child.stdout.read1(64):
        passed += len(part)
        if passed > AFTER:
            break
        os.write(1, part)
    if fault == "garbage":
        os.write(1, b"what is this? " * 100)
    elif fault == "cuts":
        os.write(1, part[:len(part) // 2])
    elif fault == "alters":
        os.write(1, part[:-1] + bytes([part[-1] ^ 1]))
    elif fault in ("hangs", "stops"):
        if fault == "stops":
            child.send_signal(19)
        time.sleep(1000)
    if fault == "kills":
        child.kill()
        child.wait()
    os._exit(1)


if __name__ == "__main__":
    main(*sys.argv[1:])
