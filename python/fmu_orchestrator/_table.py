"""Tables of results: columns by name, as every library takes them."""

import csv
import math
import os
from array import array
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from functools import cached_property
from hashlib import sha256
from html import escape
from io import StringIO
from itertools import chain, islice
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, TextIO

from . import _arrow
from ._arrow import Column
from ._errors import OrchestratorError

if TYPE_CHECKING:
    import numpy
    from numpy.typing import NDArray

Kind = Literal["count", "number", "flag", "text"]
Kinds = Sequence[Kind] | Callable[[Sequence[str]], Sequence[Kind]] | None
Units = Mapping[str, str | None] | Callable[[], Mapping[str, str | None]] | None
# Rows that are text at a time.
GROUP = 1 << 14
SHOWN = 10
FORMULA = ("=", "+", "-", "@", "\t", "\r")


class Table:
    """Columns by name. A missing number is NaN here and null in Arrow.

    ``to_pandas()``, ``polars.DataFrame(table)``, ``pyarrow.table(table)`` and DuckDB take it, the latter three as it is,
    through the Arrow PyCapsule interface, without copying numbers. Without any of them ``table["name"]`` is a column,
    ``dict(table)`` holds all.
    """

    def __init__(self, columns: Mapping[str, Column], units: Units = None) -> None:
        self._columns = dict(columns)
        self._units = units

    @property
    def names(self) -> list[str]:
        """The names of the columns."""
        return list(self._columns)

    def keys(self) -> list[str]:
        """The names of the columns, as ``dict(table)`` asks for them."""
        return self.names

    @cached_property
    def units(self) -> dict[str, str]:
        """The units of the columns that have one, by name."""
        known = self._units() if callable(self._units) else self._units or {}
        return {name: unit for name in self if (unit := known.get(name)) not in (None, "", "1")}

    def label(self, name: str) -> str:
        """The name of a column with its unit."""
        return f"{name} [{self.units[name]}]" if name in self.units else name

    def __getitem__(self, name: str) -> Column:
        try:
            return self._columns[name]
        except KeyError:
            raise KeyError(f"no column `{name}`; there are {', '.join(self._columns)}") from None

    def __contains__(self, name: object) -> bool:
        return name in self._columns

    def __iter__(self) -> Iterator[str]:
        return iter(self._columns)

    def __len__(self) -> int:
        """The number of rows."""
        return len(next(iter(self._columns.values()), ()))

    def rows(self) -> Iterator[dict[str, Any]]:
        """The rows, each as a dictionary."""
        for cells in zip(*self._columns.values(), strict=True):
            yield dict(zip(self._columns, cells, strict=True))

    def to_numpy(self, names: Iterable[str] | None = None) -> "NDArray[numpy.float64]":
        """Columns of numbers as an array: a row a point, a column a name. Needs numpy."""
        import numpy

        chosen = list(self.names if names is None else names)
        columns = [numpy.asarray(self[name], dtype=numpy.float64) for name in chosen]
        return numpy.column_stack(columns) if columns else numpy.empty((len(self), 0))

    def to_pandas(self) -> Any:
        """The table as a frame of pandas; its ``attrs["units"]`` are the units. Needs pandas."""
        try:
            import numpy
            import pandas  # type: ignore[import-untyped, unused-ignore]
        except ImportError as error:
            raise OrchestratorError(f"to_pandas() needs {error.name}: pip install pandas") from None

        frame = pandas.DataFrame(
            {name: numpy.array(column) if isinstance(column, array) else column for name, column in self._columns.items()}
        )
        frame.attrs["units"] = self.units
        return frame

    def __array__(self, dtype: object = None, copy: object = None) -> "NDArray[numpy.float64]":
        # Else numpy and pandas would take the names for the values, without a word.
        raise TypeError("a table has columns of several types: use its to_pandas() or to_numpy()")

    def __arrow_c_stream__(self, requested_schema: object = None) -> object:
        """The table as a stream of one batch (Arrow PyCapsule interface)."""
        return _arrow.stream(self._columns)

    def __repr__(self) -> str:
        return f"<Table of {len(self)} rows: {', '.join(map(self.label, self))}>"

    def _repr_html_(self) -> str:
        head = "".join(f"<th>{escape(self.label(name))}</th>" for name in self)
        rows = "".join(
            "<tr>" + "".join(f"<td>{escape(_cell(value))}</td>" for value in row.values()) + "</tr>"
            for row in islice(self.rows(), SHOWN)
        )
        more = f"<p>{len(self)} rows</p>" if len(self) > SHOWN else ""
        return f"<table><thead><tr>{head}</tr></thead><tbody>{rows}</tbody></table>{more}"


def _cell(value: object) -> str:
    if isinstance(value, float):
        return "" if math.isnan(value) else f"{value:.6g}"
    return str(value)


def read(path: Path, kinds: Kinds = None, units: Units = None) -> Table:
    """Reads a csv file of the program."""
    try:
        with path.open(encoding="utf-8", newline="") as file:
            return parse(file, kinds, units)
    except OSError as error:
        raise OrchestratorError(f"{path}: {error.strerror}") from error


