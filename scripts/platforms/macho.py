"""Reads libraries and programs for macOS (Mach-O) as far as the gates need it."""

import struct

FAT = b"\xca\xfe\xba\xbe"
ONE = b"\xcf\xfa\xed\xfe"
PROCESSORS = {0x01000007: "x86_64", 0x0100000C: "arm64"}
SYMBOLS, LOADED, IDENTITY, SIGNATURE, OLDEST = 0x2, 0xC, 0xD, 0x1D, 0x32


def parts(content):
    """The parts of a file, one a processor."""
    if content[:4] != FAT:
        return [content]
    count = struct.unpack_from(">I", content, 4)[0]
    places = [struct.unpack_from(">IIIII", content, 8 + 20 * k) for k in range(count)]
    return [content[at:at + size] for _, _, at, size, _ in places]


def read(part):
    """The processor of a part, the names that it exports, the libraries that it needs, and more."""
    if part[:4] != ONE:
        raise ValueError("no Mach-O of 64 bits")
    found = {"processor": PROCESSORS.get(struct.unpack_from("<I", part, 4)[0], "unknown"),
             "kind": struct.unpack_from("<I", part, 12)[0], "exports": [], "libraries": set(), "signed": False}
    at = 32
    for _ in range(struct.unpack_from("<I", part, 16)[0]):
        command, size = struct.unpack_from("<II", part, at)
        kind = command & 0x7FFFFFFF
        if kind == SYMBOLS:
            found["exports"] = exports(part, *struct.unpack_from("<IIII", part, at + 8))
        elif kind in (LOADED, IDENTITY):
            start = at + struct.unpack_from("<I", part, at + 8)[0]
            name = part[start:part.index(b"\0", start)].decode()
            if kind == LOADED:
                found["libraries"].add(name)
            else:
                found["name"] = name
        elif kind == SIGNATURE:
            found["signed"] = True
        elif kind == OLDEST:
            version = struct.unpack_from("<I", part, at + 12)[0]
            found["system"] = f"{version >> 16}.{version >> 8 & 255}"
        at += size
    return found


def exports(part, table, count, strings, _):
    """The names that are defined for others."""
    names = []
    for k in range(count):
        place, kind, section, flags, _ = struct.unpack_from("<IBBHQ", part, table + 16 * k)
        # External, not private, in a section, and no debugger's entry.
        if kind & 0x01 and not kind & 0x10 and not kind & 0xE0 and kind & 0x0E == 0x0E:
            start = strings + place
            names.append(part[start:part.index(b"\0", start)].decode().removeprefix("_"))
    return names
