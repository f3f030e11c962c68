"""Builds for macOS: with Apple's tools on a Mac, elsewhere with Rust's own linker and without Apple's files.

The linker has to know which names the system's libraries have. Zig brings that list for libSystem. The few others that
the program needs are written here, with the names that it uses.
"""

import re
import shutil
import struct
import sys
from pathlib import Path

from .build import Compiler, flags, zig
from .common import CACHE, ROOT, Failure, run, say, target_dir
from .cross import fetched

TARGETS = ("x86_64-apple-darwin", "aarch64-apple-darwin")
# The oldest system on both processors.
OLDEST = "11.0"
# Stubs besides libSystem: where the library is on a Mac, and the names in it that are used.
STUBS = {
    "usr/lib/libiconv": ("/usr/lib/libiconv.2.dylib", ["_iconv", "_iconv_open", "_iconv_close"]),
    "usr/lib/libobjc": ("/usr/lib/libobjc.A.dylib", [
        "_objc_msgSend", "_objc_retain", "_objc_release", "_objc_autorelease", "_objc_getClass", "_sel_registerName",
        "_objc_autoreleasePoolPush", "_objc_autoreleasePoolPop", "_objc_retainAutoreleasedReturnValue",
        "_objc_alloc", "_objc_allocWithZone", "_objc_autoreleaseReturnValue", "_objc_opt_class", "_objc_opt_self"]),
    **{f"System/Library/Frameworks/{name}.framework/{name}": (
        f"/System/Library/Frameworks/{name}.framework/Versions/{version}/{name}", [])
       for name, version in {"CoreFoundation": "A", "Foundation": "C"}.items()},
}


def compiler(target):
    """How cargo builds for one of the processors that Macs have."""
    if not fetched(target):
        raise Failure(f"no standard library for {target} (rustup target add {target})")
    environment = {"MACOSX_DEPLOYMENT_TARGET": OLDEST}
    if sys.platform == "darwin":
        return Compiler(target, environment | flags(target))
    environment |= zig()
    name = target.replace("-", "_")
    more = f"-Clinker={linker()} -Clinker-flavor=ld64.lld"
    processor = target.split("-")[0]
    script = CACHE / f"cc-{processor}"
    CACHE.mkdir(exist_ok=True)
    # Crates with C code name the target as Apple does, which Zig does not know.
    script.write_text(f"""#!/bin/sh
for argument do shift; case $argument in --target=*) ;; *) set -- "$@" "$argument" ;; esac; done
exec "{ROOT}/.venv/bin/python" -m ziglang cc -target {processor}-macos "$@"
""")
    script.chmod(0o755)
    # The linker numbers a binary by its contents. Names of the build's folders are in these unless it leaves out what is
    # for debuggers (-S) and local names (-x), which the compiler takes out later.
    stripped = ("-S", "-x")
    # The name under which hosts find the library: without it, that would be the path of the build.
    link = ("-install_name", "@rpath/libplain_bearing_stand.dylib")
    return Compiler(target, environment | flags(target, more) | {"SDKROOT": str(sdk()), f"CC_{name}": str(script)},
                    library_link=(*stripped, *link), program_link=stripped)


def linker():
    root = Path(run(["rustc", "--print", "sysroot"]).strip())
    found = sorted(root.glob("lib/rustlib/*/bin/rust-lld"))
    if not found:
        raise Failure("the Rust installation has no linker of its own (rust-lld)")
    return found[0]


def sdk():
    """A folder with what the linker has to know of the system's libraries."""
    folder = CACHE / "macos"
    libraries = folder / "usr/lib"
    libraries.mkdir(parents=True, exist_ok=True)
    system = next(ROOT.glob(".venv/lib/python3*/site-packages/ziglang/lib/libc/darwin/libSystem.tbd"), None)
    if system is None:
        raise Failure("Zig has no list of the names in libSystem")
    # The linker does not know the newest kind of processor that the list names.
    text = re.sub(r"arm64e\.x1-\w+,?\s*", "", system.read_text(encoding="utf-8"))
    for name in ("libSystem", "libc", "libm"):
        (libraries / f"{name}.tbd").write_text(text, encoding="utf-8")
    for place, (path, names) in STUBS.items():
        file = folder / f"{place}.tbd"
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(stub(path, names), encoding="utf-8")
    return folder


def stub(path, names):
    """A library's list of names (text-based stub, version 4)."""
    targets = "[ x86_64-macos, arm64-macos ]"
    listed = ", ".join(names)
    exports = f"exports:\n  - targets: {targets}\n    symbols: [ {listed} ]\n" if names else ""
    return f"--- !tapi-tbd\ntbd-version: 4\ntargets: {targets}\ninstall-name: '{path}'\n{exports}...\n"


def darwin64(row):
    """One file for both processors that Macs have."""
    files = []
    for target in TARGETS:
        say(f"building {target}")
        files.append(compiler(target).library())
    row.notes.append("x86_64 and arm64")
    if sys.platform != "darwin":
        row.notes.append("linked without Apple's files")
    return join(files, target_dir() / "libplain_bearing_stand.dylib")


def arm(row):
    """The part for Arm alone, under the name that FMI 3 gives to that platform."""
    say(f"building {TARGETS[1]}")
    row.notes.append("arm64")
    return compiler(TARGETS[1]).library()


def join(files, both):
    """Puts the binaries for several processors into one file."""
    if shutil.which("lipo"):
        run(["lipo", "-create", "-output", both, *files])
        return both
    parts = [file.read_bytes() for file in files]
    # Each part begins at a page of 16 KiB, as Arm needs it.
    page = 1 << 14
    head = struct.pack(">II", 0xCAFEBABE, len(parts))
    whole, at = b"", page
    for part in parts:
        processor, kind = struct.unpack_from("<II", part, 4)
        head += struct.pack(">IIIII", processor, kind, at, len(part), 14)
        whole += part + b"\0" * (-len(part) % page)
        at = page + len(whole)
    both.write_bytes(head.ljust(page, b"\0") + whole)
    return both
