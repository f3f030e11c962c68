"""Pictures of results, drawn by matplotlib, which the extra ``plot`` brings.

A picture is a figure of matplotlib: a notebook shows it, ``savefig`` writes it, its axes can be changed.
"""

import math
import sys
from collections.abc import Iterable, Mapping, Sequence
from io import BytesIO
from typing import TYPE_CHECKING, Any

from ._errors import OrchestratorError
from ._table import Table

if TYPE_CHECKING:
    import numpy
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from numpy.typing import NDArray

    Numbers = NDArray[numpy.float64]

# Two colours that people with any colour vision tell apart, and shapes beside them.
GOOD, POOR, RANGE = "#0b62a8", "#b0b0b0", "#2a9d4a"
MOST_PANELS, MOST_BARS, MOST_PARAMETERS, MOST_MARKS = 12, 12, 5, 20_000
# The back ends of matplotlib that show no windows.
FILES = {"agg", "cairo", "pdf", "pgf", "ps", "svg", "template"}
# What a histogram leaves out at each end where values lie far away.
TAIL = 1.0


def needed() -> None:
    """Says which extra is missing, where there is no matplotlib, which brings numpy."""
    try:
        import matplotlib  # noqa: F401
    except ImportError:
        raise OrchestratorError("pictures need matplotlib: pip install 'fmu-orchestrator[plot]'") from None


def figure(width: float, height: float) -> "Figure":
    """An empty figure; where the user shows windows by pyplot, one of them."""
    needed()
    from matplotlib import get_backend

    from ._picture import Picture

    options: dict[str, Any] = {"figsize": (width, height), "layout": "constrained"}
    pyplot = sys.modules.get("matplotlib.pyplot")
    backend = get_backend().lower()
    if pyplot is None or backend in FILES or "inline" in backend:
        return Picture(**options)
    shown: Figure = pyplot.figure(FigureClass=Picture, **options)
    return shown


def png(drawn: "Figure") -> bytes:
    """A figure as a file."""
    content = BytesIO()
    drawn.savefig(content, format="png", dpi=100)
    return content.getvalue()


