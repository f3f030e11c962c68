"""Runs the command-line program."""

import json
import os
import re
import signal
import subprocess
import sys
import warnings
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from numbers import Integral, Real
from pathlib import Path
from typing import cast

from ._errors import Interrupted, OrchestratorError, OrchestratorWarning
from ._files import program

INTERRUPTED = 130
# An interrupted program ends within a second; one that does not is held by something outside of it.
PATIENCE = 5.0
GLANCE = 0.2
# The options that the program's remedies name, and their values where it gives one.
OPTION = re.compile(r"--(resume|force|ship|output|jobs|points|seed|memory-limit|point-timeout)\b(?: (\d+)\b)?")
SWITCHES = ("resume", "force", "ship")
Value = str | os.PathLike[str] | int | float | bool | None


@dataclass(frozen=True)
class Done:
    """A run that has ended."""

    code: int
    text: str
    said: str = ""
    """Its remarks."""


def flags(options: Mapping[str, Value]) -> Iterator[str]:
    """Options as the command line writes them; None and False are left out."""
    for name, value in options.items():
        option = "--" + name.replace("_", "-")
        if value is True:
            yield option
        elif value is not None and value is not False:
            # In one piece, because a value may begin with a hyphen.
            yield f"{option}={text_of(value)}"


def text_of(value: Value) -> str:
    """A value as the command line writes it: numbers with all their digits."""
    if isinstance(value, bool):
        return str(value).lower()
    # Numpy's numbers are none of Python's, and show their type.
    if isinstance(value, Integral):
        return str(int(value))
    if isinstance(value, Real):
        return repr(float(value))
    return os.fspath(cast("str | os.PathLike[str]", value or ""))


def run(
    *arguments: str | os.PathLike[str],
    results: tuple[int, ...] = (0,),
    folder: Path | None = None,
    look: Callable[[], None] | None = None,
) -> Done:
    """Runs the program; ``results`` are the exit codes that are answers.

    ``look`` is called a few times a second. ``folder`` is where an interrupted run can go on.
    """
    command = [program(), *arguments]
    with subprocess.Popen(
        command, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE, encoding="utf-8", errors="replace"
    ) as process:
        try:
            text, said = _wait(process, look)
        except BaseException as error:
            _end(process)
            if isinstance(error, KeyboardInterrupt):
                raise Interrupted(folder) from None
            raise
    if process.returncode == INTERRUPTED:
        raise Interrupted(folder)
    remark(said)
    if process.returncode not in results:
        raise OrchestratorError(complaint(said, process.returncode))
    return Done(process.returncode, text, said)


def units_of_fmu(fmu: str | os.PathLike[str]) -> dict[str, str]:
    """The units of an FMU's variables, by name, and that of the time."""
    variables = json.loads(run("inspect", fmu, "--json").text)["variables"]
    return {"time": "s"} | {one["name"]: one["unit"] for one in variables if one.get("unit")}


def _wait(process: "subprocess.Popen[str]", look: Callable[[], None] | None) -> tuple[str, str]:
    while True:
        try:
            return process.communicate(timeout=GLANCE if look else None)
        except subprocess.TimeoutExpired:
            if look:
                look()


def _end(process: "subprocess.Popen[str]") -> None:
    """Ends the program as Ctrl-C does: its journal stays sound, and its workers end with it."""
    try:
        if os.name == "nt":
            process.terminate()
        else:
            process.send_signal(signal.SIGINT)
        # It has last words to say, so the pipes stay open.
        process.communicate(timeout=PATIENCE)
    except BaseException:
        process.kill()
        process.wait()


def remark(said: str) -> None:
    """Passes the program's remarks on as warnings."""
    for line in said.splitlines():
        kind, _, text = line.partition(": ")
        if kind in ("warning", "note"):
            warn(with_arguments(text))


def warn(text: str) -> None:
    """A warning at the line that called the package."""
    frame, level = sys._getframe(), 1
    while frame.f_back and str(frame.f_globals.get("__name__")).startswith(f"{__package__}."):
        frame, level = frame.f_back, level + 1
    warnings.warn(text, OrchestratorWarning, stacklevel=level)


def complaint(said: str, code: int) -> str:
    """The error's message among all that the program said."""
    _, found, message = ("\n" + said).partition("\nerror: ")
    if not found:
        last = said.strip().splitlines()[-1:] or ["it said nothing"]
        return f"the program ended with {code}: {last[0]}"
    # What follows is how the command is called.
    return with_arguments(message.split("\n\n")[0].strip())


def with_arguments(text: str) -> str:
    """A message with this package's arguments in place of the program's options: `--jobs 1` is ``jobs=1``."""

    def argument(option: "re.Match[str]") -> str:
        name, value = option.groups()
        value = value or ("True" if name in SWITCHES else None)
        return name.replace("-", "_") + (f"={value}" if value else "")

    return OPTION.sub(argument, text)
