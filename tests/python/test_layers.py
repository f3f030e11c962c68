"""No files of the Python package import each other in a circle, not even for their types."""

import ast
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

import pytest

PACKAGE = Path(__file__).parents[2] / "python" / "fmu_orchestrator"


def imports(text: str) -> set[str]:
    """The modules of the same package that a file imports."""
    found = [node for node in ast.walk(ast.parse(text)) if isinstance(node, ast.ImportFrom) and node.level == 1]
    names = {alias.name for node in found if node.module is None for alias in node.names}
    return names | {node.module for node in found if node.module}


def test_no_circle():
    files = {file.stem: imports(file.read_text(encoding="utf-8")) for file in PACKAGE.glob("*.py")}
    assert "_study" in files["__init__"] and "_html" in files["_fmu"]
    list(TopologicalSorter(files).static_order())


def test_a_circle_is_found():
    with pytest.raises(CycleError):
        list(TopologicalSorter({"a": imports("from .b import x"), "b": imports("from . import a")}).static_order())
