"""What can go wrong."""

from pathlib import Path


class OrchestratorError(Exception):
    """A mistake in what was asked for. The text is the program's own line, which says how to mend it."""


class OrchestratorWarning(UserWarning):
    """A remark of the program on a study that it can use all the same, or a doubt about its verdict."""


class Interrupted(KeyboardInterrupt):
    """Ctrl-C has ended a run. Its points are kept: the same call with ``resume=True`` goes on."""

    def __init__(self, folder: Path | None) -> None:
        super().__init__("interrupted" if folder is None else f"interrupted; resume=True goes on in {folder}")
        self.folder = folder
