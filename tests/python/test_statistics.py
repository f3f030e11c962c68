"""Percentiles over time against scipy: at uneven times, with gaps, and where the signal stands still."""

import os
import subprocess
from pathlib import Path

import numpy as np
import pytest
from scipy.stats import uniform

ROOT = Path(__file__).resolve().parent.parent.parent
PERCENTS = [0, 1, 5, 25, 50, 75, 95, 99, 100]


@pytest.fixture(scope="module")
def program():
    # With the features of the whole workspace, as `cargo test` built it: for one package cargo would build all anew.
    build = ["cargo", "build", "--quiet", "--locked", "--workspace", "--example", "percentile"]
    subprocess.run(build, cwd=ROOT, check=True, env={**os.environ, "CARGO_TERM_COLOR": "never"})
    return Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target")) / "debug" / "examples" / "percentile"


def percentiles(program, times, values):
    text = "\n".join(f"{time!r},{value!r}" for time, value in zip(times.tolist(), values.tolist()))
    options = [program, *map(str, PERCENTS)]
    out = subprocess.run(options, input=text, text=True, capture_output=True, check=True).stdout
    return np.array([float(line) for line in out.split()])


def signals():
    random = np.random.default_rng(95)
    for number in range(60):
        count = int(random.integers(3, 400))
        steps = random.exponential(0.1, count - 1) * np.where(random.random(count - 1) < 0.05, 50.0, 1.0)
        times = random.uniform(-5.0, 5.0) + np.concatenate([[0.0], np.cumsum(steps)])
        values = random.uniform(-1e3, 1e3) + np.cumsum(random.standard_normal(count))
        if number % 3 == 0:
            values = np.round(values)
        yield times, values


def test_percentiles_are_quantiles_of_the_straight_lines(program):
    """Along a straight line the value is uniformly distributed, so the signal's distribution is a mixture of these."""
    for number, (times, values) in enumerate(signals()):
        steps, low, high = np.diff(times), np.minimum(values[1:], values[:-1]), np.maximum(values[1:], values[:-1])
        weights = steps / steps.sum()
        tilted = high > low

        def below(level, or_equal):
            level_lines = low[~tilted] <= level if or_equal else low[~tilted] < level
            lines = uniform.cdf(level, low[tilted], (high - low)[tilted])
            return weights[tilted] @ lines + weights[~tilted] @ level_lines

        found = percentiles(program, times, values)
        assert found[0] == values.min() and found[-1] == values.max(), number
        for percent, level in zip(PERCENTS, found):
            # A signal that stands still for a while makes its distribution jump.
            assert below(level, False) - 1e-9 <= percent / 100 <= below(level, True) + 1e-9, (number, percent)


def test_percentiles_are_those_of_many_samples(program):
    for number, (times, values) in enumerate(signals()):
        if number % 3 == 0:
            continue
        dense = np.interp(np.linspace(times[0], times[-1], 400_001), times, values)
        expected = np.percentile(dense, PERCENTS)
        assert percentiles(program, times, values) == pytest.approx(expected, abs=1e-3 * np.ptp(values)), number
