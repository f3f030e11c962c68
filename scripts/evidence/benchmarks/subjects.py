"""The subjects of measurement: the orchestrator, the minimal loop, the direct calls, other importers."""

import os
import re
import shutil
import sys
import zipfile
from dataclasses import dataclass
from pathlib import Path

from measure import Trouble, cost

ROOT = Path(__file__).resolve().parents[3]
HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(ROOT / "scripts"))
from platforms.common import PLATFORMS, native  # noqa: E402

TARGET = ROOT / os.environ.get("CARGO_TARGET_DIR", "target") / "fmu"
ORCHESTRATOR = TARGET / "orchestrator"
WORK = ROOT / "results" / "bench"


@dataclass
class Fmu:
    """An FMU with what a host needs to know to step it."""

    file: Path
    binary: Path
    guid: str
    output: str
    reference: int
    parameter: str
    value: float

    @property
    def resources(self):
        return (self.binary.parent / "resources").as_uri()


def unpack(file, output, parameter, value):
    """An FMU from its archive, unpacked beside the other results."""
    folder = WORK / file.stem
    shutil.rmtree(folder, ignore_errors=True)
    with zipfile.ZipFile(file) as archive:
        archive.extractall(folder)
    xml = (folder / "modelDescription.xml").read_text(encoding="utf-8")
    identifier = re.search(r'modelIdentifier="([^"]*)"', xml)[1]
    tag = re.search(rf'<ScalarVariable[^>]*\bname="{re.escape(output)}"[^>]*>', xml)[0]
    platform = native()
    binary = folder / "binaries" / platform / (identifier + PLATFORMS[platform])
    place = folder / binary.name
    binary.rename(place)
    (folder / "resources").mkdir(exist_ok=True)
    return Fmu(file, place, re.search(r'guid="([^"]*)"', xml)[1], output,
               int(re.search(r'valueReference="(\d+)"', tag)[1]), parameter, value)


def stand():
    """The stand as it is shipped."""
    return unpack(ROOT / "dist" / "PlainBearingStand.fmu", "sensor.loadForce", "load.preload", 48)


def pack(name, xml, library):
    """An FMU of a model description and a library."""
    identifier = re.search(r'modelIdentifier="([^"]*)"', xml)[1]
    file = WORK / f"{name}.fmu"
    with zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("modelDescription.xml", xml)
        archive.write(library, f"binaries/{native()}/{identifier}{PLATFORMS[native()]}")
    return file


def lag():
    """The first-order lag of `examples/lag`: the stand's boundary with hardly any work behind it."""
    file = WORK / "lag.fmu"
    cost([TARGET / "lag", "--output", file])
    return unpack(file, "output", "gain", 2)


def trivial():
    """A first-order lag in a few lines of C: a step costs nothing but what its host spends on it."""
    library = WORK / f"trivial{PLATFORMS[native()]}"
    cost(["cc", "-O2", "-shared", "-fPIC", "-o", library, HERE / "trivial" / "trivial.c"])
    xml = (HERE / "trivial" / "modelDescription.xml").read_text(encoding="utf-8")
    return unpack(pack("trivial", xml, library), "y", "rate", 1)


def touching():
    """The same, but an instance writes to 5 MB of memory."""
    library = WORK / f"touching{PLATFORMS[native()]}"
    cost(["cc", "-O2", "-shared", "-fPIC", "-DTOUCHED=(5<<20)", "-o", library, HERE / "trivial" / "trivial.c"])
    xml = (HERE / "trivial" / "modelDescription.xml").read_text(encoding="utf-8")
    return unpack(pack("touching", xml, library), "y", "rate", 1)


def compile_minimal():
    """Compiles the minimal loop, and the program that forks."""
    cost(["cc", "-O2", "-Wall", "-o", WORK / "minimal", HERE / "minimal.c", "-ldl"])
    cost(["cc", "-O2", "-Wall", "-o", WORK / "fork", HERE / "fork.c"])


def fork():
    """CPU time of a fork of a small process that ends at once."""
    count = 2000
    return cost([WORK / "fork", count]).cpu / count


def minimal(fmu, step, steps, runs, get=False):
    """CPU time of the minimal loop."""
    reference = [fmu.reference] if get else []
    return cost([WORK / "minimal", fmu.binary, fmu.guid, fmu.resources, step, steps, runs, *reference]).cpu


def direct(step, steps, runs):
    """CPU time of the stand called from Rust."""
    return cost([TARGET / "examples" / "direct", step, steps, runs]).cpu


