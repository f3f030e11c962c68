"""WebAssembly modules of a few bytes, with the functions of FMI 2.0: each returns a constant, never ends, or traps."""

import base64
import gzip
import re

FUNCTIONS = """Instantiate FreeInstance SetupExperiment EnterInitializationMode ExitInitializationMode DoStep Terminate Reset
GetBooleanStatus SetReal GetReal SetInteger GetInteger SetBoolean GetBoolean""".split()
# Bodies: `loop br 0 end unreachable`, and `unreachable`.
ENDLESS, TRAP = b"\x03\x40\x0c\x00\x0b\x00", b"\x00"


def constant(value):
    return bytes([0x41, value])


def number(value):
    """Unsigned LEB128."""
    last = value < 128
    return bytes([value]) if last else bytes([value & 127 | 128]) + number(value >> 7)


def listed(parts):
    return number(len(parts)) + b"".join(parts)


def text(words):
    return number(len(words)) + words.encode()


def section(kind, content):
    return bytes([kind]) + number(len(content)) + content


def module(bodies=None, without=(), imports=False):
    """A module whose functions take nothing (JavaScript drops arguments) and return 0, but Instantiate 1; or what `bodies` says."""
    bodies = {"Instantiate": constant(1), **(bodies or {})}
    names = [name for name in FUNCTIONS if name not in without]
    exports = [text(f"fmi2{name}") + b"\x00" + number(k + imports) for k, name in enumerate(names)]
    codes = [b"\x00" + bodies.get(name, constant(0)) + b"\x0b" for name in names]
    return b"".join([
        b"\x00asm\x01\x00\x00\x00",
        section(1, listed([b"\x60\x00\x01\x7f"])),
        section(2, listed([text("env") + text("log") + b"\x00\x00"] if imports else [])),
        section(3, listed([b"\x00"] * len(names))),
        section(5, listed([b"\x00\x01"])),
        section(7, listed([*exports, text("memory") + b"\x02\x00"])),
        section(10, listed([number(len(code)) + code for code in codes])),
    ])


def with_module(page, module):
    """The text of a live page with another module."""
    packed = base64.b64encode(gzip.compress(module)).decode()
    changed, count = re.subn(r'"module":"[^"]+"', f'"module":"{packed}"', page)
    assert count == 1
    return changed
