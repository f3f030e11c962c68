"""A launcher for schedulers whose tasks have no standard input.

    orchestrator verify STUDY.toml --launcher "python3 call_back.py 'hq submit'" --jobs 64

The first word submits a task; what follows it is what the task runs. Here that is this file once more, which calls back and then
becomes the worker. A secret in a file of the working directory, which all nodes must share, keeps others out; nothing is
encrypted.
"""

import contextlib
import os
import secrets
import shlex
import signal
import socket
import subprocess
import sys
import tempfile
import threading


def become_worker(host, port, secret, *command):
    """In the task: the connection is the worker's input and output."""
    with open(secret, "rb") as file:
        connection = socket.create_connection((host, int(port)))
        connection.sendall(file.read())
    connection.setsockopt(socket.SOL_SOCKET, socket.SO_KEEPALIVE, 1)
    for stream in (0, 1):
        os.dup2(connection.fileno(), stream)
    os.execvp(command[0], command)


def answered(listener, secret):
    """The first connection that knows the secret."""
    while True:
        connection, _ = listener.accept()
        connection.settimeout(10)
        with contextlib.suppress(OSError):
            told = b""
            while len(told) < len(secret) and (part := connection.recv(len(secret) - len(told))):
                told += part
            if secrets.compare_digest(told, secret):
                connection.settimeout(None)
                return connection
        connection.close()


def pass_orders_on(connection):
    while part := os.read(0, 1 << 16):
        connection.sendall(part)
    connection.shutdown(socket.SHUT_WR)


def launch(submit, *command):
    # The file of the secret is removed, too.
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(1))
    with socket.create_server(("", 0)) as listener, tempfile.NamedTemporaryFile(dir=".", prefix=".call-") as file:
        secret = secrets.token_bytes(32)
        file.write(secret)
        file.flush()
        task = [sys.executable, os.path.abspath(__file__), "--to", socket.getfqdn(), str(listener.getsockname()[1]),
                os.path.abspath(file.name), *command]
        done = subprocess.run([*shlex.split(submit), *task], stdin=subprocess.DEVNULL, stdout=sys.stderr)
        if done.returncode:
            # Why is its last line.
            sys.exit(done.returncode)
        connection = answered(listener, secret)
    connection.setsockopt(socket.SOL_SOCKET, socket.SO_KEEPALIVE, 1)
    threading.Thread(target=pass_orders_on, args=[connection], daemon=True).start()
    while part := connection.recv(1 << 16):
        os.write(1, part)


if __name__ == "__main__":
    words = sys.argv[1:]
    become_worker(*words[1:]) if words[0] == "--to" else launch(*words)
