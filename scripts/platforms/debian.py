"""Debian packages, installed when what they bring is missing."""

import glob
import os
import shutil

from .common import Failure, run, say


def present(*, command="", file="", root="/"):
    """Whether a command is on the PATH, or a file that matches the pattern lies below the root."""
    return bool(shutil.which(command) if command else glob.glob(file.lstrip("/"), root_dir=root))


def install(package, *, command="", file=""):
    """Installs a package when its command, or its file (a pattern), is missing."""
    if present(command=command, file=file):
        return
    missing = command or file
    if not shutil.which("apt-get"):
        raise Failure(f"{missing} is missing, and there is no apt-get to install {package} with")
    say(f"installing {package} ({missing} is missing)")
    sudo = [] if os.geteuid() == 0 else ["sudo"]
    run([*sudo, "apt-get", "update", "-qq"])
    run([*sudo, "env", "DEBIAN_FRONTEND=noninteractive", "apt-get", "install", "-y", "-qq",
         "--no-install-recommends", package])
