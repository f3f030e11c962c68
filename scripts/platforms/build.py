"""Builds for this machine: with an old glibc as baseline on Linux, else with plain cargo."""

import os

from .common import PACKAGE, Failure, run, say, target_dir, venv

# Zig links against any glibc, and takes LLVM's unwinder in place of libgcc_s.
ZIG = ["cargo-zigbuild==0.24.0", "ziglang==0.17.0"]
ZIGBUILD = ["cargo-zigbuild"]
GLIBC = "2.17"


PROFILE = "fmu"


def cargo(*arguments, env=None, program=("cargo",)):
    """Builds the FMU's library, and nothing but it: optimised as a whole."""
    run([*program, "rustc", "--profile", PROFILE, "--locked", "--package", PACKAGE, "--lib",
         "--crate-type", "cdylib", *arguments], env=env or {})


def zig():
    """The environment in which `cargo zigbuild` works; installs it when it is missing."""
    folder = venv()
    if not any(folder.glob("cargo-zigbuild*")):
        say(f"installing {' and '.join(ZIG)} into .venv")
        run([folder / "python", "-m", "pip", "install", "--quiet", *ZIG])
    return {"PATH": f"{folder}{os.pathsep}{os.environ['PATH']}"}


def linux64(row):
    target = "x86_64-unknown-linux-gnu"
    try:
        environment = zig()
    except Failure as failure:
        say(f"warning: building with plain cargo, as Zig is not to be had: {failure}")
        row.notes.append("plain cargo, without the old glibc baseline")
        return plain(row)
    say(f"building linux64 for glibc {GLIBC}")
    cargo("--target", f"{target}.{GLIBC}", env=environment, program=ZIGBUILD)
    return target_dir() / target / PROFILE / "libplain_bearing_stand.so"


def plain(row):
    say(f"building {row.platform}")
    cargo()
    names = {"win64": "plain_bearing_stand.dll", "darwin64": "libplain_bearing_stand.dylib"}
    return target_dir() / PROFILE / names.get(row.platform, "libplain_bearing_stand.so")
