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
# The signs of the terminal's first screen.
SIGNS = {"✓": COLOURS["verified"], "!": COLOURS["inconclusive"], "✗": COLOURS["not verified"], "?": COLOURS["inconclusive"]}
# Those of verdicts without doubts.
PLAIN = {"verified": "✓", "not verified": "✗", "inconclusive": "?"}
# Where its words begin.
LABEL = 9
# The share of accepted points from which a verdict is doubtful.
MOST = 0.5
Draw = Callable[[], "Figure"]


def text(content: str) -> str:
    """A text of the terminal."""
    return f"<pre>{escape(content)}</pre>"


def verification(summary: Mapping[str, Any], said: str, pictures: Iterable[Draw], report: Path) -> str:
    """The answer and what makes it doubtful, in one size; the criteria; the pictures; where the page is. ``said`` is what the
    terminal shows."""
    title = f"<p>{escape(summary['title'])}</p>" if summary["title"] else ""
    head = "<tr><th>criterion</th><th>accepted range</th><th>points</th><th>share</th></tr>"
    rows = "".join(_criterion(name, count) for name, count in summary["criteria"].items())
    table = f"<table><thead>{head}</thead><tbody>{rows}</tbody></table>"
    return f"{title}{_first_screen(said) or _verdict(summary)}{table}{drawn(pictures)}{page(report)}"


def _first_screen(said: str) -> str:
    """The terminal's first screen: a sign with the verdict, then what was asked, the answer, what decides it, what is next."""
    first, *lines = said.split("\n\n")[0].splitlines() or [""]
    if not lines or first[:2].strip() not in SIGNS:
        return ""
    parts: list[list[str]] = []
    for line in lines:
        # A label stands in the first columns; what it is about goes on below.
        label = line[:LABEL].strip()
        if label or not parts:
            parts.append([label])
        parts[-1].append(line[LABEL:].strip())
    told = "".join(f"<p><b>{escape(label)}</b> {escape(' '.join(words))}</p>" for label, *words in parts)
    return f'<p style="color: {SIGNS[first[0]]}"><b>{escape(first)}</b></p>{told}'


def _verdict(summary: Mapping[str, Any]) -> str:
    """The same of results that were read from a folder: the verdict and its warnings."""
    warnings = [f"<li>{escape(said)}</li>" for said in doubts(summary)]
    wrong = _wrong(summary)
    first = headline(summary)
    words = f'<p style="color: {SIGNS[first[0]]}"><b>{escape(first)}</b></p>'
    risk = f"<p>{100 * wrong:.0f} % of the accepted points are expected not to conform.</p>" if wrong else ""
    return words + risk + (f"<ul>{''.join(warnings)}</ul>" if warnings else "")


def headline(summary: Mapping[str, Any]) -> str:
    """The verdict in words behind its sign, as the terminal has it."""
    words = str(summary["verdict_words"])
    doubtful = ", with doubts" if sign(summary) == "!" else ""
    return f"{sign(summary)} {words[:1].upper()}{words[1:]}{doubtful}."


def sign(summary: Mapping[str, Any]) -> str:
    """The verdict's sign on the first screen."""
    if any(count.get("nominal_from") for count in summary["criteria"].values()):
        return "?"
    if summary["verdict"] == "verified" and (doubts(summary) or _wrong(summary) > MOST or _is_odd(summary)):
        return "!"
    return PLAIN[summary["verdict"]]


def doubts(summary: Mapping[str, Any]) -> list[str]:
    """The concerns that are warnings, each with its remedy."""
    concerns = summary.get("concerns", [])
    return [". ".join(filter(None, (one["text"], one.get("remedy")))) for one in concerns if one["severity"] != "note"]


def _wrong(summary: Mapping[str, Any]) -> float:
    return (summary.get("risk") or {}).get("not_conforming_given_accepted") or 0.0


def _is_odd(summary: Mapping[str, Any]) -> bool:
    """Whether points that ran twice gave other results."""
    return summary.get("reproducible") is False or bool(summary.get("audit_mismatches"))


def _criterion(name: str, count: Mapping[str, Any]) -> str:
    nominal, tolerance, unit = count.get("nominal"), count.get("tolerance"), count.get("unit") or ""
    if count.get("metric") or nominal is None:
        accepted = count["stated_tolerance"]
    elif tolerance is None:
        accepted = f"{count['lower']:g} .. {count['upper']:g} {unit}"
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
