"""Verifies FMUs of FMI 2.0 and 3.0 against measurements under uncertainty.

>>> from fmu_orchestrator import Study
>>> result = Study.load("paper-table3").verify(points=50)
>>> result.verdict.name
'verified'

The package holds the command-line program ``orchestrator`` and drives it: every result is the program's own, to the last
bit, and lies in the same files. ``docs/python.md`` in the repository describes the package.
"""

from ._compare import Comparison, compare
from ._errors import Interrupted, OrchestratorError, OrchestratorWarning
from ._files import program, shipped_fmu, shipped_recording, shipped_studies
from ._fmu import Check, Finding, check, inspect, simulate
from ._function import StudyFunction
from ._measured import Synchronised, init, synchronise
from ._results import (
    Analysis,
    Estimate,
    Identification,
    Optimum,
    Pareto,
    Requirement,
    Risks,
    Robustness,
    Sensitivity,
    Tolerances,
    Verdict,
    Verification,
)
from ._study import Study
from ._table import Table

__all__ = [
    "Analysis",
    "Check",
    "Comparison",
    "Estimate",
    "Finding",
    "Identification",
    "Interrupted",
    "Optimum",
    "OrchestratorError",
    "OrchestratorWarning",
    "Pareto",
    "Requirement",
    "Risks",
    "Robustness",
    "Sensitivity",
    "Study",
    "StudyFunction",
    "Synchronised",
    "Table",
    "Tolerances",
    "Verdict",
    "Verification",
    "check",
    "compare",
    "init",
    "inspect",
    "program",
    "shipped_fmu",
    "shipped_recording",
    "shipped_studies",
    "simulate",
    "synchronise",
]