def parse(file: TextIO, kinds: Kinds = None, units: Units = None) -> Table:
    """Reads a table of the program; ``kinds`` are the types of its columns, or what says them of the header, else
    they are found from the cells."""
    first = next(iter(file), "")
    # A first line that begins with # tells of the columns.
    reader = csv.reader(file if first.startswith("#") else chain([first], file))
    header = [unquoted(name) for name in next(reader, [])]
    known = kinds(header) if callable(kinds) else kinds
    chosen: Sequence[Kind] = known or ["text"] * len(header)
    columns = [_empty(kind) for kind in chosen]
    while rows := list(islice(reader, GROUP)):
        for column, kind, cells in zip(columns, chosen, zip(*rows, strict=True), strict=True):
            _extend(column, kind, cells)
    if known is None:
        columns = [_found(column) for column in columns]
    return Table(dict(zip(header, columns, strict=True)), units)


def _empty(kind: Kind) -> Any:
    return {"count": array("q"), "number": array("d"), "flag": [], "text": []}[kind]


def _extend(column: Any, kind: Kind, cells: Iterable[str]) -> None:
    if kind == "number":
        column.extend(float(cell) if cell else math.nan for cell in cells)
    elif kind == "count":
        column.extend(map(int, cells))
    elif kind == "flag":
        column.extend(cell == "true" for cell in cells)
    else:
        column.extend(map(unquoted, cells))


def _found(cells: list[str]) -> Column:
    """Numbers, where all cells are; else flags, where all are; else text."""
    try:
        return array("d", [float(cell) if cell else math.nan for cell in cells])
    except ValueError:
        flags = set(cells) <= {"true", "false"}
        return [cell == "true" for cell in cells] if flags else cells


def unquoted(cell: str) -> str:
    """A text without the apostrophe that keeps spreadsheets from taking it for a formula."""
    return cell[1:] if cell.startswith("'") and cell.lstrip("'").startswith(FORMULA) else cell


Given = str | os.PathLike[str] | Mapping[str, Sequence[Any]] | Table | Any


def given(table: Given, folder: Path, *, units: bool = False) -> Path:
    """A table as a file: the file itself, or one in ``folder`` with the columns of a table of pandas, polars, pyarrow or
    a mapping; with ``units`` their names have those that the table knows."""
    if isinstance(table, str | os.PathLike):
        return Path(table)
    text = csv_of(table, units)
    folder.mkdir(parents=True, exist_ok=True)
    # An interrupted run goes on with the table that it began with, so another table gets another name.
    path = folder / f"table-{sha256(text).hexdigest()[:8]}.csv"
    path.write_bytes(text)
    return path


def csv_of(table: Any, units: bool = False) -> bytes:
    """The columns of a table of pandas, polars, pyarrow or a mapping as a csv file."""
    known = getattr(table, "attrs", {"units": getattr(table, "units", {})}).get("units", {}) if units else {}
    names = getattr(table, "column_names", None)
    if names is None:
        table = _with_index(table)
        names = getattr(table, "columns", None)
    if names is None and hasattr(table, "keys"):
        names = table.keys()
    if names is None:
        raise OrchestratorError(f"a {type(table).__name__} is no table: give a file, a mapping, or one of pandas, polars or pyarrow")
    content = StringIO(newline="")
    writer = csv.writer(content)
    writer.writerow([f"{name} [{known[name]}]" if known.get(name, "1") != "1" else str(name) for name in names])
    columns = [_listed(table[name]) for name in names]
    writer.writerows(map(_written, row) for row in zip(*columns, strict=True))
    return content.getvalue().encode()


def _with_index(table: Any) -> Any:
    """A frame of pandas with its index as a column: moments and durations become seconds; an index of row numbers is none."""
    index: Any = getattr(table, "index", None)
    if not hasattr(index, "to_numpy") or not hasattr(table, "reset_index"):
        return table
    name = index.name or "time"
    if (is_moment := hasattr(index, "tz")) or hasattr(index, "total_seconds"):
        index, name = (index - index.min() if is_moment else index).total_seconds(), "time [s]"
    elif index.name is None and index.dtype.kind != "f":
        return table
    return table if name in table.columns else table.set_axis(index, axis=0).rename_axis(name).reset_index()


def is_table(value: object) -> bool:
    """Whether it is a table or the name of a file, and no column."""
    return isinstance(value, str | os.PathLike | Mapping | Table) or hasattr(value, "columns") or hasattr(value, "column_names")


def _listed(column: Any) -> list[Any]:
    for way in ("to_pylist", "tolist", "to_list"):
        if hasattr(column, way):
            return list(getattr(column, way)())
    return list(column)


def _written(value: Any) -> str:
    if value is None or (isinstance(value, float) and math.isnan(value)):
        return ""
    return repr(float(value)) if isinstance(value, float) else str(value)
