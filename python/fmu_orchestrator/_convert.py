"""Recordings in formats of their own as csv files that ``orchestrator synchronise`` reads: one for each rate.

    python -m fmu_orchestrator convert x.mf4 [--output FOLDER]

Each library is imported only when a file needs it; ``pip install "fmu-orchestrator[recordings]"`` installs all of them.
"""

import csv
import filecmp
import importlib
import sys
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from ._errors import OrchestratorError


@dataclass
class Group:
    """Channels that share their times."""

    name: str
    time: Any  # seconds; None: the file has no times, or one of the channels is the time
    channels: list[tuple[str, str, Any]] = field(default_factory=list)  # name, unit, values


@dataclass
class Contents:
    """What a file holds."""

    groups: list[Group] = field(default_factory=list)
    left_out: list[str] = field(default_factory=list)  # names of what is no series of numbers
    invalid: dict[str, int] = field(default_factory=dict)  # samples that the file calls invalid, by channels
    start: str = ""  # the time stamp at time 0


def convert(path: str | Path, folder: str | Path | None = None) -> list[Path]:
    """Writes a csv file for each rate of a recording, and gives their paths; what is left out is printed."""
    path = Path(path)
    if not path.is_file():
        raise OrchestratorError(f"{path}: no such file")
    reader = READERS.get(path.suffix.lower())
    if reader is None:
        raise OrchestratorError(f"{path}: `{path.suffix}` is none of {', '.join(READERS)}; export it as csv")
    try:
        contents = reader(path)
    except OrchestratorError:
        raise
    except Exception as error:
        # The libraries raise whatever they like at files that are damaged or of a version that they do not know.
        reason = " ".join(str(error).split()) or type(error).__name__
        raise OrchestratorError(f"{path}: not readable as {path.suffix}: {reason}; export it as csv") from error
    groups = [group for group in contents.groups if group.channels]
    if contents.left_out:
        shown = ", ".join(contents.left_out[:5]) + (" ..." if len(contents.left_out) > 5 else "")
        print(f"note: {len(contents.left_out)} left out, as they are no series of numbers: {shown}", file=sys.stderr)
    for name, count in contents.invalid.items():
        print(f"note: {name}: {count} samples are invalid, as the file says, and become empty cells", file=sys.stderr)
    if contents.start:
        print(f"{path}: its time 0 is {contents.start}")
    if not groups:
        raise OrchestratorError(f"{path}: it holds no series of numbers; export the recording as csv")
    into = Path(folder) if folder is not None else path.parent
    into.mkdir(parents=True, exist_ok=True)
    return [_write(group, into / f"{path.stem}{f'-{k}' if len(groups) > 1 else ''}.csv") for k, group in enumerate(groups, 1)]


def is_text(path: Path) -> bool:
    """Whether ``synchronise`` reads a recording as it is, or it is of no kind that is known here."""
    ending = path.suffix.lower()
    if ending not in READERS or ending == ".parquet" or not path.is_file():
        return True
    with path.open("rb") as file:
        return ending == ".dat" and not file.read(3) == b"MDF"


def _write(group: Group, path: Path) -> Path:
    names, units, columns = [], [], []
    if group.time is not None:
        names, units, columns = ["time"], ["s"], [group.time]
    for name, unit, values in group.channels:
        # The same name may come again within a group.
        again = sum(known == name or known.startswith(f"{name} (") for known in names) if name in names and name else 0
        names.append(f"{name} ({again + 1})" if again else name)
        units.append(unit)
        columns.append(values)
    part = path.with_suffix(".csv.part")
    with part.open("w", newline="", encoding="utf-8") as file:
        table = csv.writer(file)
        table.writerow(names)
        if any(units):
            table.writerow(unit or "-" for unit in units)
        rows = zip(*(_cells(column) for column in columns), strict=True)
        table.writerows(rows)
    if path.exists() and not filecmp.cmp(part, path, shallow=False):
        part.unlink()
        # Two loggers of a run often write files of one name.
        raise OrchestratorError(f"{path} is there already and holds something else; choose another folder with --output")
    part.replace(path)
    timeless = "" if {name.rpartition("/")[2].lower() for name in names} & TIMES else "; without a column of times: time = { rate = ... }"
    print(f"{path}: {len(columns[0])} rows of {', '.join(names[:6])}{' ...' if len(names) > 6 else ''}{timeless}")
    return path


