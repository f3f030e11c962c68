"""Two results of a study, point by point."""

import os
import tempfile
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from . import _html
from ._program import run
from ._results import Verification, load_json

Result = str | os.PathLike[str] | Verification


@dataclass(frozen=True)
class Comparison:
    """What changed between two results."""

    same: bool
    """The same verdict, each point has its partner, and none changed sides beyond the numerical uncertainty."""
    differences: tuple[str, ...]
    warnings: tuple[str, ...]
    """Values that changed and stayed on their side, and changes of the study."""
    data: Mapping[str, Any]
    """All of ``compare.json``."""
    text: str

    def _repr_html_(self) -> str:
        return _html.text(self.text)


def compare(old: Result, new: Result, *, output: str | os.PathLike[str] | None = None) -> Comparison:
    """Compares two results of ``verify``: folders, or what ``Study.verify`` has returned. ``output`` keeps the page."""
    with tempfile.TemporaryDirectory(prefix="comparison-") as folder:
        into = Path(output or folder)
        done = run("compare", _folder(old), _folder(new), "--output", into, results=(0, 1))
        data = load_json(into / "compare.json")
    return Comparison(data["same"], tuple(data["differences"]), tuple(data["warnings"]), data, done.text)


def _folder(result: Result) -> str | os.PathLike[str]:
    return result.folder if isinstance(result, Verification) else result