def _panels(count: int, width: float = 3.4, height: float = 2.8) -> "tuple[Figure, list[Axes]]":
    columns = min(count, 3)
    rows = -(-count // columns)
    drawn = figure(max(width * columns, 4.5), height * rows)
    return drawn, [drawn.add_subplot(rows, columns, place + 1) for place in range(count)]


def limits(count: Mapping[str, Any]) -> tuple[float | None, float | None]:
    """The accepted range of a criterion in ``summary.json``; None where it has no end."""
    if "lower" in count or "upper" in count:
        return count.get("lower"), count.get("upper")
    nominal, tolerance = count["nominal"], count["tolerance"]
    low, high = nominal - tolerance, nominal + tolerance
    # A curve's metric is 0 or 1 for equal curves, and never beyond it.
    if count.get("metric"):
        return (None, high) if nominal == 0 else (low, None)
    return low, high


def points(table: Table, summary: Mapping[str, Any], x: str | None, y: str | None) -> "Figure":
    """The cloud of points, and a histogram of each criterion with its accepted range."""
    needed()
    import numpy

    criteria = {name: count for name, count in summary["criteria"].items() if name in table}
    good = numpy.array(table["accepted" if "accepted" in table else "verified"], dtype=bool)
    first, second = _two_columns(table, summary, good)
    shown = sorted(criteria, key=lambda name: float(criteria[name]["fraction"]))[: MOST_PANELS - 1]
    shown = [name for name in criteria if name in shown]
    drawn, (cloud, *histograms) = _panels(len(shown) + 1)
    columns = (x or first, y or second)
    words = "accepted" if "accepted" in table else "verified"
    step = -(-len(table) // MOST_MARKS)
    across, up = (_numbers(table, name) for name in columns)
    for chosen, colour, marker, what in ((~good, POOR, "x", f"not {words}"), (good, GOOD, "o", words)):
        marks = slice(None, None, step)
        cloud.scatter(across[chosen][marks], up[chosen][marks], s=14, c=colour, marker=marker, label=f"{what} ({chosen.sum()})")
    label = [_label(table, criteria, name) for name in columns]
    cloud.set(xlabel=label[0], ylabel=label[1])
    spans: list[tuple[str, Numbers, Any]] = [(columns[0], across, cloud.axvspan), (columns[1], up, cloud.axhspan)]
    for name, values, draw in spans:
        if name in criteria:
            low, high = limits(criteria[name])
            draw(_end(low, values, -1), _end(high, values, 1), color=RANGE, alpha=0.15, lw=0, zorder=0)
    cloud.legend(fontsize="small", ncols=2, loc="lower left", bbox_to_anchor=(0.0, 1.0), frameon=False, borderpad=0.0,
                 handletextpad=0.1, columnspacing=0.8)
    for axes, name in zip(histograms, shown, strict=True):
        _histogram(axes, _numbers(table, name), good, criteria[name], _label(table, criteria, name))
    left = len(criteria) - len(shown)
    more = f"; {left} criteria that most points meet are left out" if left else ""
    thinned = f"; the cloud shows one of {step}" if step > 1 else ""
    drawn.suptitle(f"{len(table)} points, {good.sum()} {words}{thinned}{more}", fontsize="medium")
    return drawn


def _label(table: Table, criteria: Mapping[str, Any], name: str) -> str:
    """A column's name with its unit; a curve's value is that of its metric."""
    metric = criteria.get(name, {}).get("metric")
    return f"{metric} of {table.label(name)}" if metric else table.label(name)


def _numbers(table: Table, name: str) -> "Numbers":
    return table.to_numpy([name])[:, 0]


def _end(limit: float | None, values: "Numbers", side: int) -> float:
    """The end of a range that is drawn: beyond all values where there is no limit."""
    import numpy

    if limit is not None:
        return limit
    known = values[numpy.isfinite(values)]
    return float(known.max() if side > 0 else known.min()) if len(known) else 0.0


def _two_columns(table: Table, summary: Mapping[str, Any], good: "NDArray[numpy.bool_]") -> tuple[str, str]:
    """The two parameters whose values differ most between points that are accepted and others; where one varies, it
    and the criterion that fails most."""
    import numpy

    names = [one["name"] for one in summary["parameters"] if one["name"] in table]
    names = [name for name in names if numpy.ptp(_numbers(table, name)) > 0]
    criteria = sorted(summary["criteria"], key=lambda name: float(summary["criteria"][name]["fraction"]))
    criteria = [name for name in criteria if name in table][:2]
    weight = {}
    for name in names:
        values = _numbers(table, name)
        few = min(good.sum(), (~good).sum()) < 3
        targets = [_numbers(table, criterion) for criterion in criteria] if few else [good.astype(numpy.float64)]
        weight[name] = max((abs(_correlation(values, target)) + (0 if few else _distance(values, good))
                            for target in targets), default=0.0)
    order = sorted(names, key=lambda name: -weight[name])
    chosen = (order + criteria + ["point", "point"])[:2]
    return chosen[0], chosen[1]


def _correlation(a: "Numbers", b: "Numbers") -> float:
    """The rank correlation of two columns."""
    import numpy

    known = numpy.isfinite(a) & numpy.isfinite(b)
    if known.sum() < 3 or numpy.ptp(a[known]) == 0 or numpy.ptp(b[known]) == 0:
        return 0.0
    first, second = (numpy.argsort(numpy.argsort(column[known])).astype(numpy.float64) for column in (a, b))
    return float(numpy.corrcoef(first, second)[0, 1])


def _distance(values: "Numbers", good: "NDArray[numpy.bool_]") -> float:
    """The largest distance between the distribution functions of two groups (Kolmogorov and Smirnov)."""
    import numpy

    at = numpy.sort(values)
    ends = [numpy.searchsorted(numpy.sort(group), at, side="right") / len(group) for group in (values[good], values[~good])]
    return float(numpy.abs(ends[0] - ends[1]).max())


def _histogram(
    axes: "Axes", values: "Numbers", good: "NDArray[numpy.bool_]", count: Mapping[str, Any], label: str
) -> None:
    import numpy

    known = numpy.isfinite(values)
    axes.set(xlabel=label, ylabel="points")
    low, high = limits(count)
    if known.any():
        inner = numpy.percentile(values[known], [TAIL, 100 - TAIL])
        ends = [end for end in (low, high) if end is not None]
        reach = numpy.ptp([*inner, *ends])
        first = max(values[known].min(), min(inner[0], *ends) - 0.5 * reach)
        last = min(values[known].max(), max(inner[1], *ends) + 0.5 * reach)
        bins = numpy.linspace(first, last if last > first else first + (abs(first) or 1.0) * 1e-3, 25)
        parts = [values[known & good], values[known & ~good]]
        axes.hist(parts, bins=list(bins), stacked=True, color=[GOOD, POOR])
        beyond = int((values[known] < first).sum() + (values[known] > last).sum())
        if beyond:
            axes.set_ylabel(f"points ({beyond} beyond the picture)")
    left, right = axes.get_xlim()
    axes.axvspan(left if low is None else low, right if high is None else high, color=RANGE, alpha=0.15, lw=0, zorder=0)
    for end in (low, high):
        if end is not None:
            axes.axvline(end, color=RANGE, lw=1)
    if not count.get("metric") and count.get("nominal") is not None and low is not None and high is not None:
        axes.axvline(count["nominal"], color=RANGE, ls="--", lw=1)
    axes.set_title(f"{100 * count['fraction']:.0f} % in the accepted range", fontsize="small")


def curves(
    table: Table, nearest: Iterable[Table], summary: Mapping[str, Any], units: Mapping[str, str]
) -> "Figure":
    """The measured curves with their uncertainty, and the nearest point's runs."""
    needed()
    import numpy

    names = list(dict.fromkeys(map(str, table["criterion"])))[:MOST_PANELS]
    drawn, panels = _panels(len(names), 4.6, 3.0)
    where = numpy.array(table["criterion"])
    for axes, name in zip(panels, names, strict=True):
        rows = where == name
        time, value, uncertainty = (_numbers(table, column)[rows] for column in ("time", "value", "uncertainty"))
        if numpy.isfinite(uncertainty).any():
            axes.fill_between(time, value - uncertainty, value + uncertainty, color=RANGE, alpha=0.3, lw=0,
                              label="uncertainty of the measured curve")
        for run in nearest:
            if name in run:
                axes.plot(_numbers(run, "time"), _numbers(run, name), color="#d1622b", lw=0.8, label="nearest point")
        axes.plot(time, value, color="black", lw=0, marker=".", ms=3, label="measured")
        unit = f" [{units[name]}]" if units.get(name, "1") != "1" else ""
        axes.set(xlabel="time [s]")
        axes.set_ylabel(f"{summary['criteria'].get(name, {}).get('variable', name)}{unit}", fontsize="small")
        axes.set_title(name, fontsize="small")
    keys = {label: handle for axes in panels for handle, label in zip(*axes.get_legend_handles_labels(), strict=True)}
    drawn.legend(keys.values(), keys.keys(), loc="outside lower center", ncols=2 if len(names) == 1 else 4, fontsize="small",
                 frameon=False)
    return drawn


def _effects(output: Mapping[str, Any], unit: str) -> tuple[str, list[tuple[str, Sequence[Any]]]] | None:
    """The axis' name, and series of estimates by their names: the best that an analysis has."""
    if output.get("sobol"):
        return "Sobol index", [("total", output["sobol"]["total"]), ("first order", output["sobol"]["first"])]
    if output.get("shapley"):
        return "Shapley effect", [("", output["shapley"]["effects"])]
    if output.get("morris"):
        return f"Morris' mean effect{unit}", [("", [one["mu_star"] for one in output["morris"]])]
    return None


def effects(parameters: Sequence[str], outputs: Iterable[Mapping[str, Any]], units: Mapping[str, str]) -> "Figure":
    """For each output the parameters that matter most, with 95 % intervals."""
    found = []
    for output in outputs:
        unit = units.get(output["name"])
        if effect := _effects(output, f" [{unit}]" if unit else ""):
            found.append((output["name"], effect))
    found = found[:MOST_PANELS]
    if not found:
        raise OrchestratorError("the analysis has found no index of any parameter, so there is nothing to draw")
    bars = min(len(parameters), MOST_BARS)
    drawn, panels = _panels(len(found), 4.4, 1.2 + 0.28 * bars)
    for axes, (name, (what, series)) in zip(panels, found, strict=True):
        order = sorted(range(len(parameters)), key=lambda k: -abs(series[0][1][k]["value"] or 0.0))[:bars]
        height = 0.8 / len(series)
        for place, (label, estimates) in enumerate(series):
            values = [estimates[k]["value"] for k in order]
            low = [_error(estimates[k], "low", -1) for k in order]
            high = [_error(estimates[k], "high", 1) for k in order]
            axes.barh([k + height * place for k in range(bars)], values, height, xerr=[low, high], label=label or None,
                      color=(GOOD, POOR)[place], error_kw={"lw": 1, "capsize": 2})
        axes.set_yticks([k + height * (len(series) - 1) / 2 for k in range(bars)], [parameters[k] for k in order],
                        fontsize="small")
        axes.invert_yaxis()
        axes.axvline(0, color="black", lw=0.5)
        axes.set(xlabel=f"{what} (95 % intervals)")
        axes.set_title(name, fontsize="small")
        if len(series) > 1:
            axes.legend(fontsize="x-small")
    left = len(parameters) - bars
    if left:
        drawn.suptitle(f"the {bars} largest of {len(parameters)} parameters", fontsize="medium")
    return drawn


def _error(estimate: Mapping[str, Any], end: str, side: int) -> float:
    value, limit = estimate["value"], estimate.get(end)
    return 0.0 if value is None or limit is None else max(0.0, side * (limit - value))


def posterior(table: Table, free: Sequence[Mapping[str, Any]], found: Mapping[str, Any]) -> "Figure":
    """The sets of parameters drawn from the posterior: each parameter's histogram with its 95 % interval, and each pair."""
    needed()
    import numpy

    shown = [one for one in free if one["name"] in table][:MOST_PARAMETERS]
    size = len(shown)
    drawn = figure(max(2.3 * size, 4.5), max(2.1 * size, 3.2))
    values = [_numbers(table, one["name"]) for one in shown]
    for row in range(size):
        for column in range(row + 1):
            axes = drawn.add_subplot(size, size, row * size + column + 1)
            if shown[column].get("scale") == "log":
                axes.set_xscale("log")
            if row == column:
                bins = numpy.geomspace if shown[row].get("scale") == "log" else numpy.linspace
                axes.hist(values[row], bins=list(bins(values[row].min(), values[row].max(), 21)), color=GOOD)
                for low, high in shown[row].get("intervals", []):
                    axes.axvspan(low, high, color=RANGE, alpha=0.2, lw=0)
                axes.set_ylabel("sets")
            else:
                axes.scatter(values[column], values[row], s=6, c=GOOD, alpha=0.5, lw=0)
                if shown[row].get("scale") == "log":
                    axes.set_yscale("log")
                axes.set_ylabel(table.label(shown[row]["name"]), fontsize="small")
            axes.set_xlabel(table.label(shown[column]["name"]), fontsize="small")
            axes.tick_params(labelsize="x-small")
    doubt = "" if found.get("trusted", True) else "; not to be trusted: " + "; ".join(found.get("doubts", []))
    left = f", {size} of {len(free)} parameters" if size < len(free) else ""
    drawn.suptitle(f"{len(table)} sets from the posterior, worth {found['effective']:.0f} independent ones{left};\n"
                   f"green: 95 % interval{doubt}", fontsize="small", wrap=True)
    return drawn


def estimates(optima: Sequence[Any]) -> "Figure":
    """The identified values with their 95 % intervals, of each set that could be the right one."""
    names = list(optima[0].parameters)
    drawn, panels = _panels(len(names), 3.4, 1.0 + 0.35 * len(optima))
    for axes, name in zip(panels, names, strict=True):
        for place, optimum in enumerate(optima):
            one = optimum.parameters[name]
            low, high = one.interval or (math.nan, math.nan)
            axes.plot([low, high], [place, place], color=GOOD, lw=2)
            axes.plot([one.value], [place], color=GOOD, marker="o")
        axes.set_yticks(range(len(optima)), [f"{100 * optimum.weight:.0f} %" for optimum in optima])
        axes.set_ylim(len(optima) - 0.5, -0.5)
        unit = f" [{one.unit}]" if one.unit and one.unit != "1" else ""
        axes.set(xlabel=f"{name}{unit}", ylabel="weight")
    drawn.suptitle("identified values with their 95 % intervals", fontsize="medium")
    return drawn
