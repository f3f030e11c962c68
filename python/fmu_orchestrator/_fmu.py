"""Single FMUs: simulated, inspected, checked."""

import json
import os
import tempfile
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any, Literal

from . import _html
from ._program import Value, flags, run, text_of, units_of_fmu
from ._table import Given, Table, given, read

StrPath = str | os.PathLike[str]
Setting = float | int | bool | str


def simulate(
    fmu: StrPath,
    values: Mapping[str, Setting] | None = None,
    *,
    start: float | None = None,
    stop: float | None = None,
    step: float | None = None,
    record: Iterable[str] | None = None,
    inputs: Given | None = None,
    extrapolate: Literal["hold"] | None = None,
    values_from: StrPath | None = None,
) -> Table:
    """Simulates an FMU once: a row a communication point, the column ``time``, then the outputs or what is recorded.

    ``values`` are start values: numbers in the FMU's units, or text with a unit such as ``"0.02 mm"``. ``values_from`` is
    an SSP parameter set, such as the ``best.ssv`` of a study. ``inputs`` are inputs over time: a table with a column
    ``time`` and a column for each input, ``NAME`` or ``NAME [UNIT]``; with ``extrapolate="hold"`` its first and last values
    hold where the run is longer. Times in seconds, else as the FMU suggests.
    """
    options: dict[str, Value] = {"start": start, "stop": stop, "step": step, "set_from": values_from,
                                   "extrapolate": extrapolate}
    options["record"] = None if record is None else ",".join(record)
    settings = [f"--set={name}={text_of(value)}" for name, value in (values or {}).items()]
    with tempfile.TemporaryDirectory(prefix="simulation-") as folder:
        options["output"] = file = Path(folder) / "trajectory.csv"
        options["input"] = None if inputs is None else given(inputs, Path(folder))
        run("simulate", fmu, *settings, *flags(options))
        return read(file, units=lambda: units_of_fmu(fmu))


def inspect(fmu: StrPath) -> dict[str, Any]:
    """What an FMU is: its description with ``variables``, ``capabilities``, units and ``platforms``."""
    found: dict[str, Any] = json.loads(run("inspect", fmu, "--json").text)
    return found


@dataclass(frozen=True)
class Finding:
    """A fault in an FMU, or what looks like one."""

    severity: Literal["error", "warning", "note"]
    rule: str
    """The rule's name, the same in every version."""
    source: str
    """Where the rule stands: the standard and its section."""
    message: str
    file: str | None
    line: int | None


@dataclass(frozen=True)
class Check:
    """What `check` has found, the worst first."""

    passed: bool
    findings: tuple[Finding, ...]
    data: Mapping[str, Any]
    """The answer as the command line writes it with ``--format json``."""

    def _repr_html_(self) -> str:
        lines = [f"{found.severity}: {found.message} [{found.source}]" for found in self.findings]
        return _html.text("\n".join(lines) or "nothing found")


def check(fmu: StrPath, *, strict: bool = False, patience: float | None = None) -> Check:
    """Looks for faults in an FMU. It passes without errors; with ``strict``, without warnings, too.

    ``patience``, s, limits each of the short simulations.
    """
    done = run("check", fmu, "--format=json", *flags({"strict": strict, "patience": patience}), results=(0, 1))
    data = json.loads(done.text)
    return Check(done.code == 0, tuple(map(_finding, data["findings"])), data)


def _finding(found: Mapping[str, Any]) -> Finding:
    return Finding(**{field.name: found[field.name] for field in fields(Finding)})
