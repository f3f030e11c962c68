"""Builds for this machine: with an old glibc as baseline on Linux, else with plain cargo."""

import os
from dataclasses import dataclass, field
from pathlib import Path

from . import gates, unwinder
from .common import PACKAGE, ROOT, Failure, run, say, target_dir, venv

# Zig links against any glibc, and takes LLVM's unwinder in place of libgcc_s.
ZIG = ["cargo-zigbuild==0.24.0", "ziglang==0.17.0"]
ZIGBUILD = ("cargo-zigbuild",)
GLIBC = "2.17"
LINUX = "x86_64-unknown-linux-gnu"
PROFILE = "fmu"
RUSTC = ["rustc", "--profile", PROFILE, "--locked"]
# The FMU's library, and nothing but it.
LIBRARY = ["--package", PACKAGE, "--lib", "--crate-type", "cdylib"]


@dataclass
class Compiler:
    """How cargo builds for a target."""

    target: str
    environment: dict = field(default_factory=dict)
    command: tuple = ("cargo",)
    # The C library's version, where an old one is wanted.
    baseline: str = ""
    notes: list = field(default_factory=list)
    # What the linker is told for the library alone, and for the program alone.
    library_link: tuple = ()
    program_link: tuple = ()

    def __post_init__(self):
        self.named = f"{self.target}.{self.baseline}" if self.baseline else self.target

    def library(self):
        """The FMU's library, optimised as a whole."""
        self.rustc(*LIBRARY, links=self.library_link)
        name = {"windows": "plain_bearing_stand.dll", "darwin": "libplain_bearing_stand.dylib"}
        return self.folder() / name.get(self.system(), "libplain_bearing_stand.so")

    def program(self):
        """The program."""
        self.rustc("--package", "orchestrator", "--bin", "orchestrator", links=self.program_link)
        return self.folder() / ("orchestrator.exe" if self.system() == "windows" else "orchestrator")

    def rustc(self, *what, links):
        links = ["--", *(f"-Clink-arg={link}" for link in links)] if links else []
        run([*self.command, *RUSTC, *what, "--target", self.named, *links], env=self.environment)

    def folder(self):
        return target_dir() / self.target / PROFILE

    def system(self):
        return self.target.split("-")[2]


def flags(target, more=""):
    """The environment that gives the compiler its flags for a target.

    Names of this machine's folders would get into the binary, and other folders would make other bytes.
    """
    folders = {os.environ.get("CARGO_HOME", Path.home() / ".cargo"): "/cargo", ROOT: "/source"}
    # Flags are told apart by spaces, so a folder that has one keeps its name.
    renamed = [f"--remap-path-prefix={folder}={name}" for folder, name in folders.items() if " " not in str(folder)]
    variable = f"CARGO_TARGET_{target.upper().replace('-', '_')}_RUSTFLAGS"
    return {variable: " ".join([*renamed, more]).strip()}


def zig():
    """The environment in which `cargo zigbuild` works; installs it when it is missing."""
    folder = venv()
    if not any(folder.glob("cargo-zigbuild*")):
        say(f"installing {' and '.join(ZIG)} into .venv")
        run([folder / "python", "-m", "pip", "install", "--quiet", *ZIG])
    return {"PATH": f"{folder}{os.pathsep}{os.environ['PATH']}"}


def old_linux(target, more=""):
    """For Linux with an old glibc, by Zig."""
    environment = zig() | flags(target, more)
    stub = unwinder.library(f"{target.replace('-unknown', '')}.{GLIBC}", venv() / "python")
    return Compiler(target, environment, ZIGBUILD, GLIBC, program_link=(stub,))


def linux():
    """For this machine, where it is Linux on x86-64."""
    return old_linux(LINUX)


def linux64(row):
    try:
        compiler = linux()
    except Failure as failure:
        say(f"warning: building with plain cargo, as Zig is not to be had: {failure}")
        row.notes.append(f"plain cargo, {gates.NO_BASELINE}")
        return plain(row)
    say(f"building linux64 for glibc {GLIBC}")
    return compiler.library()


def plain(row):
    """With plain cargo; on Windows the C runtime goes into the DLL."""
    say(f"building {row.platform}")
    windows = row.platform == "win64"
    run(["cargo", *RUSTC, *LIBRARY], env={"RUSTFLAGS": "-Ctarget-feature=+crt-static"} if windows else {})
    name = "plain_bearing_stand.dll" if windows else "libplain_bearing_stand.so"
    return target_dir() / PROFILE / name
