"""Code that the packaging steps share."""

import os
import platform as this
import shutil
import subprocess
import sys
from dataclasses import dataclass, field
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent.parent
IDENTIFIER = "PlainBearingStand"
PACKAGE = "plain-bearing-stand"
CACHE = ROOT / ".cache"
# This machine's wheel, and those for other platforms.
WHEELS = ROOT / "dist"
OTHER_WHEELS = WHEELS / "wheels"
HATCHLING = "hatchling==1.33.0"

# FMI 2.0 names the first three; for 64-bit Arm it names none, and importers look where FMI 3 says.
PLATFORMS = {
    "linux64": ".so",
    "win64": ".dll",
    "darwin64": ".dylib",
    "aarch64-linux": ".so",
    "aarch64-darwin": ".dylib",
}

# Their folders in FMI 3.0. The library for darwin64 serves both processors of Macs.
PLATFORMS_3 = {
    "linux64": ["x86_64-linux"],
    "win64": ["x86_64-windows"],
    "darwin64": ["x86_64-darwin", "aarch64-darwin"],
    "aarch64-linux": ["aarch64-linux"],
    "aarch64-darwin": ["aarch64-darwin"],
}


class Failure(Exception):
    """Why a platform is not in the FMU."""


@dataclass
class Row:
    """Whether a platform goes into the FMU, and if not, why."""

    platform: str
    file: Path | None = None
    origin: str = ""
    why: str = ""
    run: str = ""
    notes: list = field(default_factory=list)
    result: str = ""

    def places(self, version):
        """Where the binary goes in an FMU of this version of FMI."""
        folders = [self.platform] if version == 2 else PLATFORMS_3[self.platform]
        return [f"binaries/{folder}/{IDENTIFIER}{PLATFORMS[self.platform]}" for folder in folders]

    def __str__(self):
        if self.file is None:
            return f"{self.platform:14} left out: {self.why}"
        return f"{self.platform:14} {self.origin}; {'; '.join([*self.notes, self.run])}"


def native():
    """This machine's platform."""
    machine = this.machine().lower()
    names = {
        ("linux", "x86_64"): "linux64",
        ("linux", "aarch64"): "aarch64-linux",
        ("win32", "amd64"): "win64",
        ("darwin", "x86_64"): "darwin64",
        ("darwin", "arm64"): "darwin64",
    }
    return names.get((sys.platform, machine))


def say(text):
    print(f"== {text}", file=sys.stderr, flush=True)


def run(command, **options):
    """Runs a command that has to succeed; its output is shown when it does not."""
    environment = {**os.environ, **options.pop("env", {})}
    done = subprocess.run([str(part) for part in command], env=environment, text=True,
                          cwd=options.pop("cwd", ROOT), stdout=subprocess.PIPE,
                          stderr=options.pop("stderr", subprocess.STDOUT), **options)
    if done.returncode != 0:
        shown = " ".join(str(part) for part in command)
        raise Failure(f"`{shown}` failed with {done.returncode}:\n{done.stdout}")
    return done.stdout


def need_cargo():
    if not shutil.which("cargo"):
        sys.exit(f"{Path(sys.argv[0]).name}: cargo is missing: install Rust first (rustup)")


def target_dir():
    """The folder in which cargo builds, wherever the user has put it."""
    return ROOT / os.environ.get("CARGO_TARGET_DIR", "target")


def venv():
    """The folder of the project's Python environment's programs; made when it is missing."""
    folder = ROOT / ".venv" / ("Scripts" if os.name == "nt" else "bin")
    if not folder.exists():
        say("making .venv")
        run([sys.executable, "-m", "venv", ROOT / ".venv"])
    return folder


def hatchling(kind, folder, **environment):
    """The Python package as a file, "wheel" or "sdist", in a folder."""
    tools = venv()
    if not any(tools.glob("hatchling*")):
        say(f"installing {HATCHLING} into .venv")
        run([tools / "python", "-m", "pip", "install", "--quiet", HATCHLING])
    said = run([tools / "python", "-m", "hatchling", "build", "--target", kind, "--directory", folder], cwd=ROOT / "python",
               env=environment)
    return Path(said.split()[-1])
