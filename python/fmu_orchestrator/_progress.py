"""Progress of a run, read from its journal: on a terminal, in a notebook, or to a function."""

import json
import sys
import time
from collections.abc import Callable
from importlib import import_module
from pathlib import Path
from typing import Any

# Shorter runs show nothing.
QUIET = 0.5
# So often a file or a log gets a line, s.
SELDOM = 10.0
WIDTH = 30
# Words of the journal for a point that has an outcome.
OUTCOMES = {b"ok", b"apart", b"forked", b"used", b"failed"}
Show = Callable[[int, int | None], None]


class Journal:
    """Counts the points in a journal that another process writes."""

    def __init__(self, folder: Path, resume: bool) -> None:
        self.path = folder / "journal.txt"
        self.done = 0
        self.total: int | None = None
        self._place = 0
        self._file: int | None = None
        # A run that begins anew replaces the journal that is there.
        self._old = None if resume else self._age()

    def _age(self) -> tuple[int, int] | None:
        try:
            status = self.path.stat()
        except OSError:
            return None
        return status.st_ino, status.st_mtime_ns

    def look(self) -> bool:
        """Counts what is new; False while there is nothing of this run."""
        age = self._age()
        if age is None or age == self._old:
            return False
        try:
            with self.path.open("rb") as file:
                if age[0] != self._file:
                    self.done, self._place, self._file = 0, 0, age[0]
                file.seek(self._place)
                new = file.read()
        except OSError:
            return False
        whole = new[: new.rfind(b"\n") + 1]
        for line in whole.splitlines():
            self._count(line)
        self._place += len(whole)
        return self._place > 0

    def _count(self, line: bytes) -> None:
        words = line.split(b" ", 3)
        if self._place == 0 and len(words) > 1 and words[1].startswith(b"{"):
            self.total = _total(line.split(b" ", 1)[1])
        elif len(words) > 2 and words[1].isdigit() and words[2] in OUTCOMES:
            self.done += 1


def _total(header: bytes) -> int | None:
    try:
        points = json.loads(header).get("points")
    except ValueError:
        return None
    return points if isinstance(points, int) else None


class Progress:
    """Shows how far a run is."""

    def __init__(self, folder: Path, resume: bool, show: Show | bool | None) -> None:
        self._journal = Journal(folder, resume)
        self._show = _chosen(show)
        self._begun = time.monotonic()
        self._shown = False

    @property
    def look(self) -> Callable[[], None] | None:
        """To be called a few times a second; None where nobody is to see anything."""
        return self._look if self._show else None

    def _look(self) -> None:
        if self._show and time.monotonic() - self._begun > QUIET and self._journal.look():
            self._show(self._journal.done, self._journal.total)
            self._shown = True

    def end(self) -> None:
        """Takes away what a terminal or a notebook shows."""
        if self._shown and isinstance(self._show, Line | Cell):
            self._show.end()


def _chosen(show: Show | bool | None) -> Show | None:
    if callable(show):
        return show
    if show is False:
        return None
    if _notebook() is not None:
        return Cell()
    if sys.stderr is None:
        return None
    return Line() if show or sys.stderr.isatty() else Log()


def _notebook() -> Any:
    """The notebook's shell, where this is one."""
    interactive = sys.modules.get("IPython")
    shell = interactive.get_ipython() if interactive is not None else None
    return shell if getattr(shell, "kernel", None) is not None else None


class Text:
    """The progress as words."""

    def __init__(self) -> None:
        self._first: tuple[float, int] | None = None

    def words(self, done: int, total: int | None) -> str:
        now = time.monotonic()
        # What was there before this run says nothing of its speed.
        begun, before = self._first = self._first or (now, done)
        rate = (done - before) / (now - begun) if now > begun else 0.0
        text = f"{done} points" if total is None else f"{min(done, total)} of {total} points"
        if rate > 0:
            text += f", {rate:.3g} points/s"
            if total is not None:
                text += f", {max(0, total - done) / rate:.0f} s left"
        return text


class Log(Text):
    """Lines in a file."""

    def __init__(self) -> None:
        super().__init__()
        self._last = time.monotonic()

    def __call__(self, done: int, total: int | None) -> None:
        words, now = self.words(done, total), time.monotonic()
        if now - self._last > SELDOM:
            self._last = now
            sys.stderr.write(f"{words}\n")


class Line(Text):
    """A line on a terminal."""

    def __call__(self, done: int, total: int | None) -> None:
        part = min(1.0, done / total) if total else 0.0
        bar = f"[{'=' * round(WIDTH * part):{WIDTH}}] " if total else ""
        sys.stderr.write(f"\r\x1b[2K{bar}{self.words(done, total)}")
        sys.stderr.flush()

    def end(self) -> None:
        sys.stderr.write("\r\x1b[2K")
        sys.stderr.flush()


class Cell(Text):
    """A bar in a notebook."""

    def __init__(self) -> None:
        super().__init__()
        self._handle: Any = None

    def __call__(self, done: int, total: int | None) -> None:
        bar = f'<progress value="{min(done, total)}" max="{total}"></progress> ' if total else ""
        self._put(f"{bar}{self.words(done, total)}")

    def _put(self, html: str) -> None:
        shown: Any = import_module("IPython.display")
        if self._handle is None:
            self._handle = shown.display(shown.HTML(html), display_id=True)
        else:
            self._handle.update(shown.HTML(html))

    def end(self) -> None:
        self._put("")
