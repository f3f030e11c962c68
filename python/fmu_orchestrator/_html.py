"""Results as notebooks show them."""

from base64 import b64encode
from collections.abc import Callable, Iterable, Mapping
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING, Any

from . import _plot

if TYPE_CHECKING:
    from matplotlib.figure import Figure

COLOURS = {"verified": "#1a7f37", "not verified": "#b3261e", "inconclusive": "#8a6100"}
Draw = Callable[[], "Figure"]


def text(content: str) -> str:
    """A text of the terminal."""
    return f"<pre>{escape(content)}</pre>"


def verification(summary: Mapping[str, Any], pictures: Iterable[Draw], report: Path) -> str:
    """The verdict, beside it what makes it doubtful, the criteria, the pictures, and where the page is."""
    colour = COLOURS.get(summary["verdict"], "inherit")
    title = f"<p>{escape(summary['title'])}</p>" if summary["title"] else ""
    words = f'<p style="color: {colour}"><b>{escape(_sentence(summary["verdict_words"]))}</b></p>'
    warnings = [f"<li>{escape(said)}</li>" for said in map(_said, summary.get("concerns", [])) if said]
    beside = f'<ul style="color: {COLOURS["inconclusive"]}">{"".join(warnings)}</ul>' if warnings else ""
    head = "<tr><th>criterion</th><th>accepted range</th><th>points</th><th>share</th></tr>"
    rows = "".join(_criterion(name, count) for name, count in summary["criteria"].items())
    table = f"<table><thead>{head}</thead><tbody>{rows}</tbody></table>"
    return f"{title}{words}{beside}{table}{drawn(pictures)}{page(report)}"


def _sentence(words: str) -> str:
    return words[:1].upper() + words[1:] + "."


def _said(concern: Any) -> str:
    """What a concern says, where it is a warning; earlier versions wrote the text alone."""
    if isinstance(concern, str):
        return concern
    return str(concern["text"]) if concern["severity"] != "note" else ""


def _criterion(name: str, count: Mapping[str, Any]) -> str:
    nominal, tolerance, unit = count.get("nominal"), count.get("tolerance"), count.get("unit") or ""
    if count.get("metric") or nominal is None:
        accepted = count["stated_tolerance"]
    elif tolerance is None:
        accepted = f"{count['lower']:g} … {count['upper']:g} {unit}"
    else:
        accepted = f"{nominal:g} ± {tolerance:g} {unit}"
    cells = (name, accepted, str(count["passed"]), f"{100 * count['fraction']:.1f} %")
    return "<tr>" + "".join(f"<td>{escape(cell)}</td>" for cell in cells) + "</tr>"


def drawn(pictures: Iterable[Draw]) -> str:
    """Pictures, or why there are none."""
    shown = []
    for draw in pictures:
        try:
            content = b64encode(_plot.png(draw())).decode()
        except Exception as error:  # The answer is shown whatever becomes of its pictures.
            return f"<p>No picture: {escape(str(error))}</p>"
        shown.append(f'<img alt="{escape(_first_line(draw))}" style="max-width: 100%" src="data:image/png;base64,{content}"/>')
    return "".join(f"<div>{one}</div>" for one in shown)


def page(report: Path) -> str:
    """A link to the page."""
    if not report.is_file():
        return ""
    place = report.resolve()
    try:
        name = link = place.relative_to(Path.cwd()).as_posix()
    except ValueError:
        name, link = str(place), place.as_uri()
    return f'<p>All results: <a href="{escape(link)}" target="_blank">{escape(name)}</a></p>'


def _first_line(draw: Draw) -> str:
    """What a picture shows, as the method that draws it says."""
    return (draw.__doc__ or "").strip().split("\n")[0]
