"""Results as notebooks show them."""

from collections.abc import Mapping
from html import escape
from pathlib import Path
from typing import Any

# A notebook keeps what it shows; a larger page is linked instead.
LARGEST = 4 << 20
COLOURS = {"verified": "#1a7f37", "not verified": "#b3261e", "inconclusive": "#8a6100"}


def text(content: str) -> str:
    """A text of the terminal."""
    return f"<pre>{escape(content)}</pre>"


def verification(summary: Mapping[str, Any], report: Path) -> str:
    """The verdict, the criteria and the page."""
    colour = COLOURS.get(summary["verdict"], "inherit")
    title = f"<p><b>{escape(summary['title'] or summary['provenance']['study'])}</b></p>" if summary["title"] else ""
    words = f'<p style="color: {colour}">{escape(summary["verdict_words"])}</p>'
    head = "<tr><th>criterion</th><th>accepted range</th><th>points</th><th>share</th></tr>"
    rows = "".join(_criterion(name, count) for name, count in summary["criteria"].items())
    return f"{title}{words}<table><thead>{head}</thead><tbody>{rows}</tbody></table>{page(report)}"


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


def page(report: Path) -> str:
    """A page in a frame of its own: its styles and scripts do not reach the notebook."""
    try:
        content = report.read_text(encoding="utf-8")
    except OSError:
        return ""
    if len(content) > LARGEST:
        return f"<p>The report: {escape(str(report))}</p>"
    return (
        f'<details open><summary>Report</summary><iframe srcdoc="{escape(content)}" sandbox="allow-scripts allow-downloads" '
        'style="width: 100%; height: 45em; border: 1px solid #999" title="Verification report"></iframe></details>'
    )
