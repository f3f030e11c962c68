"""Statistics of signals against numpy and scipy: percentiles, crossings, the strongest oscillation."""

import os
import subprocess
from pathlib import Path

import numpy as np
import pytest
from scipy.signal import periodogram
from scipy.stats import uniform

ROOT = Path(__file__).resolve().parent.parent.parent
PERCENTS = [0, 1, 5, 25, 50, 75, 95, 99, 100]


@pytest.fixture(scope="module")
def program():
    # With the features of the whole workspace, as `cargo test` built it: for one package cargo would build all anew.
    build = ["cargo", "build", "--quiet", "--locked", "--workspace", "--example", "statistics"]
    subprocess.run(build, cwd=ROOT, check=True, env={**os.environ, "CARGO_TERM_COLOR": "never"})
    return Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target")) / "debug" / "examples" / "statistics"


def percentiles(program, times, values):
    return statistics(program, times, values, PERCENTS)


def statistics(program, times, values, names):
    text = "\n".join(f"{time!r},{value!r}" for time, value in zip(times.tolist(), values.tolist()))
    options = [program, *map(str, names)]
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


def first_crossing(times, values, level, direction):
    """The first crossing by numpy, since the first time; not a number where there is none."""
    before, after = values[:-1], values[1:]
    rises, falls = (before < level) & (after >= level), (before > level) & (after <= level)
    passes = {"rising": rises, "falling": falls, "either": rises | falls}[direction]
    if not passes.any():
        return np.nan
    k = int(np.argmax(passes))
    return times[k] - times[0] + (level - before[k]) / (after[k] - before[k]) * (times[k + 1] - times[k])


def test_crossings_are_those_of_the_straight_lines(program):
    random = np.random.default_rng(1912)
    for number, (times, values) in enumerate(signals()):
        # Levels between the values, at one of them, and out of reach.
        levels = [*random.uniform(values.min(), values.max(), 3), values[len(values) // 2], values.max() + 1]
        names = [(float(level), direction) for level in levels for direction in ("rising", "falling", "either")]
        found = statistics(program, times, values, [f"{direction}={level!r}" for level, direction in names])
        expected = [first_crossing(times, values, level, direction) for level, direction in names]
        assert found == pytest.approx(np.array(expected), abs=1e-9, nan_ok=True), number


def oscillations():
    """Even and uneven times; a sine with a drift, a weaker one more than five lines of the spectrum away, and noise."""
    random = np.random.default_rng(1057)
    for number in range(60):
        count = int(random.integers(200, 3000))
        steps = random.uniform(0.7, 1.3, count - 1) if number % 2 else np.ones(count - 1)
        times = np.concatenate([[0.0], np.cumsum(steps)]) * 10.0 ** random.uniform(-4, 1)
        span = times[-1]
        # In periods of the recording.
        place = random.uniform(7, count / 8)
        other = place + random.choice([-1, 1]) * random.uniform(5, 0.4 * count) if number % 3 else 0.0
        other = 1.7 * place + 6 if not 2.5 < other < 0.45 * count else other
        weaker = random.uniform(0, 0.7) if number % 3 else 0.0
        noise = random.choice([0.0, 0.02, 0.3])
        amplitude = 10.0 ** random.uniform(-3, 3)
        phase = lambda periods: 2 * np.pi * (periods * times / span + random.random())
        shape = np.sin(phase(place)) + weaker * np.sin(phase(other)) + noise * random.standard_normal(count)
        drift = random.uniform(-30, 30) + random.uniform(-30, 30) * times / span
        yield times, amplitude * (shape + drift), place / span, amplitude, weaker, noise


def test_oscillations_are_found(program):
    for number, (times, values, frequency, amplitude, weaker, noise) in enumerate(oscillations()):
        found = statistics(program, times, values, ["frequency", "oscillation-amplitude"])
        span, count = times[-1], len(times)
        # The bound of Cramer and Rao, with the window's loss (a factor of 2.3 in the deviation), six times; and what the
        # window lets through of another oscillation five lines away.
        statistical = 6 * 2.3 * np.sqrt(6 / count) / np.pi * noise
        shift = (found[0] - frequency) * span
        assert abs(shift) < 1e-5 + statistical + 0.02 * weaker, (number, shift, weaker, noise)
        change = found[1] / amplitude - 1
        assert abs(change) < 1e-5 + 6 * 1.4 * np.sqrt(2 / count) * noise + 0.02 * weaker, (number, change, weaker, noise)


def test_frequencies_are_peaks_of_the_periodogram(program):
    for number, (times, values, *_) in enumerate(oscillations()):
        if number % 2:
            continue
        step, count = times[1] - times[0], len(times)
        padded = max(2**20, 16 * 2 ** int(np.ceil(np.log2(count))))
        places, power = periodogram(values, 1 / step, "hann", padded, "linear", scaling="spectrum")
        seen = places > 3 / times[-1]
        peak = places[seen][np.argmax(power[seen])]
        found = statistics(program, times, values, ["frequency"])[0]
        # The drift that scipy takes out is not fitted under the window, so its peak is not quite that of the fit.
        assert abs(found - peak) * times[-1] < 0.05, number


def test_what_does_not_oscillate_has_no_frequency(program):
    times = np.linspace(0, 10, 1001)
    for values in [np.exp(-times / 3), 3 - times, np.full(1001, 5.0), times**2, np.tanh(times - 5)]:
        found = statistics(program, times, values, ["frequency", "oscillation-amplitude"])
        straight = np.ptp(np.diff(values)) < 1e-9
        assert np.isnan(found[0]) and (found[1] == 0 if straight else np.isnan(found[1]))
