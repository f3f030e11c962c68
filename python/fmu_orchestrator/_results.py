"""Results of studies, read from the folders that the program writes."""

import json
import os
import tempfile
import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from numbers import Integral
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from . import _html, _plot
from ._errors import OrchestratorError
from ._program import run, units_of_fmu, warn
from ._table import Kind, Table, read

if TYPE_CHECKING:
    from matplotlib.figure import Figure

VerdictName = Literal["verified", "not verified", "inconclusive"]
Interval = tuple[float, float]
Keep = tempfile.TemporaryDirectory[str] | None


def load_json(path: Path) -> Any:
    """The content of a file of results."""
    try:
        return json.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise OrchestratorError(f"{path}: {error.strerror}") from error
    except ValueError as error:
        raise OrchestratorError(f"{path}: {error}") from error


def interval(found: Any) -> Interval | None:
    """An interval, where there is one."""
    return None if found is None else (float(found[0]), float(found[1]))


# Points that a notebook draws unasked.
MOST_SHOWN = 100_000


def units_of_curves(folder: Path) -> dict[str, str]:
    """The units of the values of the criteria's curves, by name: those that the study that was run into a folder states, else
    the FMU's."""
    study = tomllib.loads((folder / "study.toml").read_text(encoding="utf-8"))
    known = dict(study.get("criteria", {}))
    for case in study.get("cases", []):
        own = {**study.get("criteria", {}), **case.get("criteria", {})}
        known |= {f"{case['name']}/{name}": criterion for name, criterion in own.items()}
    of_fmu = units_of_fmu(load_json(folder / "request.json")["fmu"])
    return {name: unit for name, one in known.items() if (unit := one.get("unit") or of_fmu.get(one.get("variable", name)))}


@dataclass(frozen=True)
class Requirement:
    """The share that the section ``[verdict]`` of a study requires, and the one that was found."""

    share: float
    """The required share of the sampled space, from 0 to 1."""
    confidence: float
    """The confidence at which it must be known."""
    interval: Interval | None
    """The interval of the accepted share at that confidence."""
    points_needed: int | None
    """Where the points do not tell: about how many would, in a study of its own."""


@dataclass(frozen=True)
class Risks:
    """The global risks of JCGM 106:2012: probabilities over the sampled points and the measured values' errors."""

    consumer: float
    """A point is accepted and does not conform."""
    producer: float
    """A point conforms and is rejected."""
    conformance_probability: float
    """A point conforms."""
    not_conforming_given_accepted: float
    """An accepted point does not conform; NaN where no point is accepted."""
    intervals: Mapping[str, Interval | None]
    """Their 95 % intervals, by name."""


@dataclass(frozen=True)
class Verdict:
    """The answer of a study."""

    name: VerdictName
    rule: Literal["one point", "share"]
    """How it was found: one point that meets all criteria is enough, or a share of the sampled space must."""
    words: str
    """Both in words."""
    doubtful: bool
    """Whether something makes it doubtful: the first screen's sign is then another than that of the verdict."""
    points: int
    failed: int
    verified: int
    """Points that meet all criteria."""
    accepted: int
    """Points that a guard band accepts, too; without one the same number."""
    share: float
    """The share of verified points, from 0 to 1."""
    interval: Interval | None
    """Its 95 % interval; none of points that depend on each other."""
    shares: Mapping[str, float]
    """The share of points that meet a criterion, by its name."""
    required: Requirement | None
    """Only for the rule ``share``."""
    risks: Risks | None
    """Of all criteria together; none unless each of them has an uncertainty."""

    def __str__(self) -> str:
        return f"{self.words}, with doubts" if self.doubtful else self.words


def verdict(summary: Mapping[str, Any]) -> Verdict:
    """The verdict of a ``summary.json``."""
    return Verdict(
        name=summary["verdict"],
        rule=summary["rule"],
        words=summary["verdict_words"],
        doubtful=_html.sign(summary) != _html.PLAIN[summary["verdict"]],
        points=summary["points"],
        failed=summary["failed"],
        verified=summary["verified"],
        accepted=summary["accepted"],
        share=summary["verified_fraction"],
        interval=interval(summary["verified_interval"]),
        shares={name: count["fraction"] for name, count in summary["criteria"].items()},
        required=_requirement(summary["required"]),
        risks=_risks(summary["risk"]),
    )