def bound(steps):
    """Time of a film step, and the least time that its arithmetic would need."""
    return cost([TARGET / "examples" / "bound", steps]).text


def importer(kind, fmu, step, steps, runs):
    """CPU seconds a run of another importer, loading left out, and the output's last value."""
    text = cost([sys.executable, HERE / "importer.py", kind, fmu.file, step, steps, runs, fmu.output]).text
    seconds, value = text.split()[-2:]
    return float(seconds) / runs, float(value)


def verify(study, *options, watch=False):
    """A verification; its verdict is not the point here."""
    command = [ORCHESTRATOR, "verify", study, "--output", WORK / "verification", "--force", *options]
    return cost(command, allowed=(0, 1), watch=watch)


def alone(study, points, *options):
    """CPU time of points in the orchestrator's own process, one at a time, without the extra runs that show whether
    values rest: what this is compared with makes none."""
    return verify(study, "--isolation", "none", "--jobs", 1, "--extra-runs", 0, "--points", points, *options).cpu


def constant(fmu, step, steps, statistic):
    """A study whose points are all but the same, at the FMU's start values: one that varies nothing is refused. In place of a
    statistic it may compare a `curve`, a row every ten steps."""
    file = WORK / f"{fmu.file.stem}-{step:g}-{steps}-{statistic}.toml"
    criterion = f'statistic = "{statistic}"\nnominal = 1\ntolerance = 1e9'
    if statistic == "curve":
        curve = file.with_suffix(".csv")
        rows = (f"{10 * step * row!r},{row % 7}\n" for row in range(steps // 10 + 1))
        curve.write_text("time,value\n" + "".join(rows), encoding="utf-8")
        criterion = f'reference = {{ file = "{curve.name}", column = "value" }}\nmetric = "rmse"\ntolerance = 1e9'
    file.write_text(f"""\
fmu = "{fmu.file.as_posix()}"
[simulation]
stop = {step * steps!r}
step = {step!r}
[parameters."{fmu.parameter}"]
distribution = "uniform"
min = {fmu.value}
max = {fmu.value * (1 + 1e-9)!r}
[criteria.output]
variable = "{fmu.output}"
{criterion}
""", encoding="utf-8")
    return file


def table3(name, fixed=""):
    """The shipped study of Table 3 with one communication step and further start values."""
    text, again = re.subn(r'(?m)^step = .*$', "step = 150", shipped_text("paper-table3.toml"))
    text, third = re.subn(r"(?m)^\[fixed\]\s*$", f"[fixed]\n{fixed}", text)
    if (again, third) != (1, 1):
        raise Trouble("studies/paper-table3.toml has no step or [fixed] that could be replaced")
    return written(name, text)


def rig(name, fixed=""):
    """150 s of the shipped study of the rig from the given temperatures, with further start values. The
    means are those that the FMU gives over the last turn."""
    text = shipped_text("rig.toml")
    text, long = re.subn(r"(?ms)^\[simulation\]\n.*?(?=^\[)",
                         "[simulation]\nstop = 150\nstep = 150\n\n", text)
    text, given = re.subn(r"(?ms)^\[fixed\]\n.*?(?=^\[)", f"[fixed]\n{fixed}\n", text)
    if (long, given) != (1, 1):
        raise Trouble("studies/rig.toml has no [simulation] or no [fixed] that could be replaced")
    return written(name, text)


def steady_rig(name):
    """The shipped study of the rig: one turn from the steady start."""
    return written(name, shipped_text("rig.toml"))


def shipped(study):
    """A study as it is shipped, with the FMU of this tree."""
    return written(f"shipped-{Path(study).stem}", shipped_text(study))


def shipped_text(study):
    text = (ROOT / "studies" / study).read_text(encoding="utf-8")
    fmu = (ROOT / "dist" / "PlainBearingStand.fmu").as_posix()
    text, found = re.subn(r'(?m)^fmu = .*$', f'fmu = "{fmu}"', text)
    if found != 1:
        raise Trouble(f"studies/{study} has no fmu that could be replaced")
    return text


def first_study(fmu):
    """The study that `init` writes for an FMU."""
    file = WORK / "foreign.toml"
    file.unlink(missing_ok=True)
    cost([ORCHESTRATOR, "init", fmu, "--output", file])
    return file


def written(name, text):
    file = WORK / f"{name}.toml"
    file.write_text(text, encoding="utf-8")
    return file
