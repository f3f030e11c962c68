"""Tables of results: columns by name, as every library takes them."""

import csv
import math
import os
from array import array
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from hashlib import sha256
from html import escape
from io import StringIO
from itertools import islice
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, TextIO

from . import _arrow
from ._arrow import Column
from ._errors import OrchestratorError

if TYPE_CHECKING:
    import numpy
    from numpy.typing import NDArray

Kind = Literal["count", "number", "flag", "text"]
Kinds = Sequence[Kind] | Callable[[int], Sequence[Kind]] | None
# Rows that are text at a time.
GROUP = 1 << 14
SHOWN = 10
FORMULA = ("=", "+", "-", "@", "\t", "\r")


class Table:
    """Columns by name. A missing number is NaN here and null in Arrow.

    pandas, polars, pyarrow and DuckDB take it as it is, through the Arrow PyCapsule interface, without copying numbers.
    Without any of them ``table["name"]`` is a column, ``dict(table)`` holds all.
    """

    def __init__(self, columns: Mapping[str, Column]) -> None:
        self._columns = dict(columns)

    @property
    def names(self) -> list[str]:
        """The names of the columns."""
        return list(self._columns)

    def keys(self) -> list[str]:
        """The names of the columns, as ``dict(table)`` asks for them."""
        return self.names

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

    def __arrow_c_stream__(self, requested_schema: object = None) -> object:
        """The table as a stream of one batch (Arrow PyCapsule interface)."""
        return _arrow.stream(self._columns)

    def __repr__(self) -> str:
        return f"<Table of {len(self)} rows: {', '.join(self._columns)}>"

    def _repr_html_(self) -> str:
        head = "".join(f"<th>{escape(name)}</th>" for name in self._columns)
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


def read(path: Path, kinds: Kinds = None) -> Table:
    """Reads a csv file of the program."""
    try:
        with path.open(encoding="utf-8", newline="") as file:
            return parse(file, kinds)
    except OSError as error:
        raise OrchestratorError(f"{path}: {error.strerror}") from error


def parse(file: TextIO, kinds: Kinds = None) -> Table:
    """Reads a table of the program; ``kinds`` are the types of its columns, or what says them of a number of columns, else
    they are found from the cells."""
    reader = csv.reader(file)
    header = [unquoted(name) for name in next(reader, [])]
    known = kinds(len(header)) if callable(kinds) else kinds
    chosen: Sequence[Kind] = known or ["text"] * len(header)
    columns = [_empty(kind) for kind in chosen]
    while rows := list(islice(reader, GROUP)):
        for column, kind, cells in zip(columns, chosen, zip(*rows, strict=True), strict=True):
            _extend(column, kind, cells)
    if known is None:
        columns = [_found(column) for column in columns]
    return Table(dict(zip(header, columns, strict=True)))


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


def given(table: Given, folder: Path) -> Path:
    """A table as a file: the file itself, or one in ``folder`` with the columns of a table of pandas, polars, pyarrow or
    a mapping."""
    if isinstance(table, str | os.PathLike):
        return Path(table)
    names = getattr(table, "column_names", None)
    if names is None:
        names = getattr(table, "columns", None)
    if names is None:
        names = table.keys()
    content = StringIO(newline="")
    writer = csv.writer(content)
    writer.writerow([str(name) for name in names])
    columns = [_listed(table[name]) for name in names]
    writer.writerows(map(_written, row) for row in zip(*columns, strict=True))
    text = content.getvalue().encode()
    folder.mkdir(parents=True, exist_ok=True)
    # An interrupted run goes on with the table that it began with, so another table gets another name.
    path = folder / f"table-{sha256(text).hexdigest()[:8]}.csv"
    path.write_bytes(text)
    return path


def _listed(column: Any) -> list[Any]:
    for way in ("to_pylist", "tolist", "to_list"):
        if hasattr(column, way):
            return list(getattr(column, way)())
    return list(column)


def _written(value: Any) -> str:
    if value is None or (isinstance(value, float) and math.isnan(value)):
        return ""
    return repr(float(value)) if isinstance(value, float) else str(value)
