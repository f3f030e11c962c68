"""A study as a function of arrays."""

import tempfile
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol

from ._errors import OrchestratorError

if TYPE_CHECKING:
    import numpy
    from numpy.typing import ArrayLike, NDArray

    from ._table import Table


class Verified(Protocol):
    """What a function reads of a finished study."""

    @property
    def points(self) -> "Table":
        """A row a point."""


class Verifiable(Protocol):
    """What a function needs of a study."""

    @property
    def parameters(self) -> list[str]:
        """The parameters that vary."""

    @property
    def criteria(self) -> list[str]:
        """The criteria."""

    @property
    def verify(self) -> Callable[..., Verified]:
        """Simulates points, as `Study.verify` does."""


class StudyFunction:
    """``Y = f(X)``: a row of X is a point, in the study's units; a row of Y its criteria's values. Needs numpy.

    One point may be given as a vector, and becomes a vector. Where ``outputs`` is one name, a point has a number. Points
    that fail are NaN. Each call simulates its points on all cores, so one call with many points is quicker than many
    calls.
    """

    def __init__(
        self,
        study: Verifiable,
        inputs: Iterable[str] | None,
        outputs: str | Iterable[str] | None,
        others: Mapping[str, float],
        running: Mapping[str, Any],
    ) -> None:
        self._study = study
        self._running = running
        self._single = isinstance(outputs, str)
        self.others = dict(others)
        """Values of the parameters that are no inputs."""
        names = study.parameters
        self.inputs = [name for name in names if name not in others] if inputs is None else _listed(inputs)
        """The names of X's columns."""
        self.outputs = study.criteria if outputs is None else _listed(outputs)
        """The names of Y's columns."""
        _check("parameter", [*self.inputs, *self.others], names, study)
        _check("criterion", self.outputs, study.criteria, study)
        missing = [name for name in names if name not in self.inputs and name not in self.others]
        if missing:
            raise OrchestratorError(f"{study}: give `others` values for {', '.join(missing)}, or make them inputs")

    def __call__(self, x: "ArrayLike") -> "NDArray[numpy.float64]":
        """The outputs at points."""
        import numpy

        given = numpy.asarray(x, dtype=numpy.float64)
        points = numpy.atleast_2d(given)
        if points.ndim != 2 or points.shape[1] != len(self.inputs):
            raise ValueError(f"X has the shape {given.shape}; its columns are {', '.join(self.inputs)}")
        found = self._values(points) if len(points) else numpy.empty((0, len(self.outputs)))
        if self._single:
            found = found[:, 0]
        return found[0] if given.ndim < 2 else found

    def _values(self, points: "NDArray[numpy.float64]") -> "NDArray[numpy.float64]":
        columns: dict[str, Any] = {name: points[:, k] for k, name in enumerate(self.inputs)}
        columns |= {name: [value] * len(points) for name, value in self.others.items()}
        running = {"progress": False, **self._running}
        with tempfile.TemporaryDirectory(prefix="points-") as folder:
            # Whether values rest is no question of a single call.
            result = self._study.verify(points_from=columns, output=Path(folder) / "run", extra_runs=0, **running)
            return result.points.to_numpy(self.outputs)

    def __repr__(self) -> str:
        return f"<StudyFunction {', '.join(self.inputs)} -> {', '.join(self.outputs)}>"


def _listed(names: str | Iterable[str]) -> list[str]:
    return [names] if isinstance(names, str) else list(names)


def _check(kind: str, names: list[str], known: list[str], study: Verifiable) -> None:
    for name in names:
        if name not in known:
            raise OrchestratorError(f"{study}: no {kind} `{name}`; there are {', '.join(known)}")
