"""Recordings as plain tables that ``orchestrator`` reads: one csv file for each rate, one row of names ``name [unit]``, numbers.

    python -m fmu_orchestrator convert FILE [--output FOLDER] [OPTIONS]

Each library is imported only when a file needs it; ``pip install "fmu-orchestrator[recordings]"`` installs all of them. They run in a
process with limits: a file that is damaged costs a line, not the machine.
"""

import argparse
import csv
import datetime
import decimal
import filecmp
import importlib
import json
import os
import signal
import subprocess
import sys
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any, NoReturn

from . import _rows
from ._errors import OrchestratorError


@dataclass
class Group:
    """Channels that share their times."""

    name: str
    time: Any  # seconds; None: the file has no times, or one of the channels is the time
    channels: list[tuple[str, str, Any]] = field(default_factory=list)  # name, unit, values

    def shift(self, late: float) -> None:
        """Adds to all that counts from the start of the file."""
        def later(times: Iterable[float | None]) -> list[float | None]:
            return [None if time is None else round(time + late, 9) for time in times]

        self.time = None if self.time is None else later(self.time)
        self.channels = [(name, unit, later(values) if isinstance(values, Clock) else values) for name, unit, values in self.channels]


class Clock(list[Any]):
    """A channel of moments: seconds since the start of the file."""


