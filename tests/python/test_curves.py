"""The metrics of curves against numpy, scipy and a public implementation of ISO/TS 18571."""

import os
import subprocess
import warnings
from pathlib import Path

import numpy as np
import pytest
from scipy.stats import wasserstein_distance

ROOT = Path(__file__).resolve().parent.parent.parent
PAIRS = 100


@pytest.fixture(scope="module")
def program():
    # With the features of the whole workspace, as `cargo test` built it: for one package cargo would build all anew.
    build = ["cargo", "build", "--quiet", "--locked", "--workspace", "--example", "compare"]
    subprocess.run(build, cwd=ROOT, check=True, env={**os.environ, "CARGO_TERM_COLOR": "never"})
    return Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target")) / "debug" / "examples" / "compare"


def compared(program, reference, model, band, normaliser):
    """All metrics by name, as the crate finds them."""
    rows = [""] * max(len(reference[0]), len(model[0]))
    for row in range(len(rows)):
        cells = [f"{a[row]!r}" if row < len(a) else "" for curve in (reference, model) for a in map(np.ndarray.tolist, curve)]
        rows[row] = ",".join(cells)
    options = [program, repr(float(band)), repr(float(normaliser))]
    text = subprocess.run(options, input="\n".join(rows), text=True, capture_output=True, check=True).stdout
    return {name: float(number) for name, number in (line.split() for line in text.splitlines())}


def random_pair(random):
    """A measured curve with gaps, and a model on another time base that reaches further to both sides."""
    count = int(random.integers(40, 250))
    rate = random.uniform(5.0, 500.0)
    times = random.uniform(-3.0, 3.0) + np.arange(count) / rate
    if random.random() < 0.5:
        gap = random.integers(5, count - 10)
        times[gap:] += random.integers(2, 9) / rate
    steps = times[0] - 0.01 + np.arange(0.0, times[-1] - times[0] + 0.1, 1 / (rate * random.uniform(0.3, 3.0)))
    steps = np.append(steps, steps[-1] + 1.0)
    turns = random.uniform(0.5, 6.0) * 2 * np.pi / (times[-1] - times[0])
    late = random.uniform(-0.1, 0.1) * (times[-1] - times[0])
    size, offset = random.uniform(0.5, 1.5), random.uniform(-2.0, 2.0)
    measured = offset + np.sin(turns * times) + 0.05 * random.standard_normal(len(times))
    model = offset + random.uniform(-0.2, 0.2) + size * np.sin(turns * (steps - late)) + 0.2 * np.cos(2.3 * turns * steps)
    return (times, measured), (steps, model)


def evenly(times, values):
    """The curve at even times, as the metric of ISO/TS 18571 needs them."""
    parts = round((times[-1] - times[0]) / np.sort(np.diff(times))[(len(times) - 1) // 2])
    even = times[0] + (times[-1] - times[0]) * np.arange(parts + 1) / parts
    even[-1] = times[-1]
    return even, np.interp(even, times, values)


def pairs():
    random = np.random.default_rng(18571)
    return [random_pair(random) for _ in range(PAIRS)]


def test_metrics_are_those_of_numpy_and_scipy(program):
    for number, (reference, model) in enumerate(pairs()):
        measured = reference[1]
        band, normaliser = 0.3, measured.max() - measured.min()
        found = compared(program, reference, model, band, normaliser)
        at_its_times = np.interp(reference[0], *model)
        deviations = at_its_times - measured
        rmse = np.sqrt(np.mean(deviations**2))
        expected = {
            "rmse": rmse,
            "nrmse": rmse / normaliser,
            "max-error": np.abs(deviations).max(),
            "corridor": np.mean(np.abs(deviations) <= band),
            "area": wasserstein_distance(at_its_times, measured),
        }
        for name, value in expected.items():
            assert found[name] == pytest.approx(value, abs=1e-12), (number, name)


# The public implementation is slow, and the longer the curves the more so: an ordinary run takes the pairs of short ones.
@pytest.mark.parametrize("longest", [90, pytest.param(1000, marks=pytest.mark.long)])
def test_ratings_are_those_of_a_public_implementation(program, longest, monkeypatch):
    # numba would compile its loops, which takes longer than to run these few pairs without.
    monkeypatch.setenv("NUMBA_DISABLE_JIT", "1")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        from objective_rating_metrics.rating import ISO18571
    shifts = set()
    for number, (reference, model) in enumerate(pairs()):
        if len(reference[0]) > longest:
            continue
        found = compared(program, reference, model, 1.0, 1.0)
        times, measured = evenly(*reference) if np.ptp(np.diff(reference[0])) > 1e-9 else reference
        both = [np.column_stack([times, values]) for values in (measured, np.interp(times, *model))]
        theirs = ISO18571(*both)
        for name, rating in (
            ("corridor-rating", theirs.corridor_rating(-1)),
            ("phase-rating", theirs.phase_rating(-1)),
            ("magnitude-rating", theirs.magnitude_rating(-1)),
            ("slope-rating", theirs.slope_rating(-1)),
            ("iso18571", theirs.overall_rating(-1)),
        ):
            assert found[name] == pytest.approx(rating, abs=1e-6), (number, name)
        shifts.add(found["phase-rating"])
    # They are not all alike.
    assert len(shifts) > 10