def _requirement(found: Any) -> Requirement | None:
    if found is None:
        return None
    return Requirement(found["share"], found["confidence"], interval(found["interval"]), found.get("points_needed"))


def _risks(found: Any) -> Risks | None:
    if found is None:
        return None
    def number(name: str) -> float:
        return float("nan") if found[name] is None else float(found[name])

    return Risks(
        consumer=number("consumer"),
        producer=number("producer"),
        conformance_probability=number("conformance_probability"),
        not_conforming_given_accepted=number("not_conforming_given_accepted"),
        intervals={name: interval(limits) for name, limits in (found["intervals"] or {}).items()},
    )


def told(result: "Verification", said: str) -> "Verification":
    """Passes doubts about a verdict on as warnings, but for those that the program said while it ran."""
    remarks = said.splitlines()
    for doubt in _html.doubts(result.summary):
        if not any(remark.endswith(doubt) for remark in remarks):
            warn(doubt)
    return result


class Verification:
    """A study that was verified, or a table that was judged; all of it is in ``folder``."""

    def __init__(self, folder: str | os.PathLike[str], text: str = "", keep: Keep = None) -> None:
        self.folder = Path(folder)
        self.text = text
        """The text that the command line prints."""
        self.summary: dict[str, Any] = load_json(self.folder / "summary.json")
        """The content of ``summary.json``."""
        try:
            self.verdict = verdict(self.summary)
        except KeyError as missing:
            path = self.folder / "summary.json"
            raise OrchestratorError(f"{path}: no {missing}, as an earlier version wrote it; verify the study again") from None
        # The folder of a judgement that nobody wants to keep lives as long as its result.
        self._keep = keep

    @classmethod
    def load(cls, folder: str | os.PathLike[str]) -> "Verification":
        """The results that ``orchestrator verify`` has written into a folder."""
        return cls(folder)

    @cached_property
    def points(self) -> Table:
        """A row a point: its number, parameters, the criteria's values in the study's units, ``NAME.ok``, ``verified``,
        where a guard band acts ``accepted``, where uncertainties are stated ``conformance``, and ``status``."""
        return read(self.folder / "points.csv", self._kinds, self._units())

    def _units(self) -> dict[str, str]:
        """The units of parameters and criteria."""
        named = [*self.summary["parameters"], *({**count, "name": name} for name, count in self.summary["criteria"].items())]
        return {one["name"]: one["unit"] for one in named if one.get("unit")}

    def _kinds(self, header: Sequence[str]) -> list[Kind]:
        """The types of the columns of ``points.csv``."""
        numbers = 1 + len(self.summary["parameters"]) + len(self.summary["criteria"])
        kinds: list[Kind] = ["count"]
        kinds += ["number"] * (numbers - 1)
        kinds += ["number" if name == "conformance" else "flag" for name in header[numbers:-1]]
        return [*kinds, "text"]

    @property
    def report(self) -> Path:
        """The page with all results, which needs nothing else than a browser."""
        return self.folder / "report.html"

    @property
    def best_point(self) -> dict[str, Any] | None:
        """The point nearest to the measurement: its number, ``parameters`` and ``values``."""
        best: dict[str, Any] | None = self.summary["best_point"]
        return best

    def replay(self, point: float | Mapping[str, Any], case: str | None = None) -> Table:
        """Simulates one point again, by its number or as `best_point` has it: its trajectory, a row a communication point. Of a
        study with cases, that of one of them."""
        number = point.get("point") if isinstance(point, Mapping) else point
        if not isinstance(number, Integral) and not (isinstance(number, float) and number.is_integer()):
            raise OrchestratorError(f"replay: {number} is no number of a point")
        point = int(number)
        path = self.folder / f"point-{point}.csv"
        options = [f"--output={path}"] + ([f"--case={case}"] if case is not None else [])
        # 1 says that the point does not meet all criteria.
        run("replay", self.folder, str(point), *options, results=(0, 1))
        return read(path, units=lambda: units_of_fmu(load_json(self.folder / "request.json")["fmu"]))

    @cached_property
    def curves(self) -> Table | None:
        """The measured curves of a study that has some, columns ``criterion``, ``time`` (s), ``value``,
        ``uncertainty``."""
        path = self.folder / "measured-curves.csv"
        return read(path, units={"time": "s"}) if path.exists() else None

    def plot(self, x: str | None = None, y: str | None = None) -> "Figure":
        """A picture: the cloud of points, and a histogram of each criterion with its accepted range.

        ``x`` and ``y`` are the columns of the cloud; unless given, the two parameters that differ most between points that
        are accepted and others. Needs matplotlib.
        """
        return _plot.points(self.points, self.summary, x, y)

    def plot_curves(self) -> "Figure":
        """A picture of each measured curve with its uncertainty and the nearest
        point. Needs matplotlib."""
        if self.curves is None:
            raise OrchestratorError(f"{self.folder}: the study compares no measured curves")
        nearest = [read(path) for path in sorted(self.folder.glob("best-point*.csv"))]
        return _plot.curves(self.curves, nearest, self.summary, units_of_curves(self.folder))

    def sensitivity(self) -> "Sensitivity":
        """Which parameter matters, as `Study.sensitivity` has found and written into this folder."""
        if not (self.folder / Sensitivity.file).exists():
            raise OrchestratorError(f"{self.folder} holds no indices: Study.sensitivity(output={str(self.folder)!r}) finds them")
        return Sensitivity(self.folder)

    def plot_sensitivity(self) -> "Figure":
        """A picture of `sensitivity`. Needs matplotlib."""
        return self.sensitivity().plot()

    @property
    def cases(self) -> dict[str, Any]:
        """By the names of the cases: ``passed``, ``fraction``, ``interval``, ``failed``, ``held_out``, ``criteria``. Empty
        for a study without cases."""
        cases: dict[str, Any] = self.summary.get("cases", {})
        return cases

    def __repr__(self) -> str:
        return f"<Verification: {_html.headline(self.summary)[:-1]}; {self.folder}>"

    def __str__(self) -> str:
        """What the terminal shows; of results that were read from a folder the verdict and its warnings."""
        doubts = (f"warning: {doubt}" for doubt in _html.doubts(self.summary))
        return self.text.rstrip() or "\n".join([_html.headline(self.summary), *doubts])

    def _repr_html_(self) -> str:
        # Reading a million points takes longer than a glance at the answer may.
        pictures: list[_html.Draw] = [self.plot] if self.verdict.points <= MOST_SHOWN else []
        pictures += [self.plot_curves] if self.curves is not None else []
        return _html.verification(self.summary, self.text, pictures, self.report)


