"""Studies: loaded, verified, analysed."""

import os
import tempfile
import tomllib
from collections.abc import Iterable, Mapping
from copy import deepcopy
from hashlib import sha256
from pathlib import Path
from typing import Any, Literal, TypedDict, Unpack

from . import _toml
from ._errors import OrchestratorError
from ._files import study_path
from ._function import StudyFunction
from ._program import Done, Value, flags, run, warn
from ._progress import Progress, Show
from ._results import Identification, Pareto, Robustness, Sensitivity, Tolerances, Verification, told
from ._table import Given, csv_of, given
from ._toml import Keep, changed, placed, refuse_unknown

# Exit codes that are answers: verified or done, not verified, inconclusive.
ANSWERS = (0, 1, 3)
StrPath = str | os.PathLike[str]
# The first line of studies that are no files, so that they are known again where a run could not begin.
MARK = "# Written by the Python package: this study is no file of its own.\n"
# A finished study, or its folder.
Points = Verification | StrPath


class Running(TypedDict, total=False):
    """How the points of a study run; as the options of the command line."""

    fmu: StrPath | None
    """The FMU, instead of the study's."""
    jobs: int | None
    """The number of parallel simulations; the number of cores unless given."""
    isolation: Literal["fresh", "shared", "none"] | None
    """Whether points run alone (``fresh``, unless given), share processes, or run in the program's own (``none``)."""
    point_timeout: float | None
    """The longest time that a point may take, s."""
    memory_limit: str | None
    """The most memory that a worker may take, such as ``500MB``."""
    launcher: str | None
    """The command that starts each of ``jobs`` workers elsewhere, such as ``srun -n1 -c1`` or ``ssh node7``."""
    hosts: StrPath | None
    """A file with a line a host and the number of its workers; ``{host}`` in the command becomes the name."""
    ship: bool
    """Sends the FMU to hosts that do not share the disk."""
    worker_program: StrPath | None
    """The program on the hosts; this one's path unless given."""
    launcher_timeout: float | None
    """How long a worker there may take to start, and be silent, s."""
    resume: bool
    """Continues a run that was interrupted."""
    force: bool
    """Replaces results of another study file or FMU."""
    progress: Show | bool | None
    """A function of the points done and their number, which may be None; False shows nothing. Unless given, a terminal
    and a notebook show a bar, and where neither is standard error gets a line every ten seconds."""