def _cells(column: Any) -> Iterator[object]:
    for value in column.tolist() if hasattr(column, "tolist") else column:
        yield "" if value is None or value != value else value


def _library(name: str, path: Path) -> Any:
    try:
        return importlib.import_module(name)
    except ImportError:
        extra = EXTRAS[name.partition(".")[0]]
        message = f'{path}: {name} is missing; pip install "fmu-orchestrator[{extra}]"'
        raise OrchestratorError(message) from None


def _is_series(values: Any) -> bool:
    return getattr(values, "ndim", 0) == 1 and len(values) > 1 and getattr(values, "dtype", None) is not None and values.dtype.kind in "iufb"


def _mdf(path: Path) -> Contents:
    contents = Contents()
    with _library("asammdf", path).MDF(path) as mdf:
        contents.start = mdf.header.start_time.isoformat()
        for number in mdf.virtual_groups:
            group = Group(f"group {number}", None)
            for signal in mdf.select(_channels(mdf, number), raw=False, copy_master=True):
                if not _is_series(signal.samples) or len(signal.samples) != len(signal.timestamps):
                    contents.left_out.append(signal.name)
                    continue
                values = _valid(signal, contents)
                # Channels of one group have one clock, but for those that a file records without their invalid samples.
                if group.time is None:
                    group.time = signal.timestamps
                if len(group.time) != len(signal.timestamps):
                    contents.groups.append(Group(signal.name, signal.timestamps, [(signal.name, signal.unit, values)]))
                    continue
                group.channels.append((signal.name, signal.unit, values))
            contents.groups.append(group)
    return contents


def _valid(signal: Any, contents: Contents) -> Any:
    """The samples; ``None`` in place of those that the file calls invalid."""
    bits = signal.invalidation_bits
    if bits is None or not bits.any():
        return signal.samples
    contents.invalid[signal.name] = contents.invalid.get(signal.name, 0) + int(bits.sum())
    return [None if invalid else value for value, invalid in zip(signal.samples.tolist(), bits.tolist(), strict=True)]


def _channels(mdf: Any, number: int) -> list[tuple[None, int, int]]:
    included = mdf.included_channels(number)[number]
    return [(None, group, channel) for group, channels in included.items() for channel in channels]


def _tdms(path: Path) -> Contents:
    contents = Contents()
    file = _library("nptdms", path).TdmsFile.read(path)
    starts = [c.properties["wf_start_time"] for g in file.groups() for c in g.channels() if "wf_start_time" in c.properties]
    first = min(starts, default=None)
    for part in file.groups():
        rates: dict[tuple[object, ...], Group] = {}
        for channel in part.channels():
            values = channel[:]
            if not _is_series(values):
                contents.left_out.append(f"{part.name}/{channel.name}")
                continue
            known = channel.properties
            step, start = known.get("wf_increment"), known.get("wf_start_time")
            key = (len(values), step, start, known.get("wf_start_offset"))
            if key not in rates:
                late = (start - first) / _second(start) if start is not None else 0.0
                begin = float(known.get("wf_start_offset", 0.0)) + float(late)
                rates[key] = Group(part.name, [begin + k * step for k in range(len(values))] if step else None)
            rates[key].channels.append((channel.name, str(known.get("unit_string", known.get("NI_UnitDescription", ""))), values))
        contents.groups.extend(rates.values())
    return contents


def _second(start: Any) -> Any:
    numpy = importlib.import_module("numpy")
    return numpy.timedelta64(1, "s") if isinstance(start, numpy.datetime64) else type(start - start)(seconds=1)


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
        group.channels.sort(key=lambda channel: channel[0].rpartition("/")[2].lower() not in TIMES)
    contents.groups.extend(groups.values())
    return contents


TIMES = {"t", "ts", "time", "zeit", "timestamp", "timestamps", "tout"}