class Analysis:
    """The result of an analysis; all of it is in ``folder``."""

    file = ""

    def __init__(self, folder: str | os.PathLike[str], text: str = "") -> None:
        self.folder = Path(folder)
        self.text = text
        """The text that the command line prints."""
        self.data: dict[str, Any] = load_json(self.folder / self.file)
        """The content of the file of results."""

    def __repr__(self) -> str:
        return f"<{type(self).__name__}: {self.folder / self.file}>"

    def _repr_html_(self) -> str:
        return _html.text(self.text or repr(self)) + _html.drawn(self._pictures()) + _html.page(self.folder / "report.html")

    def _pictures(self) -> "list[_html.Draw]":
        return []


class Sensitivity(Analysis):
    """Which parameter matters."""

    file = "sensitivity.json"

    @property
    def parameters(self) -> list[str]:
        """The parameters, in the order of all lists in ``data``."""
        return list(self.data["parameters"])

    @property
    def outputs(self) -> dict[str, dict[str, Any]]:
        """The results by output: the criteria, ``verified``, and where runs failed ``failed``."""
        return {output["name"]: output for output in self.data["outputs"]}

    @property
    def dominant(self) -> dict[str, str | None]:
        """The parameter that matters most, by output; None where the intervals overlap."""
        return {name: output["dominant"] for name, output in self.outputs.items()}

    def indices(self, output: str, order: Literal["first", "total"] = "total") -> dict[str, float]:
        """The Sobol indices of an output, by parameter."""
        found = self.outputs[output].get("sobol")
        if found is None:
            raise OrchestratorError(f"{self.folder}: no Sobol indices of {output}; use base=256")
        return {name: estimate["value"] for name, estimate in zip(self.parameters, found[order], strict=True)}

    @cached_property
    def runs(self) -> Table:
        """The runs in the order of their design, for the methods of other libraries."""
        return read(self.folder / "sensitivity-runs.csv", units=self.data.get("units"))

    def plot(self) -> "Figure":
        """A picture: for each output the parameters that matter most, with 95 % intervals. Needs matplotlib."""
        return _plot.effects(self.parameters, self.data["outputs"], self.data.get("units", {}))

    def _pictures(self) -> "list[_html.Draw]":
        return [self.plot]