class Study:
    """A study: an FMU, its uncertain parameters, and the criteria that it has to meet.

    >>> study = Study({
    ...     "fmu": "my.fmu",
    ...     "simulation": {"stop": 10, "step": 0.01},
    ...     "parameters": {"mass": {"distribution": "uniform", "min": 0.9, "max": 1.1, "unit": "kg"}},
    ...     "criteria": {"x": {"variable": "position", "statistic": "max", "nominal": 1.2, "tolerance": "5 %"}},
    ... })
    """

    def __init__(self, content: Mapping[str, Any] | str, *, name: str = "study", folder: StrPath | None = None) -> None:
        """``content`` as a mapping or as TOML. Files that it names are relative to ``folder``, the present one unless
        given."""
        self.name = name
        """What the folder of results is called by."""
        self.path: Path | None = None
        """The study's file, where it has one."""
        self.folder = Path.cwd() if folder is None else Path(folder).absolute()
        """The folder to which the names of files are relative."""
        self.content: dict[str, Any] = deepcopy(dict(_parsed(content) if isinstance(content, str) else content))
        """The content, as TOML has it; where TOML names the file of a table, the table itself may stand. What is changed here
        changes what runs."""
        self._read: dict[str, Any] | None = None
        self._temporary: tempfile.TemporaryDirectory[str] | None = None

    @classmethod
    def load(cls, path: StrPath) -> "Study":
        """Opens the TOML file of a study. ``"paper-table3"`` and other names of `shipped_studies` open these.

        As long as `content` is as it was read, the file itself runs, in the text that it then has.
        """
        file = study_path(path).absolute()
        try:
            content = tomllib.loads(file.read_text(encoding="utf-8"))
        except OSError as error:
            raise OrchestratorError(f"{file}: {error.strerror}") from error
        except ValueError as error:
            raise OrchestratorError(f"{file}: {error}") from error
        study = cls(content, name=file.stem, folder=file.parent)
        study.path, study._read = file, content
        return study

    def with_(self, *, points: int | None = None, seed: int | None = None, **changes: Any) -> "Study":
        """Another study, which differs in some values: ``study.with_(points=200, **{"criteria.T.nominal": 81.5})``.

        ``points`` and ``seed`` are those of the design. Other names are dotted, as in TOML; None takes a key out. A name that
        no study knows is refused.
        """
        design = {f"design.{name}": value for name, value in (("points", points), ("seed", seed)) if value is not None}
        content = changed(self.content, design | changes)
        refuse_unknown(self.content, content, changes)
        return Study(content, name=self.name, folder=self.folder)

    def __getitem__(self, section: str) -> Any:
        """A part of the content: ``study["design"]["points"] = 200``."""
        return self.content[section]

    def __setitem__(self, section: str, value: Any) -> None:
        self.content[section] = value

    def save(self, path: StrPath) -> "Study":
        """Writes the study into a TOML file, for the command line, and opens that."""
        file = Path(path)
        content = placed(self.content, self.folder, lambda table: given(table, file.parent))
        file.write_text(_toml.text(content), encoding="utf-8")
        return Study.load(file)

    @property
    def parameters(self) -> list[str]:
        """The parameters that vary."""
        known = self.content.get("parameters", {})
        return [name for name, parameter in known.items() if parameter.get("distribution") != "fixed"]

    @property
    def criteria(self) -> list[str]:
        """The criteria."""
        return list(self.content.get("criteria", {}))

    def verify(
        self,
        *,
        points: int | None = None,
        seed: int | None = None,
        output: StrPath | None = None,
        points_from: Given | None = None,
        until: str | None = None,
        budget: int | None = None,
        validation: bool = False,
        extra_runs: int | None = None,
        **running: Unpack[Running],
    ) -> Verification:
        """Simulates the points and judges them.

        ``points`` and ``seed`` replace the study's. ``points_from`` simulates given points instead: a file, a table of
        pandas, polars or pyarrow, or a mapping from names to values. ``until``, such as ``"verdict"`` or ``"ci 0.01"``,
        ends when enough is known. ``budget`` runs the FMU at most so often, at chosen points. ``output`` is the folder, ``results/`` and the study's name unless given.
        """
        folder = self._folder(output)
        table = None if points_from is None else given(points_from, folder)
        options: dict[str, Value] = {"points": points, "seed": seed, "points_from": table, "until": until}
        options["budget"] = budget
        options |= {"validation": validation, "extra_runs": extra_runs}
        done = self._run("verify", folder, options, running)
        return told(Verification(folder, done.text), done.said)

    def judge(self, table: Given, *, output: StrPath | None = None, force: bool = False) -> Verification:
        """Applies the criteria to outputs in a table, without simulating: a file, or columns as `verify` takes them.

        Without ``output`` the results are kept as long as the object is.
        """
        keep = tempfile.TemporaryDirectory(prefix="judged-") if output is None else None
        folder = Path(keep.name if keep else output or "")
        with tempfile.TemporaryDirectory(prefix="table-") as place:
            file = given(table, Path(place))
            forced = ["--force"] if force else []
            done = run("judge", self._file(folder, force=force), file, f"--output={folder}", *forced, results=ANSWERS)
        return told(Verification(folder, done.text, keep), done.said)

    def sensitivity(
        self,
        points_of: Points | None = None,
        *,
        base: int | None = None,
        morris: int | None = None,
        budget: int | None = None,
        seed: int | None = None,
        output: StrPath | None = None,
        **running: Unpack[Running],
    ) -> Sensitivity:
        """Tells which parameter matters: Sobol indices of ``base`` points, or screening by ``morris`` trajectories.
        ``budget`` is the most runs, from which a surrogate tells Sobol indices and Shapley effects; the latter take correlated
        parameters, too. ``points_of`` takes the points of a finished study instead, without a further run.
        """
        source, folder = self._folders(points_of, output)
        options: dict[str, Value] = {"from": source, "base": base, "morris": morris}
        options |= {"budget": budget, "seed": seed}
        done = self._run("sensitivity", folder, options, running, state="sensitivity")
        return Sensitivity(folder, done.text)

    def identify(
        self,
        points_of: Points | None = None,
        *,
        starts: int | None = None,
        posterior: int | None = None,
        budget: int | None = None,
        against: StrPath | None = None,
        seed: int | None = None,
        output: StrPath | None = None,
        **running: Unpack[Running],
    ) -> Identification:
        """Finds the parameters that make the measured values most probable; the study needs a section ``[identify]``.

        ``posterior`` draws so many sets of parameters from the posterior into ``posterior.csv``. ``budget`` is the most runs,
        of which a surrogate is made, with the points of a finished study where ``points_of`` names one: the result stands in its
        folder then. ``against``
        weighs the model against that of another result on the same data.
        """
        if points_of is not None and budget is None:
            raise OrchestratorError("identify(points_of=...) needs budget=N, the most runs; without one leave points_of out")
        source, folder = self._folders(points_of, output)
        if source is not None and folder != source:
            raise OrchestratorError("identify(points_of=...) writes into the folder of the points; leave output out")
        options: dict[str, Value] = {"starts": starts, "posterior": posterior, "budget": budget}
        options["seed"] = seed
        options["against"] = None if against is None else os.path.abspath(against)
        done = self._run("identify", folder, options, running, state="identify")
        found = Identification(folder, done.text)
        for doubt in found.doubts:
            warn(doubt)
        return found

    def robustness(
        self,
        points_of: Points | None = None,
        *,
        level: float | None = None,
        confirm: int | None = None,
        budget: int | None = None,
        seed: int | None = None,
        output: StrPath | None = None,
        **running: Unpack[Running],
    ) -> Robustness:
        """Tells how far parameters may move, from the points of a finished study.

        ``level`` is the verification probability that the box must hold; ``confirm`` runs so many new points in it,
        ``budget`` those that are left of so many in the folder.
        """
        source, folder = self._folders(points_of, output)
        # The program looks where the study's name says; a study that was changed here has another folder.
        source = source or self._folder(None)
        options: dict[str, Value] = {"from": source, "level": level, "confirm": confirm, "budget": budget, "seed": seed}
        done = self._run("robustness", folder, options, running, state="robustness")
        return Robustness(folder, done.text)

    def tolerances(
        self,
        points_of: Points | None = None,
        *,
        points: int | None = None,
        confirm: int | None = None,
        budget: int | None = None,
        seed: int | None = None,
        output: StrPath | None = None,
        **running: Unpack[Running],
    ) -> Tolerances:
        """Finds the widest tolerances of the parameters at which the model still conforms; the section ``[verdict]`` or
        ``[tolerances]`` states the wanted share. The points of a finished study are used first; with ``budget`` a surrogate of
        them finds, and the runs that are left of so many in the folder confirm."""
        source, folder = self._folders(points_of, output)
        options: dict[str, Value] = {"from": source, "points": points, "confirm": confirm, "budget": budget, "seed": seed}
        done = self._run("tolerances", folder, options, running, state="tolerances")
        return Tolerances(folder, done.text)

    def pareto(
        self,
        points_of: Points | None = None,
        *,
        output: StrPath | None = None,
        force: bool = False,
    ) -> Pareto:
        """Shows the trade-off between criteria among the points of a finished study."""
        source, folder = self._folders(points_of, output)
        options: dict[str, Value] = {"from": source or self._folder(None)}
        done = self._run("pareto", folder, options, {"force": force})
        return Pareto(folder, done.text)

    def function(
        self,
        inputs: Iterable[str] | None = None,
        outputs: str | Iterable[str] | None = None,
        *,
        others: Mapping[str, float] | None = None,
        **running: Unpack[Running],
    ) -> StudyFunction:
        """The study as a function of arrays, for SALib, OpenTURNS, scipy and whatever else calls ``f(X)``."""
        return StudyFunction(self, inputs, outputs, others or {}, running)

    @property
    def _is_file(self) -> bool:
        try:
            return self.path is not None and self.content == self._read
        except ValueError:  # A table that stands for a file does not compare with its name.
            return False

    def _folder(self, output: StrPath | None) -> Path:
        if output is not None:
            return Path(output)
        # Another content gets another folder, so that earlier results stay what they are.
        mark = "" if self._is_file else f"-{sha256(self._text(lambda table: sha256(csv_of(table)).hexdigest()).encode()).hexdigest()[:8]}"
        return Path("results", f"{self.name}{mark}")

    def _text(self, keep: Keep) -> str:
        return MARK + _toml.text(placed(self.content, self.folder, keep))

    def _file(self, folder: Path, *, force: bool = False) -> Path:
        """The file that the program reads: the study's own, or its content in the folder of the results."""
        if self.path is not None and self._is_file:
            return self.path
        text, file = self._text(lambda table: given(table, folder)), folder / "study.toml"
        if not force and not _is_free(file, text):
            # The program then says what the folder holds.
            self._temporary = tempfile.TemporaryDirectory(prefix="study-")
            file = Path(self._temporary.name) / "study.toml"
        try:
            file.parent.mkdir(parents=True, exist_ok=True)
            file.write_text(text, encoding="utf-8")
        except OSError as error:
            raise OrchestratorError(f"{file}: {error.strerror}") from error
        return file

    def _folders(self, points_of: Points | None, output: StrPath | None) -> tuple[Path | None, Path]:
        """The folder of the points that an analysis uses, where one is given, and that of its results."""
        if points_of is None:
            return None, self._folder(output)
        source = points_of.folder if isinstance(points_of, Verification) else Path(points_of)
        return source, source if output is None else Path(output)

    def _run(
        self, command: str, folder: Path, options: Mapping[str, Value], running: Running, state: str = ""
    ) -> Done:
        settings: dict[str, Any] = {**running}
        show = settings.pop("progress", None)
        progress = Progress(folder / state, bool(settings.get("resume")), show)
        try:
            return run(
                command,
                self._file(folder, force=bool(settings.get("force"))),
                f"--output={folder}",
                *flags({**options, **settings}),
                results=ANSWERS,
                folder=folder,
                look=progress.look,
            )
        finally:
            progress.end()

    def __repr__(self) -> str:
        return f"<Study {self}: {len(self.parameters)} parameters, {len(self.criteria)} criteria>"

    def __str__(self) -> str:
        return str(self.path) if self.path is not None and self._is_file else self.name


def _parsed(text: str) -> dict[str, Any]:
    if "=" not in text:
        raise OrchestratorError(f"{text!r} is no content of a study; Study.load opens a file")
    try:
        return tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise OrchestratorError(f"study: {error}") from error


def _is_free(file: Path, text: str) -> bool:
    """Whether a study may be written there: nothing is there, the study itself, or one that has not run."""
    try:
        there = file.read_text(encoding="utf-8")
    except FileNotFoundError:
        return True
    except (OSError, ValueError):
        return False
    return there == text or (there.startswith(MARK) and not (file.parent / "request.json").exists())