@dataclass
class Contents:
    """What a file holds."""

    groups: list[Group] = field(default_factory=list)
    left_out: list[str] = field(default_factory=list)  # names of what is no series of numbers
    invalid: Counter[str] = field(default_factory=Counter)  # samples that the file calls invalid, by channels
    zero: int | None = None  # the moment of time 0, in nanoseconds since 1970
    start: Any = None  # the same as a time stamp
    told: list[str] = field(default_factory=list)  # how the file was understood

    def clock(self, ticks: Sequence[int | None], zone: datetime.tzinfo | None) -> Clock:
        """Moments in nanoseconds since 1970 as seconds since the first of the file."""
        first = next((tick for tick in ticks if tick is not None), None)
        if self.zero is None and first is not None:
            self.zero = first
            self.start = datetime.datetime(1970, 1, 1, tzinfo=zone) + datetime.timedelta(microseconds=first // 1000)
        return Clock(None if tick is None else (tick - (self.zero or 0)) / 1e9 for tick in ticks)


def convert(path: str | Path, folder: str | Path | None = None, zero: str | None = None, **said: Any) -> list[Path]:
    """Writes a csv file for each rate of a recording, and gives their paths; how it was understood is printed.

    ``said`` are the fields of ``_rows.Options``; ``zero`` is the time stamp at time 0 (otherwise the file's first).
    """
    path = Path(path)
    if not path.is_file():
        raise OrchestratorError(f"{path}: no such file")
    into = Path(folder) if folder is not None else path.parent
    task = {"path": str(path.absolute()), "shown": str(path), "folder": str(into), "zero": zero, "said": asdict(_rows.Options(**said))}
    size = path.stat().st_size
    allowed = SECONDS + size // SPEED
    paths = os.pathsep.join([str(Path(__file__).parent.parent), *filter(None, [os.environ.get("PYTHONPATH")])])
    # One thread: each thread of a library of linear algebra reserves memory of its own.
    surroundings = {**os.environ, "PYTHONPATH": paths, "PYTHONIOENCODING": "utf-8", **dict.fromkeys(THREADS, "1")}
    command = [sys.executable, "-m", "fmu_orchestrator", "convert", "--one", json.dumps({**task, "memory": MEMORY + 40 * size, "seconds": allowed})]
    try:
        # A busy machine takes longer for the same work.
        done = subprocess.run(command, env=surroundings, capture_output=True, timeout=10 * allowed, encoding="utf-8", errors="replace", check=False)
    except subprocess.TimeoutExpired:
        done = None
    if done is None or done.returncode == -getattr(signal, "SIGXCPU", 0) != 0:
        raise OrchestratorError(f"{path}: not read within {allowed} s; it is damaged, or no {path.suffix}; export it as csv")
    told = done.stderr.splitlines()
    if done.returncode == 0:
        *lines, last = done.stdout.splitlines()
        notes = [line for line in told if line.startswith("note: ")]
        # What a library logs of a file that is cut off.
        notes += [f"note: its library says: {line}" for line in told if line not in notes][:1]
        print("\n".join(lines))
        print("".join(f"{line}\n" for line in notes), end="", file=sys.stderr)
        return [Path(name) for name in json.loads(last)]
    if done.returncode == 2 and (errors := [line.removeprefix("error: ") for line in told if line.startswith("error: ")]):
        raise OrchestratorError(errors[-1])
    why = "the memory that is allowed is not enough" if any("MemoryError" in line for line in told) else "its library crashed"
    raise OrchestratorError(f"{path}: {why}; it is damaged, or no {path.suffix}; export it as csv")


# A file may take so many seconds of the processor, and one more for so many bytes; so many bytes of memory, and 40 times its own.
SECONDS, SPEED, MEMORY = 30, 500_000, 450 << 20
THREADS = ["OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS", "ARROW_NUM_THREADS"]


def _one(task: Mapping[str, Any]) -> None:
    """What the process with limits does."""
    try:
        import resource

        resource.setrlimit(resource.RLIMIT_DATA, (task["memory"], task["memory"]))
        resource.setrlimit(resource.RLIMIT_CPU, (task["seconds"], task["seconds"] + 1))
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    except (ImportError, ValueError, OSError):
        pass  # Windows has no such limits; the time's limit stays.
    paths = convert_here(Path(task["path"]), Path(task["folder"]), task["zero"], _rows.Options(**task["said"]), task["shown"])
    print(json.dumps([str(path) for path in paths]))


def convert_here(path: Path, folder: Path, zero: str | None = None, options: _rows.Options | None = None, name: str | None = None) -> list[Path]:
    """The same in this process."""
    name = name or str(path)
    options = options or _rows.Options()
    reader = _reader(path)
    try:
        contents = reader(path, options)
    except OrchestratorError as error:
        raise OrchestratorError(f"{name}: {error}") from error
    except MemoryError:
        raise OrchestratorError(f"{name}: the memory that is allowed is not enough; it is damaged, or no {path.suffix}; export it as csv") from None
    except Exception as error:
        # The libraries raise whatever they like at files that are damaged or of a version that they do not know.
        reason = " ".join(str(error).split())[:200] or type(error).__name__
        raise OrchestratorError(f"{name}: not readable as {path.suffix}: {reason}; export it as csv") from error
    groups = [group for group in contents.groups if group.channels]
    if reader not in (_text, _xlsx):
        _say_units(groups, options, name)
    for line in contents.told:
        print(f"{name}: {line}")
    if contents.left_out:
        shown = ", ".join(contents.left_out[:5]) + (" ..." if len(contents.left_out) > 5 else "")
        print(f"note: {len(contents.left_out)} left out, as they are no series of numbers: {shown}", file=sys.stderr)
    for channel, count in contents.invalid.items():
        print(f"note: {channel}: {count} samples are invalid, as the file says, and become empty cells", file=sys.stderr)
    start = contents.start
    if zero is not None:
        begin = _stamp(zero)
        if start is None:
            raise OrchestratorError(f"{name}: it has no time stamps, so --zero says nothing; use time = {{ offset = ... }} in the settings")
        if (start.tzinfo is None) != (begin.tzinfo is None):
            raise OrchestratorError(
                f"{name}: its stamps have {'no' if start.tzinfo is None else 'a'} zone, unlike --zero {zero}; its time 0 is {start.isoformat()}: say --zero in "
                "the same way")
        for group in groups:
            group.shift((start - begin).total_seconds())
        start = begin
    if start is not None:
        print(f"{name}: its time 0 is {start.isoformat()}; other files of the run: --zero {start.isoformat()}")
    if not groups:
        frames = any("DataFrame" in left for left in contents.left_out)
        remedy = "decode the frames of its bus by their DBC file first, as asammdf does" if frames else "export the recording as csv"
        raise OrchestratorError(f"{name}: it holds no series of numbers; {remedy}")
    folder.mkdir(parents=True, exist_ok=True)
    return [_write(group, folder / f"{path.stem}{f'-{k}' if len(groups) > 1 else ''}.csv", path) for k, group in enumerate(groups, 1)]


def _say_units(groups: Sequence[Group], options: _rows.Options, name: str) -> None:
    """Gives channels the units that the user says; the other options are about cells of text."""
    stray = next((key for key, value in asdict(options).items() if value is not None and key != "units"), None)
    if stray:
        raise OrchestratorError(f"{name}: --{stray} is about text and spreadsheets, and says nothing here; leave it out")
    known = [channel for group in groups for channel, _, _ in group.channels]
    for channel in set(options.units).difference(known):
        raise OrchestratorError(f"{name}: --unit {channel}: there is no such channel; it has {', '.join(known[:20])}")
    for group in groups:
        group.channels = [(channel, options.units.get(channel, unit), values) for channel, unit, values in group.channels]


def _stamp(text: str) -> datetime.datetime:
    """A time stamp; one with a zone in that of Greenwich."""
    try:
        at = datetime.datetime.fromisoformat(text)
    except ValueError:
        raise OrchestratorError(f"--zero {text}: no time stamp such as 2026-11-22T13:15:07") from None
    return at if at.tzinfo is None else at.astimezone(datetime.UTC)


def _reader(path: Path) -> "Reader":
    with path.open("rb") as file:
        begin = file.read(8)
    return next((known for mark, known in MARKS.items() if begin.startswith(mark)), READERS.get(path.suffix.lower(), _text))


def is_text(path: Path) -> bool:
    """Whether the program reads a table as it is, or says what it lacks."""
    return not path.is_file() or _reader(path) in (_text, _parquet)


def _write(group: Group, path: Path, source: Path) -> Path:
    channels = [*([("time", "s", group.time)] if group.time is not None else []), *group.channels]
    names: list[str] = []
    for name, unit, _ in channels:
        unit = "" if (unit := _rows.unit(unit)) == "-" else f" [{unit}]" if unit else ""
        # The same name may come again within a group.
        again = names.count(name + unit)
        names.append(name + (f" ({again + 1})" if again else "") + unit)
    if path.absolute() == source.absolute():
        path = path.with_name(f"{path.stem}-plain.csv")
    part = path.with_suffix(".csv.part")
    with part.open("w", newline="", encoding="utf-8") as file:
        table = csv.writer(file)
        table.writerow(_cells(names))
        table.writerows(zip(*(_cells(values) for _, _, values in channels), strict=True))
    if path.exists() and not filecmp.cmp(part, path, shallow=False):
        part.unlink()
        # Two loggers of a run often write files of one name.
        raise OrchestratorError(f"{path} is there already and holds something else; choose another folder with --output")
    part.replace(path)
    timed = any(unit in _rows.OF_TIME or not unit and _rows.is_time_name(name.rpartition("/")[2]) for name, unit in map(_rows.split_name, names))
    timeless = "" if timed else "; without a column of times: time = { rate = ... }"
    print(f"{path}: {len(channels[0][2])} rows of {', '.join(names[:6])}{' ...' if len(names) > 6 else ''}{timeless}")
    return path


def _text(path: Path, options: _rows.Options) -> Contents:
    columns = _rows.read(path, options)
    return Contents([Group(path.stem, columns.time, columns.channels)], told=columns.told, start=columns.start)


def _cells(column: Any) -> Iterator[object]:
    for value in column.tolist() if hasattr(column, "tolist") else column:
        # A line that begins with # would be a comment.
        yield "" if value is None or value != value else f" {value}" if isinstance(value, str) and value[:1] == "#" else value


def _library(name: str) -> Any:
    try:
        return importlib.import_module(name)
    except ImportError:
        _rows.refuse(f'{name} is missing; pip install "fmu-orchestrator[{EXTRAS[name.partition(".")[0]]}]"')


def _is_series(values: Any) -> bool:
    return getattr(values, "ndim", 0) == 1 and len(values) > 1 and getattr(values, "dtype", None) is not None and values.dtype.kind in "iufb"


# What a master of MDF is that is no time.
AXES = {2: "an angle", 3: "a distance", 4: "an index"}


def _mdf(path: Path, _: object = None) -> Contents:
    contents = Contents()
    with _library("asammdf").MDF(path) as mdf:
        contents.start = _stamp(mdf.header.start_time.isoformat())
        for number in mdf.virtual_groups:
            groups: list[Group] = []
            included = mdf.included_channels(number)[number]
            places = [(None, index, channel) for index, channels in included.items() for channel in channels]
            for signal in mdf.select(places, raw=False, copy_master=True):
                if not _is_series(signal.samples) or len(signal.samples) != len(signal.timestamps):
                    contents.left_out.append(signal.name)
                    continue
                if not groups:
                    # `select` gives as many samples as the file states, whatever the memory held where the data are lost.
                    there = len(mdf.get(group=signal.group_index, index=signal.channel_index, samples_only=True, ignore_invalidation_bits=True)[0])
                    if there < len(signal.samples):
                        _rows.refuse(f"it states {len(signal.samples)} samples of `{signal.name}` and holds {there}: it is cut off or damaged; export it anew, or as csv")
                values = _valid(signal, contents)
                # Channels of one group have one clock, but for those that a file records without their invalid samples.
                is_new = not groups or len(groups[0].channels[0][2]) != len(values)
                if is_new:
                    groups.append(Group(signal.name, signal.timestamps))
                    master, kind = signal.master_metadata or ("", 1)
                    if kind in AXES:
                        unit = mdf.groups[number].channels[mdf.masters_db[number]].unit
                        groups[-1] = Group(signal.name, None, [(master, unit, signal.timestamps)])
                        contents.told.append(f"`{master}` is {AXES[kind]} and no time: it is a channel beside `{signal.name}`")
                groups[-1 if is_new else 0].channels.append((signal.name, signal.unit, values))
            contents.groups.extend(groups)
    return contents


def _valid(signal: Any, contents: Contents) -> Any:
    """The samples; ``None`` in place of those that the file calls invalid."""
    bits = signal.invalidation_bits
    if bits is None or not bits.any():
        return signal.samples
    contents.invalid[signal.name] += int(bits.sum())
    return [None if invalid else value for value, invalid in zip(signal.samples.tolist(), bits.tolist(), strict=True)]


def _tdms(path: Path, _: object = None) -> Contents:
    contents, file, numpy = Contents(), _library("nptdms").TdmsFile.read(path), importlib.import_module("numpy")

    def clock(moments: Any) -> Clock:
        known = numpy.asarray(moments, "datetime64[us]")
        ticks = zip(known.astype("int64").tolist(), numpy.isnat(known).tolist(), strict=True)
        return contents.clock([None if is_none else 1000 * tick for tick, is_none in ticks], datetime.UTC)

    # Times count from the first start, or from the first stamp.
    starts = [c.properties["wf_start_time"] for g in file.groups() for c in g.channels() if "wf_start_time" in c.properties]
    clock(sorted(starts)[:1])
    for part in file.groups():
        rates: dict[tuple[object, ...], Group] = {}
        for channel in part.channels():
            values, known = channel[:], channel.properties
            unit = str(known.get("unit_string", known.get("NI_UnitDescription", "")))
            if getattr(getattr(values, "dtype", None), "kind", "") == "M" and len(values) > 1:
                values, unit = clock(values), "s"
            elif not _is_series(values):
                contents.left_out.append(f"{part.name}/{channel.name}")
                continue
            step, start, offset = (known.get(f"wf_{key}") for key in ("increment", "start_time", "start_offset"))
            key = (len(values), step, start, offset)
            if key not in rates:
                begin = float(offset or 0.0) + (clock([start])[0] if start is not None else 0.0)
                rates[key] = Group(part.name, [begin + k * step for k in range(len(values))] if step else None)
            rates[key].channels.append((channel.name, unit, values))
        contents.groups.extend(rates.values())
    return contents


def _by_length(items: Iterable[tuple[str, str, Any]], contents: Contents) -> Contents:
    """Series of the same length in the same folder belong together; tables are taken apart into their columns."""
    groups: dict[tuple[str, int], Group] = {}
    for name, unit, values in items:
        if getattr(values, "ndim", 0) == 2 and 1 in values.shape:
            values = values.ravel()
        table = getattr(values, "ndim", 0) == 2 and values.dtype.kind in "iufb"
        # A channel has more samples than a table has channels.
        columns = (values if values.shape[0] >= values.shape[1] else values.T).T if table else [values]
        parts = [(f"{name}/{k}" if len(columns) > 1 else name, column) for k, column in enumerate(columns, 1)]
        for label, column in parts:
            if not _is_series(column):
                contents.left_out.append(label)
                continue
            key = (label.rpartition("/")[0] if not table else name.rpartition("/")[0], len(column))
            group = groups.setdefault(key, Group(key[0], None))
            group.channels.append((label, unit, column))
    for group in groups.values():
        # The time comes first.
        group.channels.sort(key=lambda channel: not _rows.is_time_name(channel[0].rpartition("/")[2]))
    contents.groups.extend(groups.values())
    return contents


def _hdf5(path: Path, _: object = None) -> Contents:
    contents = Contents()
    h5py = _library("h5py")
    items: list[tuple[str, str, Any]] = []

    def visit(name: str, node: Any) -> None:
        if "pandas_type" in node.attrs:
            _rows.refuse("pandas keeps names and times apart from the numbers; pandas.read_hdf(FILE).to_parquet(...) joins them")
        if not isinstance(node, h5py.Dataset) or node.shape is None:
            return
        if node.external or node.is_virtual:
            # What another file holds is none of this recording.
            contents.left_out.append(f"{name} (in another file)")
            return
        unit = next((node.attrs[key] for key in ("unit", "units", "Unit", "Units") if key in node.attrs), "")
        unit = unit.decode("utf-8", "replace") if isinstance(unit, bytes) else str(unit)
        if node.dtype.names:
            items.extend((f"{name}/{part}", unit, node[part]) for part in node.dtype.names)
        elif h5py.check_ref_dtype(node.dtype) is None and not (node.ndim > 2 or node.dtype.kind not in "iufb"):
            items.append((name, unit, _unpacked(name, node, contents)))
        else:
            contents.left_out.append(name)

    with h5py.File(path) as file:
        file.visititems(visit)
    return _by_length(items, contents)


def _unpacked(name: str, node: Any, contents: Contents) -> Any:
    """The numbers of a data set, which NetCDF may pack: https://cfconventions.org, chapter 8."""
    def stated(*keys: str) -> dict[str, float]:
        known = {key: node.attrs[key] for key in keys if key in node.attrs}
        return {key: float(value.item()) for key, value in known.items() if getattr(value, "size", 0) == 1 and value.dtype.kind in "iuf"}

    values = node[()]
    invalid = importlib.import_module("numpy").isin(values, list(stated("_FillValue", "missing_value").values()))
    if packing := stated("scale_factor", "add_offset"):
        factor, offset = packing.get("scale_factor", 1.0), packing.get("add_offset", 0.0)
        contents.told.append(f"{name}: its numbers times {factor} plus {offset}, as the file says")
        values = values * factor + offset
    if invalid.any():
        contents.invalid[name] += int(invalid.sum())
        values = values.astype(float)
        values[invalid] = float("nan")
    return values


def _mat(path: Path, _: object = None) -> Contents:
    with path.open("rb") as file:
        # MATLAB 7.3 writes HDF5 behind its own header.
        if file.read(10) == b"MATLAB 7.3" or b"\x89HDF" in file.read(600):
            return _hdf5(path)
    known = _library("scipy.io").loadmat(path, squeeze_me=True, struct_as_record=True)
    contents = Contents()
    items = [item for name, value in known.items() if not name.startswith("__") for item in _flat(name, value, contents)]
    contents = _by_length(items, contents)
    # PicoScope says begin and step of its channels.
    if {"Tstart", "Tinterval"} <= known.keys():
        for group in contents.groups:
            count = len(group.channels[0][2])
            group.time = [float(known["Tstart"]) + k * float(known["Tinterval"]) for k in range(count)]
    return contents


def _flat(name: str, value: Any, contents: Contents) -> Iterator[tuple[str, str, Any]]:
    """The arrays of a structure."""
    if not hasattr(value, "ndim") or hasattr(value, "toarray"):
        contents.left_out.append(name)
        return
    names = getattr(getattr(value, "dtype", None), "names", None)
    if names and value.ndim == 0:
        for part in names:
            yield from _flat(f"{name}/{part}", value[part][()], contents)
    elif getattr(value, "ndim", 0) in (1, 2) and value.dtype.kind in "iufb" and value.size > 1:
        yield name, "", value
    elif getattr(value, "size", 1) != 1 or names:
        contents.left_out.append(name)


def _parquet(path: Path, _: object = None) -> Contents:
    """Moments and durations become seconds."""
    table, types = _library("pyarrow.parquet").read_table(path), _library("pyarrow").types
    group, contents = Group(path.stem, None), Contents()
    for name, column in zip(table.column_names, table.columns, strict=True):
        unit, kind = (table.schema.field(name).metadata or {}).get(b"unit", b"").decode("utf-8", "replace"), column.type
        values: Any = None
        if types.is_timestamp(kind) or types.is_date(kind):
            zone = datetime.UTC if getattr(kind, "tz", None) else None
            values, unit = contents.clock(column.cast("timestamp[ns]").cast("int64").to_pylist(), zone), "s"
            contents.told.append(f"time: `{name}`, {values[0]} .. {values[-1]} s")
        elif types.is_duration(kind):
            values, unit = [None if tick is None else tick / 1e9 for tick in column.cast("duration[ns]").cast("int64").to_pylist()], "s"
        elif types.is_integer(kind) or types.is_floating(kind) or types.is_decimal(kind):
            values = (column.cast("float64") if types.is_decimal(kind) else column).to_pylist()
        if values is None:
            contents.left_out.append(name)
            continue
        bare, own = _rows.split_name(name)
        group.channels.append((bare, unit or own, values))
    contents.groups.append(group)
    return contents


def _xlsx(path: Path, options: _rows.Options) -> Contents:
    book = _library("openpyxl").load_workbook(path, read_only=True, data_only=True)
    contents, starts = Contents(), []
    for sheet in book.worksheets:
        rows = [[_cell(cell) for cell in row] for row in sheet.iter_rows()]
        if sum(any(_rows._is_value(cell) for cell in row) for row in rows) < 2:
            contents.left_out.append(sheet.title)
            continue
        columns = _rows.table(rows, options)
        contents.told.extend(columns.told)
        contents.groups.append(Group(sheet.title, columns.time, columns.channels))
        if columns.start:
            starts.append((columns.start, contents.groups[-1]))
    book.close()
    contents.start = min((start for start, _ in starts), default=None)
    for start, group in starts:
        group.shift((start - contents.start).total_seconds())
    return contents


def _cell(cell: Any) -> str:
    """A cell of a spreadsheet as text, per cent as they are shown."""
    value = cell.value
    if isinstance(value, datetime.timedelta):
        seconds = value.total_seconds()
        return f"{int(seconds // 3600)}:{int(seconds % 3600 // 60):02}:{seconds % 60:09.6f}"
    if isinstance(value, datetime.datetime) and value.time() == datetime.time() and not set(cell.number_format.lower()) & set("hs"):
        # A day: its clock may stand in another column.
        value = value.date()
    if isinstance(value, float):
        percent = "%" in cell.number_format
        shown = f"{100 * value:.15g}" if percent else repr(value).removesuffix(".0")
        # Without a mark it says nothing of the marks in cells of text.
        sign, figures, power = decimal.Decimal(shown).as_tuple()
        bare = shown if "." not in shown else f"{'-' * sign}{''.join(map(str, figures))}e{power}"
        return bare + (" %" if percent else "")
    return "" if value is None else value.isoformat() if hasattr(value, "isoformat") else str(value).strip()


EXTRAS = {"asammdf": "mdf", "nptdms": "tdms", "h5py": "hdf5", "scipy": "mat", "openpyxl": "xlsx", "pyarrow": "parquet"}
Reader = Callable[[Path, _rows.Options], Contents]
READERS: Mapping[str, Reader] = {ending: reader for endings, reader in (
    (".mf4 .mdf", _mdf), (".dat", _text), (".tdms", _tdms), (".h5 .hdf5 .hdf", _hdf5), (".mat", _mat), (".parquet", _parquet), (".xlsx .xlsm", _xlsx),
) for ending in endings.split()}
# What a file begins with says more than its ending.
MARKS: Mapping[bytes, Reader] = {
    b"MDF ": _mdf, b"UnFinMF": _mdf, b"TDSm": _tdms, b"\x89HDF": _hdf5, b"MATLAB ": _mat, b"PAR1": _parquet, b"PK\x03\x04": _xlsx,
}

OPTIONS = {
    "output": "where the csv goes (beside FILE)", "zero": "the moment of time 0, for several files of a run",
    "delimiter": "the letter between cells, or tab, space", "decimal": "the decimal mark, . or , of columns that do not tell, or NAME=MARK", "encoding": "such as utf-16",
    "header": "the line of the names; 0 where there are none", "time": "the column of the time, or none", "format": "of stamps: %%d/%%m/%%Y %%H:%%M:%%S",
}


class _Parser(argparse.ArgumentParser):
    def error(self, message: str) -> NoReturn:
        raise OrchestratorError(f"convert: {message}; see convert --help")


def main(given: Sequence[str]) -> int:
    """``convert FILE [OPTIONS]``."""
    if given[:1] == ["--one"]:
        _one(json.loads(given[1]))
        return 0
    endings = " ".join(ending for ending, reader in READERS.items() if reader is not _text)
    about = "writes a plain csv file for each rate: names `name [unit]`, numbers; the options decide where two readings are possible"
    parser = _Parser("convert", description=about)
    parser.add_argument("file", metavar="FILE", help=f"text in any usual form, or {endings}")
    for key, words in OPTIONS.items():
        parser.add_argument(f"--{key}", help=words, type=int if key == "header" else str, action="append" if key == "decimal" else "store")
    parser.add_argument("--unit", metavar="NAME=UNIT", action="append", default=[], help="of a column")
    said = {key: value for key, value in vars(parser.parse_args(given)).items() if value is not None}
    said["decimal"] = {name: mark for name, _, mark in (pair.rpartition("=") for pair in said.get("decimal", []))} or None
    pairs = [pair.rpartition("=") for pair in said.pop("unit")]
    if not all(equals for _, equals, _ in pairs):
        parser.error("--unit takes NAME=UNIT")
    convert(said.pop("file"), said.pop("output", None), units={name: unit for name, _, unit in pairs}, **said)
    return 0
