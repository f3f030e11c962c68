"""Builds for other machines than this one.

Where `rustup target add` can fetch the target's standard library, that is used. Elsewhere the
standard library is built from its source (Debian's package rust-src of exactly the compiler's
version) into a private sysroot under .cache, once for a compiler version and target.
"""

import os
import re
import shutil
from pathlib import Path

from .build import GLIBC, Compiler, flags, old_linux
from .common import CACHE, Failure, run, say
from .debian import install

# Suites that carry newer compilers than the stable release does.
KEYRING = "/usr/share/keyrings/debian-archive-keyring.gpg"
SUITES = ["trixie-backports", "bookworm-backports", "sid"]
BUILD_STD = "std,panic_unwind"


# The linker puts what a binary imports in the order of its files' paths. With paths that are relative to the folder of the
# build, that order is the same in every folder.
LINK_WINDOWS = """#!/bin/sh
folder=. last=
for argument do
    [ "$last" = -o ] && folder=$(dirname "$argument")
    last=$argument
done
for argument do
    shift
    set -- "$@" "${argument#"$folder"/}"
done
cd "$folder" && exec x86_64-w64-mingw32-gcc "$@"
"""


def windows():
    """For Windows on x86-64, with mingw."""
    target = "x86_64-pc-windows-gnu"
    install("gcc-mingw-w64-x86-64-win32", command="x86_64-w64-mingw32-gcc")
    linker = f"CARGO_TARGET_{target.upper().replace('-', '_')}_LINKER"
    # The C runtime and the unwinder go into the binary: every Windows can load it.
    static = "-Ctarget-feature=+crt-static"
    # The linker writes the time into a binary unless it is told not to.
    more = f"{static} -Clink-arg=-Wl,--no-insert-timestamp"
    if not fetched(target):
        more += f" --sysroot={sysroot(target, static, startup_objects)}"
    # The compiler tells from the name what kind of linker it is. Cargo looks at the linker's path, so that has to be the
    # same in every folder too.
    script = CACHE / "linkers/windows-gcc"
    script.parent.mkdir(parents=True, exist_ok=True)
    script.write_text(LINK_WINDOWS, encoding="utf-8")
    script.chmod(0o755)
    environment = {linker: script.name, "PATH": f"{script.parent}{os.pathsep}{os.environ['PATH']}"}
    return Compiler(target, environment | flags(target, more), notes=["mingw"])


def arm_linux():
    """For Linux on 64-bit Arm."""
    target = "aarch64-unknown-linux-gnu"
    more = "" if fetched(target) else f"--sysroot={sysroot(target, '', None)}"
    return old_linux(target, more)


def win64(row):
    compiler = windows()
    say("building win64")
    row.notes += compiler.notes
    return compiler.library()


def aarch64(row):
    compiler = arm_linux()
    say(f"building aarch64-linux for glibc {GLIBC}")
    return compiler.library()


def fetched(target):
    """Whether rustup has the target's standard library, now or after asking for it."""
    root = Path(run(["rustc", "--print", "sysroot"]).strip())
    if (root / "lib/rustlib" / target / "lib").is_dir():
        return True
    try:
        run(["rustup", "target", "add", target])
    except (Failure, FileNotFoundError):
        return False
    return True


def compiler_version():
    return re.search(r"^release: (\S+)$", run(["rustc", "-vV"]), re.MULTILINE)[1]


def library_source(version):
    """The source of the standard library."""
    folder = CACHE / f"rust-src-{version}"
    found = list(folder.glob("usr/src/rustc-*/library"))
    if found:
        return found[0]
    if not shutil.which("apt-get"):
        raise Failure(f"no standard library for the target, and no source of it ({version})")
    say(f"fetching the standard library's source, {version}")
    uri = debian_archive()
    apt = CACHE / "apt"
    (apt / "lists/partial").mkdir(parents=True, exist_ok=True)
    for suite in SUITES:
        (apt / "sources.list").write_text(f"deb [signed-by={KEYRING}] {uri} {suite} main\n")
        options = [f"-oDir::Etc::SourceList={apt}/sources.list", "-oDir::Etc::SourceParts=/dev/null",
                   f"-oDir::State::Lists={apt}/lists", "-oAPT::Get::List-Cleanup=0",
                   f"-oDir::Cache::pkgcache={apt}/p", f"-oDir::Cache::srcpkgcache={apt}/s"]
        try:
            run(["apt-get", *options, "update", "-qq"])
            versions = run(["apt-cache", *options, "madison", "rust-src"])
        except Failure:
            continue
        match = re.search(rf"\|\s*({re.escape(version)}\S*)\s*\|", versions)
        if match is None:
            continue
        run(["apt-get", *options, "download", f"rust-src={match[1]}"], cwd=apt)
        package = next(apt.glob("rust-src_*.deb"))
        run(["dpkg-deb", "-x", package, folder])
        package.unlink()
        return library_source(version)
    raise Failure(f"Debian has no rust-src of the compiler's version {version}")


def debian_archive():
    targets = run(["apt-get", "indextargets", "--format", "$(REPO_URI)"]).split()
    archives = [uri for uri in targets if uri.rstrip("/").endswith("/debian")]
    if not archives:
        raise Failure("apt knows no Debian archive")
    return archives[0]


def sysroot(target, flags, complete):
    """A sysroot with the target's standard library, built when it is missing."""
    version = compiler_version()
    root = CACHE / f"sysroot-{version}-{target}"
    libraries = root / "lib/rustlib" / target / "lib"
    if (root / "ready").exists():
        return root
    library = library_source(version)
    say(f"building the standard library for {target} (once)")
    shutil.rmtree(root, ignore_errors=True)
    libraries.mkdir(parents=True)
    build = CACHE / f"build-std-{target}"
    (build / "src").mkdir(parents=True, exist_ok=True)
    (build / "src/lib.rs").write_text("")
    (build / "Cargo.toml").write_text(
        '[package]\nname = "nothing"\nversion = "0.0.0"\nedition = "2024"\n[workspace]\n')
    prefix = f"CARGO_TARGET_{target.upper().replace('-', '_')}"
    run(["cargo", "build", "--release", "--target", target, f"-Zbuild-std={BUILD_STD}",
         "--target-dir", build / "target"], cwd=build, env={
             "RUSTC_BOOTSTRAP": "1", "__CARGO_TESTS_ONLY_SRC_ROOT": str(library),
             f"{prefix}_RUSTFLAGS": f"-Cembed-bitcode=yes {flags}".strip()})
    for file in (build / "target" / target / "release/deps").glob("*.rlib"):
        if not file.name.startswith("libnothing"):
            shutil.copy(file, libraries)
    if complete:
        complete(library, target, libraries)
    shutil.rmtree(build)
    (root / "ready").touch()
    return root


def startup_objects(library, target, libraries):
    """The objects that the linker puts first and last on Windows."""
    for name in ["rsbegin", "rsend"]:
        run(["rustc", "--target", target, "--emit=obj", "-o", libraries / f"{name}.o",
             library / "rtstartup" / f"{name}.rs"], env={"RUSTC_BOOTSTRAP": "1"})
