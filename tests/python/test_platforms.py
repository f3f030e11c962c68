"""Tests of the packaging scripts' own parts, without building anything."""

import hashlib
import importlib.machinery
import importlib.util
import struct
import sys

import pytest
from test_acceptance import ROOT

sys.path.insert(0, str(ROOT / "scripts"))
from platforms import gates, host, mac, macho  # noqa: E402
from platforms.common import Failure, Row  # noqa: E402

X86, ARM = 0x01000007, 0x0100000C
LIBRARY = 6


def part(processor, names=("_fmi2DoStep",), library="/usr/lib/libSystem.B.dylib", signed=True):
    """A library for macOS with nothing in it but its lists."""
    strings, symbols = b"\0", b""
    for name in names:
        symbols += struct.pack("<IBBHQ", len(strings), 0x0F, 1, 0, 0)
        strings += name.encode() + b"\0"
    # A private name, and one that it takes from elsewhere.
    for name, kind, section in (("_hidden", 0x1F, 1), ("_malloc", 0x01, 0)):
        symbols += struct.pack("<IBBHQ", len(strings), kind, section, 0, 0)
        strings += name.encode() + b"\0"
    name = library.encode().ljust(-(-len(library) // 8) * 8 + 8, b"\0")
    commands = [struct.pack("<IIIIII", 0xC, 24 + len(name), 24, 0, 0, 0) + name]
    if signed:
        commands.append(struct.pack("<IIII", 0x1D, 16, 0, 0))
    at = 32 + sum(map(len, commands)) + 24
    commands.append(struct.pack("<IIIIII", 0x2, 24, at, len(names) + 2, at + len(symbols), len(strings)))
    head = b"\xcf\xfa\xed\xfe" + struct.pack("<IIIIIII", processor, 0, LIBRARY, len(commands), sum(map(len, commands)), 0, 0)
    return head + b"".join(commands) + symbols + strings


def test_parts_for_both_processors_become_one_file(tmp_path, monkeypatch):
    monkeypatch.setattr(mac.shutil, "which", lambda _: None)
    files = []
    for name, content in {"x": part(X86), "a": part(ARM)}.items():
        (tmp_path / name).write_bytes(content)
        files.append(tmp_path / name)
    both = mac.join(files, tmp_path / "both")
    content = both.read_bytes()
    assert macho.parts(content) == [part(X86), part(ARM)]
    places = [struct.unpack_from(">IIIII", content, 8 + 20 * k)[2] for k in range(2)]
    assert all(place % (1 << 14) == 0 for place in places)
    assert gates.platform_of(both) == "darwin64"
    assert [gates.platform_of(file) for file in files] == ["darwin64", "aarch64-darwin"]
    read = macho.read(part(ARM))
    assert read["exports"] == ["fmi2DoStep"] and read["libraries"] == {"/usr/lib/libSystem.B.dylib"} and read["signed"]


@pytest.mark.parametrize("content, says", [
    (part(ARM, library="/opt/lib/libfoo.dylib"), "libfoo"),
    (part(ARM, signed=False), "not signed"),
    (part(ARM, names=("_fmi2DoStep", "_stray")), "exports: too many"),
])
def test_a_library_for_macos_has_to_pass_the_gates(tmp_path, content, says):
    row = Row("aarch64-darwin", file=tmp_path / "library")
    row.file.write_bytes(content)
    with pytest.raises(Failure, match=says):
        gates.check(row)


def test_what_is_missing_is_named():
    assert host.missing(wine=None, mingw="/usr/bin/x") == "no wine"
    assert host.missing(wine=None, mingw=None) == "no wine and no mingw"


@pytest.fixture
def release(monkeypatch):
    loader = importlib.machinery.SourceFileLoader("release", str(ROOT / "scripts/release"))
    release = importlib.util.module_from_spec(importlib.util.spec_from_loader("release", loader))
    monkeypatch.setattr(sys, "dont_write_bytecode", True)
    loader.exec_module(release)
    return release


def test_recipes_name_the_source_package_and_its_checksum(release, tmp_path, monkeypatch):
    monkeypatch.setattr(release, "RELEASE", tmp_path)
    source = tmp_path / "fmu_orchestrator-1.2.3.tar.gz"
    source.write_bytes(b"sources")
    release.recipes("1.2.3", source)
    for name in ("recipe.yaml", "fmu-orchestrator.rb"):
        text = (tmp_path / name).read_text()
        assert hashlib.sha256(b"sources").hexdigest() in text and "1.2.3" in text and "@V" not in text and "@S" not in text


def test_the_notes_of_a_release_are_its_part_of_the_change_log(release, tmp_path, monkeypatch):
    monkeypatch.setattr(release, "ROOT", tmp_path)
    (tmp_path / "CHANGELOG.md").write_text("# Log\n\n## [Unreleased]\n- new\n\n## [0.2.0] - 2026-01-01\n### Added\n- old\n")
    (tmp_path / "Cargo.toml").write_text('[workspace.package]\nversion = "0.2.0"\n')
    assert release.notes("0.2.0", dry=False) == "### Added\n- old\n"
    assert release.notes("0.3.0", dry=True) == "- new\n"
    with pytest.raises(release.Failure, match="no part about 0.3.0"):
        release.notes("0.3.0", dry=False)
    assert release.version("v0.2.0") == "0.2.0"
    with pytest.raises(release.Failure, match="the tag is v0.3.0"):
        release.version("v0.3.0")
