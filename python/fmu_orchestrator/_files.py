"""Where the program, the FMU and the studies are: in the installed package, or in the source tree."""

import os
from pathlib import Path

from ._errors import OrchestratorError

PACKAGE = Path(__file__).resolve().parent
# The wheel holds `studies/` and `dist/` side by side as the repository does, because a study names its FMU relative to
# itself.
HOME = PACKAGE if (PACKAGE / "studies").is_dir() else PACKAGE.parents[1]
VARIABLE = "FMU_ORCHESTRATOR_PROGRAM"
NAME = "orchestrator.exe" if os.name == "nt" else "orchestrator"


def program() -> Path:
    """The command-line program: the package's own, unless ``FMU_ORCHESTRATOR_PROGRAM`` names another one."""
    own = os.environ.get(VARIABLE)
    places = [Path(own)] if own else [PACKAGE / "bin" / NAME, HOME / "target" / "release" / NAME]
    for place in places:
        if place.is_file():
            return place
    raise OrchestratorError(
        f"{places[0]}: there is no program; install the wheel that scripts/wheel makes, or let {VARIABLE} name a program"
    )


def shipped_fmu() -> Path:
    """The FMU of the plain-bearing stand that the package holds."""
    return HOME / "dist" / "PlainBearingStand.fmu"


def shipped_recording() -> Path:
    """The recording of the tutorial: two seconds of the stand's load and friction torque, with noise."""
    return HOME / "examples" / "tutorial" / "recording.csv"


def shipped_studies() -> dict[str, Path]:
    """The studies that the package holds, by name, such as ``paper-table3``."""
    return {path.stem: path for path in sorted((HOME / "studies").glob("*.toml"))}


def study_path(study: str | os.PathLike[str]) -> Path:
    """The file of a study. One of the package's own may be called by its name alone, where no file has that name."""
    path = Path(study)
    if path.exists() or path.name != os.fspath(study):
        return path
    return shipped_studies().get(path.name.removesuffix(".toml"), path)
