"""The example notebook runs from its first cell to its last, and shows what it says."""

import os

import nbformat
from nbclient import NotebookClient
from test_acceptance import PROGRAM, ROOT

NOTEBOOK = ROOT / "examples" / "notebook" / "verification.ipynb"


def test_the_notebook(fmu, tmp_path, monkeypatch):
    monkeypatch.setenv("FMU_ORCHESTRATOR_PROGRAM", str(PROGRAM))
    monkeypatch.setenv("PYTHONPATH", str(ROOT / "python"))
    # The kernel's settings are not the user's.
    monkeypatch.setenv("IPYTHONDIR", str(tmp_path / "ipython"))
    notebook = nbformat.read(NOTEBOOK, as_version=4)
    assert all(not cell.outputs for cell in notebook.cells if cell.cell_type == "code"), "clear the outputs"
    NotebookClient(notebook, timeout=300, kernel_name="python3", resources={"metadata": {"path": str(tmp_path)}}).execute()
    shown = {cell.id: cell.outputs for cell in notebook.cells if cell.cell_type == "code"}
    html = [data for outputs in shown.values() for output in outputs
            if (data := output.get("data", {}).get("text/html"))]
    report = next(data for data in html if "iframe" in data)
    assert "by the one-point rule" in report and "bearing.radialClearance" in report
    assert sum("image/png" in output.get("data", {}) for outputs in shown.values() for output in outputs) == 2
    assert os.path.exists(tmp_path / "results/paper-table3/report.html")
