"""Runs a binary in a small C host: natively, under wine, or under qemu-user."""

import re
import shutil
import sys
import tempfile
from pathlib import Path

from .build import GLIBC, zig
from .common import CACHE, ROOT, Failure, native, run, venv
from .debian import install

SOURCE = Path(__file__).with_name("host.c")
STEPS = 100
# Where Debian puts libraries for 64-bit Arm.
ARM = "/usr/aarch64-linux-gnu"
ARM_LIBRARY = "usr/aarch64-linux-gnu/lib/libgcc_s.so.1"


def run_with(row, wanted=False):
    """The compiler and the runner for a platform's host, or why there is none; where wanted, they are installed."""
    if row.platform == native():
        compiler = shutil.which("cc") or shutil.which("gcc")
        return ([compiler] if compiler else None), [], "no C compiler here"
    if row.platform == "win64":
        if wanted and not wine():
            install("wine64", file="usr/lib/wine/wine64")
        compiler = shutil.which("x86_64-w64-mingw32-gcc")
        return (([compiler] if compiler and wine() else None), [wine()], missing(wine=wine(), mingw=compiler))
    if row.platform == "aarch64-linux":
        if wanted:
            install_arm()
        runner, why = arm()
        return None if why else arm_compiler(), runner, why
    return None, [], "no such machine here"


def qemu():
    return shutil.which("qemu-aarch64") or shutil.which("qemu-aarch64-static")


def install_arm():
    """Installs what runs programs for 64-bit Arm."""
    if not qemu():
        install("qemu-user", command="qemu-aarch64")
    # It brings the C library too.
    install("libgcc-s1-arm64-cross", file=ARM_LIBRARY)


def arm():
    """What runs programs for 64-bit Arm, or why nothing does."""
    libraries = Path("/", ARM_LIBRARY).exists()
    return [qemu(), "-L", ARM], missing(**{"qemu": qemu(), "glibc for Arm (libgcc-s1-arm64-cross)": libraries})


def arm_again():
    """The same for a program that starts itself again."""
    runner, why = arm()
    if why:
        return runner, why
    library = CACHE / "again.so"
    run([*arm_compiler(), "-O1", "-Wall", "-shared", "-fPIC", "-o", library, SOURCE.with_name("again.c"), "-ldl"])
    return [*runner, "-E", f"LD_PRELOAD={library}", "-E", f"QEMU_AGAIN={qemu()}", "-E", f"QEMU_ROOT={ARM}"], ""


def arm_compiler():
    """A C compiler for 64-bit Arm: Zig, which builds the binaries too."""
    zig()
    return [venv() / "python", "-m", "ziglang", "cc", "-target", f"aarch64-linux-gnu.{GLIBC}"]


def missing(**tools):
    """What is not there, of these."""
    return " and ".join(f"no {name}" for name, place in tools.items() if not place)


def wine():
    return shutil.which("wine64") or shutil.which("wine") or wine_of_debian()


def wine_of_debian():
    path = Path("/usr/lib/wine/wine64")
    return str(path) if path.exists() else None


def quiet():
    """The environment in which wine says nothing of its own, and keeps its files apart from the user's."""
    return {"WINEDEBUG": "-all", "WINEPREFIX": str(CACHE / "wine")}


def wine_ready():
    """Makes wine's own files, once, with the library that older versions lack."""
    library = CACHE / "wine/drive_c/windows/system32/bcryptprimitives.dll"
    if library.exists():
        return
    run([wine(), "wineboot", "--init"], env=quiet())
    if library.parent.is_dir() and not library.exists():
        run(["x86_64-w64-mingw32-gcc", "-O1", "-shared", "-o", library, SOURCE.with_name("bcryptprimitives.c"), "-ladvapi32"])


def run_host(row, compiler, runner):
    description = (ROOT / "modelDescription/modelDescription.xml").read_text(encoding="utf-8")
    guid = re.search(r'guid="([^"]*)"', description)[1]
    outputs = [tag[0] for tag in re.findall(
        r'valueReference="(\d+)"([^>]*causality="output")[^>]*>\s*<Real', description)]
    folder = CACHE / "host" / row.platform
    folder.mkdir(parents=True, exist_ok=True)
    program = folder / ("host.exe" if row.platform == "win64" else "host")
    if not program.exists() or program.stat().st_mtime < SOURCE.stat().st_mtime:
        dynamic = ["-ldl"] if row.platform != "win64" and sys.platform == "linux" else []
        run([*compiler, "-O1", "-Wall", "-o", program, SOURCE, *dynamic])
    binary = Path(row.file).resolve()
    resources = ROOT / "modelDescription/resources"
    foreign = row.platform == "win64" and native() != "win64"
    uri = f"file:///Z:{resources.as_posix()}" if foreign else resources.as_uri()
    if foreign:
        wine_ready()
    with tempfile.TemporaryDirectory() as away:
        return run([*runner, program, binary, guid, uri, STEPS, *outputs], cwd=away, timeout=300,
                   env=quiet())


def memcheck(row):
    """Runs this machine's binary under valgrind, which has to find no error and no lost memory."""
    install("valgrind", command="valgrind")
    compiler, _, why = run_with(row)
    if compiler is None:
        raise Failure(why)
    text = run_host(row, compiler, ["valgrind", "--error-exitcode=9", "--leak-check=full",
                                    "--show-leak-kinds=definite,indirect,possible",
                                    "--errors-for-leak-kinds=definite,indirect,possible"])
    return re.search(r"ERROR SUMMARY: (.*?) \(", text)[1]


def step(row, wanted=False):
    """Runs a platform's binary; says what it did, or why it could not. Where wanted, what that takes is installed."""
    compiler, runner, why = run_with(row, wanted)
    if compiler is None:
        return f"not run: {why}"
    text = run_host(row, compiler, runner)
    values = [line for line in text.splitlines() if line.startswith("result ")]
    if len(values) != 1:
        raise Failure(f"the host printed no result:\n{text}")
    row.result = values[0].removeprefix("result ")
    under = f" under {Path(runner[0]).name}" if runner else ""
    return f"run{under}, {STEPS} steps"


def compare(rows):
    """Notes how far the platforms' results are from the first one's."""
    first, *others = [row for row in rows if row.result] or [None]
    for row in others:
        pairs = zip(map(float, row.result.split()), map(float, first.result.split()))
        error = max(abs(ours - theirs) / max(abs(theirs), 1e-300) if theirs else abs(ours)
                    for ours, theirs in pairs)
        row.run += f", within {error:.1e} of {first.platform}"