@dataclass(frozen=True)
class Estimate:
    """An identified parameter, in the study's unit."""

    value: float
    deviation: float
    """One standard deviation: a difference, or on a logarithmic scale a factor."""
    interval: Interval | None
    """It holds the value with a probability of 95 %."""
    unit: str | None


@dataclass(frozen=True)
class Optimum:
    """A set of parameters that could be the right one."""

    weight: float
    """Its part of the posterior probability of all that were found."""
    parameters: dict[str, Estimate]


class Identification(Analysis):
    """The parameters that make the measured values most probable."""

    file = "identification.json"

    @property
    def converged(self) -> bool:
        """Whether the search has converged. Where it has not, ``data["end"]`` says what ended it."""
        return bool(self.data["end"] == "converged")

    @property
    def doubts(self) -> list[str]:
        """What speaks against the values found, a sentence each; Python warns of it, too."""
        found = _html.doubts(self.data)
        if self.data.get("fit") == "misses":
            found.append("The model misses the measured values by more than their uncertainties allow; `text` says by how much.")
        posterior = self.data.get("posterior") or {}
        if not posterior.get("trusted", True):
            found.append(f"The posterior is not to be trusted: {'; '.join(posterior['doubts'])}.")
        return found

    @property
    def causes(self) -> list[str]:
        """What would explain that the model misses, a sentence each, the likeliest first; or that the parameters alone do."""
        return list(self.data.get("causes", []))

    @property
    def optima(self) -> list[Optimum]:
        """All sets of parameters that could be the right one, the most probable first. Where there are several, none of
        them is *the* value."""
        return [Optimum(optimum["weight"], _estimates(optimum["free"])) for optimum in self.data["optima"]]

    @property
    def parameters(self) -> dict[str, Estimate]:
        """The free parameters at the first optimum; see `optima` whether it is the only one."""
        return _estimates(self.data["free"])

    @cached_property
    def posterior(self) -> Table:
        """Sets of parameters drawn from the posterior, a row each; ``identify(posterior=1000)`` draws them."""
        path = self.folder / "posterior.csv"
        if self.data.get("posterior") is None or not path.exists():
            raise OrchestratorError(f"{self.folder}: no posterior was drawn; identify(posterior=1000) draws one")
        return read(path, units={one["name"]: one["unit"] for one in self.data["free"]})

    def plot(self) -> "Figure":
        """A picture of the posterior where one was drawn: each parameter's histogram with its 95 % interval, and each pair;
        else the identified values with their intervals. Needs matplotlib."""
        drawn = self.data.get("posterior")
        return _plot.posterior(self.posterior, drawn["free"], drawn) if drawn else _plot.estimates(self.optima)

    def _pictures(self) -> "list[_html.Draw]":
        return [self.plot]


def _estimates(free: list[Any]) -> dict[str, Estimate]:
    return {
        one["name"]: Estimate(one["value"], one["deviation"], interval(one["interval"]), one["unit"]) for one in free
    }


class Robustness(Analysis):
    """How far parameters may move."""

    file = "robustness.json"


class Tolerances(Analysis):
    """The widest tolerances of the parameters at which the model still conforms."""

    file = "tolerances.json"


class Pareto(Analysis):
    """The trade-off between criteria."""

    file = "pareto.json"
