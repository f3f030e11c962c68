"""Writes docs/evidence/benchmarks.md, the file with all rows beside it, and the plot."""

import csv
import datetime
import os
import platform
from pathlib import Path

import plot

FOLDER = Path("docs/evidence")
IMAGES = Path("docs/images")

HEAD = """\
# Benchmarks

Written by `scripts/evidence/bench`; edits are lost. Here is what missed its goal; [benchmarks.csv](benchmarks.csv) has all. Programs that are
compared run alternately (A B, B A, A B, ...). A figure is the median, in CPU time with child processes unless it says otherwise. The time of a
step or a point is without the start of the process, unless it says "all included".
"""

COLUMNS = ["what", "median", "lowest", "highest", "unit", "goal", "met", "remark"]


def number(value):
    """Three digits, without an exponent where one can do without."""
    return f"{value:,.0f}" if abs(value) >= 1000 else f"{value:.3g}"


def cells(row):
    """A measured row, as the file has it."""
    met = {True: "yes", False: "no", None: ""}[row.met]
    figures = [number(figure) for figure in (row.ratio.median, row.ratio.low, row.ratio.high)]
    return [row.what, *figures, row.unit.strip(), row.goal, met, row.note]


def line(row):
    """The same in the page."""
    goal = f" (goal {row.goal}{row.unit}{'' if row.met else ': **missed**'})" if row.goal else ""
    return f"- {row.what}: {number(row.ratio.median)}{row.unit}{goal}"


def missed(rows):
    """Those that missed their goal."""
    return [row for row in rows if row.met is False]


def machine():
    """The machine, as far as it tells."""
    model = platform.processor() or platform.machine()
    try:
        for line in Path("/proc/cpuinfo").read_text().splitlines():
            if line.startswith("model name"):
                model = line.split(":", 1)[1].strip()
                break
    except OSError:
        pass
    system = platform.system()
    try:
        system = f"{platform.freedesktop_os_release()['PRETTY_NAME']}, {system} {platform.release()}"
    except OSError:
        pass
    return f"{os.cpu_count()} cores, {model}; {system}; Python {platform.python_version()}"


def write(command, began, loads, sections, sizes):
    """The page. A section is a title, a text, and measured rows or a table: a head and rows of cells, for the file alone."""
    seconds = (datetime.datetime.now() - began).total_seconds()
    busy = "" if max(loads) < 1.5 else (
        " Other programs were running: CPU times and ratios are still valid, wall times are not.")
    head = [f"- machine: {machine()}", f"- command: `{command}`, {seconds:.0f} s on {began:%Y-%m-%d}",
            f"- load average (1 min) at the start {loads[0]:.1f}, at the end {loads[1]:.1f}.{busy}"]
    if sizes:
        IMAGES.mkdir(exist_ok=True)
        (IMAGES / "benchmarks-scaling.svg").write_text(plot.scaling(sizes), encoding="utf-8")
    return pages(head, sections)


def pages(head, sections):
    """The page and the file of what was measured."""
    parts, lines, others = [HEAD, *head], [], []
    for title, text, rows in sections:
        measured = isinstance(rows, list)
        lines += [[f"# {title}"], *([COLUMNS, *map(cells, rows)] if measured else [rows[0], *rows[1]])]
        if measured and not missed(rows):
            others.append(title)
        elif text:
            parts += ["", f"## {title}\n", text]
            parts += ["", *map(line, missed(rows))] if measured else []
    if others:
        parts += ["", f"No goal was missed in: {'; '.join(others)}."]
    FOLDER.mkdir(exist_ok=True)
    with (FOLDER / "benchmarks.csv").open("w", encoding="utf-8", newline="") as file:
        csv.writer(file, lineterminator="\n").writerows(lines)
    page = FOLDER / "benchmarks.md"
    page.write_text("\n".join(parts).rstrip() + "\n", encoding="utf-8")
    return page


def errors(found):
    """The table of errors that leaps make."""
    return ["criterion", "median", "99 % below", "worst", "worst at point", "above 1 %", "verdict changed"], [
        [e.name, f"{e.median:.2g} %", f"{e.high:.2g} %", f"{e.worst:.2g} %", e.point, str(e.above), str(e.other)]
        for e in found]


def scaling(sizes):
    """The table of the scaling series."""
    alone = {size.points: size.wall for size in sizes if size.jobs == 1}
    return ["points", "run", "CPU a point, ms", "wall, s", "one worker / this, wall", "peak memory, MB",
            "largest worker's, MB"], [
        [f"{size.points:,}", f"{size.jobs} at a time, {size.place}", f"{1e3 * size.cpu / size.points:.2f}",
         f"{size.wall:.2f}", f"{alone[size.points] / size.wall:.2f}", f"{size.memory:.0f}",
         f"{size.worker_memory:.0f}" if size.worker_memory else ""] for size in sizes]
