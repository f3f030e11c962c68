"""The gates that every binary passes: exported functions, imported libraries, glibc version."""

import re
import shutil
import struct

from . import macho
from .common import ROOT, Failure, run

GLIBC = (2, 17)
# The note of a binary that was not made for other machines.
NO_BASELINE = "without the old glibc baseline"
LIBRARIES = {
    "elf": {"libc.so.6", "libm.so.6", "libdl.so.2", "libpthread.so.0", "librt.so.1",
            "ld-linux-x86-64.so.2", "ld-linux-aarch64.so.1"},
    # Libraries that every Windows has.
    "dll": re.compile(r"(kernel32|ntdll|msvcrt|ucrtbase|userenv|ws2_32|bcrypt(primitives)?|advapi32"
                      r"|api-ms-win-[\w-]+)\.dll", re.IGNORECASE),
    "mach": re.compile(r"/usr/lib/lib(System\.B|iconv\.2|objc\.A)\.dylib"
                       r"|/System/Library/Frameworks/(Core)?Foundation\.framework/Versions/./(Core)?Foundation"),
}


def platform_of(file):
    """The platform for which a file is a 64-bit shared library, by its head; None if it is none."""
    head = file.read_bytes()[:4096].ljust(4096, b"\0")
    if head[:5] == b"\x7fELF\x02":
        kind, machine = struct.unpack_from("<HH", head, 16)
        return {62: "linux64", 183: "aarch64-linux"}.get(machine) if kind == 3 else None
    if head[:2] == b"MZ":
        start = min(struct.unpack_from("<I", head, 0x3C)[0], 4000)
        machine, traits = struct.unpack_from("<4xH16xH", head, start)
        library = head[start:start + 4] == b"PE\0\0" and traits & 0x2000
        return "win64" if library and machine == 0x8664 else None
    # A macOS library, for one processor or for both.
    if head[:4] == macho.FAT:
        return "darwin64"
    if head[:4] != macho.ONE or struct.unpack_from("<I", head, 12)[0] != 6:
        return None
    return "aarch64-darwin" if struct.unpack_from("<I", head, 4)[0] == 0x0100000C else "darwin64"


def check(row):
    """Raises a Failure where a binary does not pass; notes what it found."""
    if row.platform in ("darwin64", "aarch64-darwin"):
        exports, libraries = mach(row)
    elif row.platform == "win64":
        exports, libraries = dll(row.file)
    else:
        exports, libraries = elf(row)
    if exports is None:
        row.notes.append("gates not checked: no binutils")
        return
    expected = functions()
    if set(exports) != expected:
        extra, missing = set(exports) - expected, expected - set(exports)
        raise Failure(f"exports: too many {sorted(extra)[:5]}, too few {sorted(missing)[:5]}")
    row.notes.append(f"{len(exports)} functions; needs {' '.join(sorted(libraries)) or 'nothing'}")


def functions():
    """The names of the C functions, from the places in the source where they are exported."""
    sources = [ROOT / f"crates/fmu-export/src/{version}/calls.rs" for version in ("fmi2", "fmi3")]
    pattern = re.compile(r"(?:^ +|, |\{ )(fmi[23]\w+)(?=\(| = |, fmi|:)", re.MULTILINE)
    return {name for source in sources for name in pattern.findall(source.read_text())}


def elf(row, more=frozenset()):
    """The names that a file for Linux exports, and the libraries that it needs: none but those of glibc, and ``more``."""
    if not shutil.which("readelf"):
        return None, None
    symbols = run(["readelf", "--wide", "--dyn-syms", row.file])
    exports = [fields[7].split("@")[0] for fields in map(str.split, symbols.splitlines())
               if len(fields) >= 8 and fields[4] in ("GLOBAL", "WEAK") and fields[6].isdigit()]
    libraries = set(re.findall(r"\(NEEDED\).*\[(.*)\]", run(["readelf", "--dynamic", row.file])))
    versions = [tuple(map(int, version.split("."))) for version in
                re.findall(r"@GLIBC_([\d.]+)", symbols)]
    highest = max(versions, default=(0,))
    text = ".".join(map(str, highest))
    baseline = not any(NO_BASELINE in note for note in row.notes)
    if baseline and highest > GLIBC:
        raise Failure(f"needs glibc {text}, more than {'.'.join(map(str, GLIBC))}")
    strange = libraries - LIBRARIES["elf"] - more
    if baseline and strange:
        raise Failure(f"needs {sorted(strange)}, which not every Linux has")
    row.notes.append(f"glibc {text}")
    return exports, libraries


def dll(file):
    if not shutil.which("objdump"):
        return None, None
    text = run(["objdump", "--private-headers", file])
    table = text.partition("[Ordinal/Name Pointer] Table")[2]
    exports = re.findall(r"^\s*\[\s*\d+\]\s+(?:\+base\[\s*\d+\]\s+)?(?:[0-9a-f]+\s+)?(\w+)\s*$", table, re.MULTILINE)
    libraries = set(re.findall(r"DLL Name: (\S+)", text))
    strange = {name for name in libraries if not LIBRARIES["dll"].fullmatch(name)}
    if strange:
        raise Failure(f"needs {sorted(strange)}, which not every Windows has")
    return exports, libraries


def mach(row):
    """A library for macOS: every part has to export the same."""
    found = [macho.read(part) for part in macho.parts(row.file.read_bytes())]
    row.notes.append(", ".join(f"{one['processor']}{' signed' if one['signed'] else ''}" for one in found)
                     + f", macOS {found[0].get('system', '?')}")
    first, *others = [sorted(one["exports"]) for one in found]
    if any(names != first for names in others):
        raise Failure("its parts export different functions")
    libraries = set().union(*(one["libraries"] for one in found))
    strange = {name for name in libraries if not LIBRARIES["mach"].fullmatch(name)}
    if strange:
        raise Failure(f"needs {sorted(strange)}, which not every Mac has")
    # Apple's chips load nothing that is not signed at all.
    if any(one["processor"] == "arm64" and not one["signed"] for one in found):
        raise Failure("the part for arm64 is not signed")
    return first, libraries
