"""The example notebook runs from its first cell to its last, and shows what it says."""

import os

import nbformat
import pytest
from nbclient import NotebookClient
from test_acceptance import PROGRAM, ROOT

# What the notebook draws, and fewer draws that show the same.
FEWER = {"sensitivity(base=128)": "sensitivity(base=16)", "posterior=400, starts=8": "posterior=200, starts=4"}
NOTEBOOK = ROOT / "examples" / "notebook" / "verification.ipynb"


@pytest.mark.parametrize("fewer", [FEWER, pytest.param({}, marks=pytest.mark.long)], ids=["fewer", "whole"])
def test_the_notebook(fewer, fmu, tmp_path, monkeypatch):
    monkeypatch.setenv("FMU_ORCHESTRATOR_PROGRAM", str(PROGRAM))
    monkeypatch.setenv("PYTHONPATH", str(ROOT / "python"))
    # The kernel's settings are not the user's.
    monkeypatch.setenv("IPYTHONDIR", str(tmp_path / "ipython"))
    notebook = nbformat.read(NOTEBOOK, as_version=4)
    assert all(not cell.outputs for cell in notebook.cells if cell.cell_type == "code"), "clear the outputs"
    for cell in notebook.cells:
        for much, little in fewer.items():
            cell.source = cell.source.replace(much, little)
    assert all(sum(little in cell.source for cell in notebook.cells) == 1 for little in fewer.values())
    NotebookClient(notebook, timeout=300, kernel_name="python3", resources={"metadata": {"path": str(tmp_path)}}).execute()
    if keep := os.environ.get("KEEP_NOTEBOOK"):
        nbformat.write(notebook, keep)
    outputs = [output for cell in notebook.cells if cell.cell_type == "code" for output in cell.outputs]
    html = "".join(output.get("data", {}).get("text/html", "") for output in outputs)
    assert "42 of 128 points" in html and html.count("data:image/png") == 2
    # The run, the sensitivity, the curves, the posterior: each once.
    assert sum("image/png" in output.get("data", {}) for output in outputs) == 4
    said = "".join(output.get("text", "") for output in outputs)
    before, after = (int(part.split(" %")[0].split("%")[0]) for part in said.split("before: ")[1].split("measured: "))
    # "more than twice as likely"
    assert 2.0 < after / before < 3.0, said
    assert not [output for output in outputs if output.output_type == "stream" and output.name == "stderr"]
    [page] = [path for path in tmp_path.glob("results/*/report.html") if str(path.relative_to(tmp_path)) in html]
    assert page.stat().st_size > 100_000
