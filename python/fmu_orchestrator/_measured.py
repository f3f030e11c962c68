"""Studies from an FMU and from what was measured."""

import os
import tempfile
import tomllib
from collections.abc import Mapping, Sequence
from functools import cached_property
from pathlib import Path
from typing import Any

from . import _html, _toml
from ._convert import convert, is_text
from ._program import Value, flags, run, text_of
from ._study import Study
from ._table import Given, Table, given, read

StrPath = str | os.PathLike[str]
MEASURED = Path("results", "measured")


def init(
    fmu: StrPath, *, measured: Given | None = None, values: Mapping[str, Value] | None = None, stop: float | None = None,
    step: float | None = None,
) -> Study:
    """A study of an FMU that runs as it is: parameters with start values vary by 10 %, and criteria are made of outputs.

    ``measured`` is a file or a table of pandas, polars, pyarrow or a mapping, with columns ``NAME [UNIT]`` of the FMU's
    outputs and inputs (the tables of this package know their units); with a column ``time`` they are curves. Without it the nominal
    values come from a run of the model, and the verdict says so. ``values`` are start values, numbers or texts with a unit, such as
    those of inputs that start at 0; ``stop`` and ``step`` in seconds.
    """
    table = None if measured is None else given(measured, MEASURED, units=True)
    with tempfile.TemporaryDirectory(prefix="init-") as place:
        file = Path(place).resolve() / "study.toml"
        paths = {"measured": None if table is None else table.absolute(), "output": file}
        settings = [f"--set={name}={text_of(value)}" for name, value in (values or {}).items()]
        run("init", Path(fmu).absolute(), *settings, *flags({**paths, "stop": stop, "step": step}))
        content = tomllib.loads(file.read_text(encoding="utf-8"))
        return Study(_toml.placed(content, file.parent), name=Path(fmu).stem)


class Synchronised:
    """What a recording tells; all of it is in ``folder``."""

    def __init__(self, folder: StrPath, text: str = "") -> None:
        self.folder = Path(folder)
        self.text = text
        """The text that the command line prints."""

    def _content(self, name: str) -> dict[str, Any]:
        path = self.folder / name
        return _toml.placed(tomllib.loads(path.read_text(encoding="utf-8")), Path.cwd()) if path.exists() else {}

    @property
    def criteria(self) -> dict[str, Any]:
        """The measured values with their uncertainties, as the criteria of a study; their tolerances are for you to add."""
        criteria: dict[str, Any] = self._content("criteria.toml").get("criteria", {})
        return criteria

    @property
    def cases(self) -> list[Any]:
        """With ``case``: the case of a study, whose inputs and curves are the recording."""
        cases: list[Any] = self._content("case.toml").get("cases", [])
        return cases

    @cached_property
    def signals(self) -> Table:
        """The signals at common times."""
        return read(self.folder / "synchronised.csv")

    @property
    def report(self) -> Path:
        """The page: delay, signals, uncertainty budget."""
        return self.folder / "report.html"

    def __repr__(self) -> str:
        return f"<Synchronised: {self.folder}>"

    def _repr_html_(self) -> str:
        return _html.text(self.text or repr(self)) + _html.page(self.report)


def synchronise(
    tables: Given | Sequence[Given],
    settings: Mapping[str, Any] | StrPath,
    *,
    case: str | None = None,
    held_out: bool = False,
    output: StrPath = MEASURED,
) -> Synchronised:
    """Turns measured signals into criteria with their uncertainty.

    ``tables`` is a file or a table of pandas, polars, pyarrow or a mapping, or a list of them; MDF4, TDMS, HDF5, MAT and xlsx
    files are converted to csv files in ``output``, one for each rate. ``settings`` are a TOML file, or its content: columns, units,
    accuracies. ``case`` makes a case of the recording, ``held_out`` one that is never fitted.
    """
    folder = Path(output).absolute()
    several = list(tables) if isinstance(tables, list | tuple) else [tables]
    files = [file for table in several for file in _files(given(table, folder), folder)]
    file = folder / "settings.toml"
    if isinstance(settings, Mapping):
        folder.mkdir(parents=True, exist_ok=True)
        file.write_text(_toml.text(settings), encoding="utf-8")
    else:
        file = Path(settings)
    options: dict[str, Value] = {"settings": file, "case": case, "held_out": held_out, "output": folder}
    done = run("synchronise", *files, *flags(options))
    return Synchronised(folder, done.text)


def _files(path: Path, folder: Path) -> list[Path]:
    """The file, or the csv files that it becomes."""
    return [path] if is_text(path) else convert(path, folder)
