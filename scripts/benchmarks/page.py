"""Writes docs/benchmarks.md and its plot."""

import datetime
import os
import platform
from pathlib import Path

import plot

FOLDER = Path("docs")

HEAD = """\
# Benchmarks

Written by `scripts/bench`; edits are lost. Two programs that are compared run alternately (A B, B A, A B, ...) on one
machine. A ratio is the median over the repetitions, with the lowest and the highest beside it. Times are CPU times,
including child processes, unless said otherwise. The time of a step or a point is the difference of a long and a short run,
so it leaves out the start of the process, unless the row says "all included".
"""


def number(value):
    """Three digits, without an exponent where one can do without."""
    return f"{value:,.0f}" if abs(value) >= 1000 else f"{value:.3g}"


def table(head, rows):
    lines = [head, ["---"] * len(head), *rows]
    return "\n".join("| " + " | ".join(line) + " |" for line in lines) + "\n"


def ratios(rows):
    def goal(row):
        return f"{row.goal}{row.unit}: {'met' if row.met else '**missed**'}" if row.goal else ""

    return table(["what", "median", "min .. max", "goal", "remark"], [
        [row.what, number(row.ratio.median) + row.unit, f"{number(row.ratio.low)} .. {number(row.ratio.high)}",
         goal(row), row.note] for row in rows])


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
    """The page. A section is a title, a text, and rows or a table that is made already."""
    seconds = (datetime.datetime.now() - began).total_seconds()
    busy = "" if max(loads) < 1.5 else (
        " Other programs were running: CPU times and ratios are still valid, wall times are not.")
    parts = [HEAD, f"- machine: {machine()}",
             f"- command: `{command}`, {seconds:.0f} s on {began:%Y-%m-%d}",
             f"- load average (1 min) at the start {loads[0]:.1f}, at the end {loads[1]:.1f}.{busy}", ""]
    missed = [row for _, _, rows in sections if isinstance(rows, list) for row in rows if row.met is False]
    parts.append("## What falls short\n")
    parts += [f"- {row.what}: {number(row.ratio.median)}{row.unit} instead of {row.goal}{row.unit}"
              for row in missed] or ["Nothing: all goals are met."]
    for title, text, rows in sections:
        parts += ["", f"## {title}\n", text + "\n"]
        if rows:
            parts.append(ratios(rows) if isinstance(rows, list) else rows)
    FOLDER.mkdir(exist_ok=True)
    if sizes:
        (FOLDER / "images").mkdir(exist_ok=True)
        (FOLDER / "images" / "benchmarks-scaling.svg").write_text(plot.scaling(sizes), encoding="utf-8")
    page = FOLDER / "benchmarks.md"
    page.write_text("\n".join(parts).rstrip() + "\n", encoding="utf-8")
    return page


def errors(found):
    """The table of errors that leaps make."""
    return table(["criterion", "median", "99 % below", "worst", "worst at point", "above 1 %", "verdict changed"], [
        [e.name, f"{e.median:.2g} %", f"{e.high:.2g} %", f"{e.worst:.2g} %", e.point, str(e.above), str(e.other)]
        for e in found])


def scaling(sizes):
    """The table of the scaling series."""
    alone = {size.points: size.wall for size in sizes if size.jobs == 1}
    return table(["points", "run", "CPU a point, ms", "wall, s", "one worker / this, wall", "peak memory, MB",
                  "largest worker's, MB"], [
        [f"{size.points:,}", f"{size.jobs} at a time, {size.place}", f"{1e3 * size.cpu / size.points:.2f}",
         f"{size.wall:.2f}", f"{alone[size.points] / size.wall:.2f}", f"{size.memory:.0f}",
         f"{size.worker_memory:.0f}" if size.worker_memory else ""] for size in sizes])
