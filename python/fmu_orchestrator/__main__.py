"""The command ``orchestrator`` of an installed package: the program, which also finds the package's own studies."""

import os
import signal
import subprocess
import sys

from . import _convert, _system
from ._errors import OrchestratorError
from ._files import program, study_path

# Commands whose first argument is no study; that of every analysis is one.
OTHERS = {"inspect", "check", "init", "simulate", "merge", "compare", "completion", "manual", "report", "synchronise", "help"}


def arguments(given: list[str]) -> list[str]:
    """The program's arguments: ``verify paper-table3`` becomes the path of that study, where no such file exists."""
    match given:
        case [command, study, *rest] if command not in OTHERS and not study.startswith("-"):
            return [command, str(study_path(study)), *rest]
    return given


def main() -> int:
    """Becomes the program; ``convert`` and ``system`` are the package's own."""
    try:
        own = {"convert": _convert.main, "system": _system.main}.get("".join(sys.argv[1:2]))
        if own:
            return own(sys.argv[2:])
        command = [str(program()), *arguments(sys.argv[1:])]
    except OrchestratorError as error:
        print(f"error: {error}", file=sys.stderr)
        return 2
    if os.name == "nt":
        # Ctrl-C is for the program, which puts things in order first.
        signal.signal(signal.SIGINT, signal.SIG_IGN)
        return subprocess.call(command)
    os.execv(command[0], command)


if __name__ == "__main__":
    sys.exit(main())
