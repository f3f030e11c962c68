"""Builds for this machine: with an old glibc as baseline on Linux, else with plain cargo."""

import os
from pathlib import Path

from .common import PACKAGE, ROOT, Failure, run, say, target_dir, venv

# Zig links against any glibc, and takes LLVM's unwinder in place of libgcc_s.
ZIG = ["cargo-zigbuild==0.24.0", "ziglang==0.17.0"]
ZIGBUILD = ["cargo-zigbuild"]
GLIBC = "2.17"
LINUX = "x86_64-unknown-linux-gnu"
PROFILE = "fmu"


def cargo(*arguments, env=None, program=("cargo",)):
    """Builds the FMU's library, and nothing but it: optimised as a whole."""
    run([*program, "rustc", "--profile", PROFILE, "--locked", "--package", PACKAGE, "--lib",
         "--crate-type", "cdylib", *arguments], env=env or {})


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


def linux64(row):
    try:
        environment = zig()
    except Failure as failure:
        say(f"warning: building with plain cargo, as Zig is not to be had: {failure}")
        row.notes.append("plain cargo, without the old glibc baseline")
        return plain(row)
    say(f"building linux64 for glibc {GLIBC}")
    cargo("--target", f"{LINUX}.{GLIBC}", env=environment | flags(LINUX), program=ZIGBUILD)
    return target_dir() / LINUX / PROFILE / "libplain_bearing_stand.so"


def darwin64(row):
    """One file for both processors that Macs have."""
    files = []
    for target in ["x86_64-apple-darwin", "aarch64-apple-darwin"]:
        run(["rustup", "target", "add", target])
        say(f"building {target}")
        cargo("--target", target)
        files.append(target_dir() / target / PROFILE / "libplain_bearing_stand.dylib")
    both = target_dir() / "libplain_bearing_stand.dylib"
    run(["lipo", "-create", "-output", both, *files])
    row.notes.append("x86_64 and arm64")
    return both


def plain(row):
    """With plain cargo; on Windows the C runtime goes into the DLL."""
    say(f"building {row.platform}")
    windows = row.platform == "win64"
    cargo(env={"RUSTFLAGS": "-Ctarget-feature=+crt-static"} if windows else {})
    name = "plain_bearing_stand.dll" if windows else "libplain_bearing_stand.so"
    return target_dir() / PROFILE / name