def _hdf5(path: Path) -> Contents:
    contents = Contents()
    h5py = _library("h5py", path)
    items: list[tuple[str, str, Any]] = []

    def visit(name: str, node: Any) -> None:
        if not isinstance(node, h5py.Dataset) or node.shape is None:
            return
        unit = next((node.attrs[key] for key in ("unit", "units", "Unit", "Units") if key in node.attrs), "")
        unit = unit.decode("utf-8", "replace") if isinstance(unit, bytes) else str(unit)
        if node.dtype.names:
            items.extend((f"{name}/{part}", unit, node[part]) for part in node.dtype.names)
        elif h5py.check_ref_dtype(node.dtype) is None and not (node.ndim > 2 or node.dtype.kind not in "iufb"):
            items.append((name, unit, node[()]))
        else:
            contents.left_out.append(name)

    with h5py.File(path) as file:
        file.visititems(visit)
    return _by_length(items, contents)


def _mat(path: Path) -> Contents:
    with path.open("rb") as file:
        # MATLAB 7.3 writes HDF5 behind its own header.
        if file.read(10) == b"MATLAB 7.3" or b"\x89HDF" in file.read(600):
            return _hdf5(path)
    known = _library("scipy.io", path).loadmat(path, squeeze_me=True, struct_as_record=True)
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
    names = getattr(getattr(value, "dtype", None), "names", None)
    if names and value.ndim == 0:
        for part in names:
            yield from _flat(f"{name}/{part}", value[part][()], contents)
    elif getattr(value, "ndim", 0) in (1, 2) and value.dtype.kind in "iufb" and value.size > 1:
        yield name, "", value
    elif getattr(value, "size", 1) != 1 or names:
        contents.left_out.append(name)


def _parquet(path: Path) -> Contents:
    table = _library("pyarrow.parquet", path).read_table(path)
    group, contents = Group(path.stem, None), Contents()
    for name in table.column_names:
        values = [_text(value) for value in table[name].to_pylist()]
        if not _is_value(next((value for value in values if value is not None), None)):
            contents.left_out.append(name)
            continue
        unit = (table.schema.field(name).metadata or {}).get(b"unit", b"").decode("utf-8", "replace")
        group.channels.append((name, unit, values))
    # Time stamps come first, as they are the time.
    group.channels.sort(key=lambda channel: not isinstance(next(iter(channel[2]), None), str))
    contents.groups.append(group)
    return contents


def _xlsx(path: Path) -> Contents:
    book = _library("openpyxl", path).load_workbook(path, read_only=True, data_only=True)
    contents = Contents()
    for sheet in book.worksheets:
        # Preambles, names and units stay where they are: `synchronise` knows them in csv.
        rows = [[_text(cell) for cell in row] for row in sheet.iter_rows(values_only=True)]
        rows = [row for row in rows if any(cell is not None for cell in row)]
        if sum(any(_is_value(cell) for cell in row) for row in rows) < 2:
            contents.left_out.append(sheet.title)
            continue
        columns = zip(*rows, strict=True)
        group = Group(sheet.title, None, [("" if name is None else str(name), "", column) for name, *column in columns])
        contents.groups.append(group)
    book.close()
    return contents


def _text(cell: Any) -> Any:
    return cell.isoformat() if hasattr(cell, "isoformat") else cell


def _is_value(cell: object) -> bool:
    """Numbers, and texts that begin as numbers and time stamps do."""
    return isinstance(cell, int | float) or (isinstance(cell, str) and cell.lstrip("+-")[:1].isdigit())


EXTRAS = {"asammdf": "mdf", "nptdms": "tdms", "h5py": "hdf5", "scipy": "mat", "openpyxl": "xlsx", "pyarrow": "parquet"}
READERS: Mapping[str, Callable[[Path], Contents]] = {
    ".mf4": _mdf,
    ".mdf": _mdf,
    ".dat": _mdf,
    ".tdms": _tdms,
    ".h5": _hdf5,
    ".hdf5": _hdf5,
    ".hdf": _hdf5,
    ".mat": _mat,
    ".parquet": _parquet,
    ".xlsx": _xlsx,
    ".xlsm": _xlsx,
}


def main(given: Sequence[str]) -> int:
    """``convert FILE [--output FOLDER]``."""
    match list(given):
        case ["--help" | "-h"]:
            print("""convert FILE [--output FOLDER]: csv files for `orchestrator synchronise`, one for each rate
FILE: {endings}""".format(endings=" ".join(READERS)))
        case [path]:
            convert(path)
        case [path, "--output", folder] | ["--output", folder, path]:
            convert(path, folder)
        case _:
            raise OrchestratorError("convert takes one file: convert x.mf4 [--output FOLDER]")
    return 0
