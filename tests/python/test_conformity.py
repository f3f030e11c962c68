"""Probabilities that a part conforms, given uncertain measured values, against draws of the measurement's errors."""

import csv
import json
import subprocess

import numpy as np
import pytest
from scipy import optimize, special, stats
from test_acceptance import PROGRAM

# Tolerance about 0, standard uncertainty.
CRITERIA = {"a": (1.0, 0.4), "b": (1.5, 0.6), "c": (2.0, 0.35), "d": (2.5, 1.0), "e": (1.8, 0.5)}
CORRELATED = {("a", "b"): -0.95, ("b", "d"): -0.3}
POINTS, DRAWS = 40, 1_000_000


def judged(folder, values, correlated):
    """What `judge` says of the points, given the correlations of the measurement's errors."""
    text = f'fmu = "none.fmu"\n[design]\nmethod = "monte-carlo"\npoints = {POINTS}\n'
    for name, (tolerance, uncertainty) in CRITERIA.items():
        text += f'[criteria.{name}]\nvariable = "{name}"\nnominal = 0\ntolerance = {tolerance}\n'
        text += f"uncertainty = {2 * uncertainty}\ncoverage = 2\n"
    for (first, second), coefficient in correlated.items():
        text += f'[[uncertainty-correlations]]\nbetween = ["{first}", "{second}"]\ncoefficient = {coefficient}\n'
    folder.mkdir()
    (folder / "study.toml").write_text(text)
    rows = [",".join(["point", *CRITERIA])]
    rows += [",".join([str(k + 1), *(repr(float(value)) for value in row)]) for k, row in enumerate(values)]
    (folder / "table.csv").write_text("\n".join(rows) + "\n")
    asked = [PROGRAM, "judge", folder / "study.toml", folder / "table.csv", "--output", folder / "out"]
    done = subprocess.run(asked, capture_output=True, text=True)
    assert done.returncode in (0, 1, 3), done.stderr
    return json.loads((folder / "out" / "summary.json").read_text())


def share(row, columns, tolerance):
    """The share of the draws in which each value and its error are within the tolerance."""
    left = np.ones(DRAWS, bool)
    for value, column, limit in zip(row, columns, tolerance, strict=True):
        left &= (column >= -limit - value) & (column <= limit - value)
    return left.mean()


def test_joint_probabilities_are_those_of_drawn_errors(tmp_path):
    """Independent errors multiply; those that are correlated, directly or over a third one, do not."""
    random = np.random.default_rng(106)
    tolerance, uncertainty = np.array(list(CRITERIA.values())).T
    values = random.standard_normal((POINTS, len(CRITERIA)))
    accepted = np.all(np.abs(values) <= tolerance, axis=1)
    assert 5 < accepted.sum() < POINTS - 5
    normal = random.standard_normal((DRAWS, len(CRITERIA)))
    names = list(CRITERIA)
    expected = []
    for number, correlated in enumerate(({}, CORRELATED)):
        matrix = np.eye(len(names))
        for (first, second), coefficient in correlated.items():
            i, j = names.index(first), names.index(second)
            matrix[i, j] = matrix[j, i] = coefficient
        errors = normal @ np.linalg.cholesky(matrix).T * uncertainty
        # A column a criterion: the draws that conform to all so far are asked of the next one.
        columns = [np.ascontiguousarray(column) for column in errors.T]
        conforming = np.array([share(row, columns, tolerance) for row in values])
        summary = judged(tmp_path / str(number), values, correlated)
        found = [summary["expected_verified"] / POINTS, summary["risk"]["consumer"], summary["risk"]["producer"]]
        drawn = [conforming.mean(), np.mean((1 - conforming) * accepted), np.mean(conforming * ~accepted)]
        # Four standard errors of a share of so many draws.
        np.testing.assert_allclose(found, drawn, rtol=0, atol=4 * 0.5 / DRAWS**0.5)
        expected.append(drawn[0])
    assert abs(expected[0] - expected[1]) > 0.004, "the correlations must matter"


def of_error(expanded, coverage, rectangular, gain, noise, repeats, value):
    """The distribution of a measured value's error: normal, Student's and rectangular parts by convolution; half the
    interval that holds 95.45 %; standard uncertainty, its Student's part and the degrees of freedom of that."""
    half = expanded if rectangular else 0
    normal = np.hypot(0 if rectangular else expanded / coverage, gain / (2 if rectangular else coverage) * value)
    student = noise / np.sqrt(repeats) if repeats > 1 else 0
    normal = normal if repeats > 1 else np.hypot(normal, noise)

    # Student's part by the middles of equally probable cells, so that no tail is cut off.
    parts = student * stats.t(repeats - 1).ppf((np.arange(40_000) + 0.5) / 40_000) if student else np.zeros(1)

    sigma = max(normal, 1e-7)

    # `stats.norm` looks at its arguments for longer than it computes.
    def integral(z):
        return z * special.ndtr(z) + np.exp(-z * z / 2) / np.sqrt(2 * np.pi)

    def cdf(x):
        z = x - parts
        if not half:
            return special.ndtr(z / sigma).mean()
        return (sigma * (integral((z + half) / sigma) - integral((z - half) / sigma)) / (2 * half)).mean()

    def half_interval(probability):
        return optimize.brentq(lambda x: 2 * cdf(x) - 1 - probability, 1e-9, 1e3, xtol=1e-9)

    standard = np.sqrt(normal**2 + student**2 + half**2 / 3)
    def beside_points(probability, scale, freedom):
        # The sum with the scatter of points, by its characteristic function (Gil-Pelaez).
        def of_student(t, scale, nu):
            z = np.sqrt(nu) * scale * t
            return special.kv(nu / 2, z) * z ** (nu / 2) / (special.gamma(nu / 2) * 2 ** (nu / 2 - 1))

        nodes, weights = np.polynomial.legendre.leggauss(1000)
        t, weights = 6 / scale * (nodes + 1), 6 / scale * weights
        of_all = np.exp(-((normal * t) ** 2) / 2) * np.sinc(half * t / np.pi) * of_student(t, scale, freedom)
        of_all = of_all * of_student(t, student, repeats - 1) if student else of_all
        return optimize.brentq(lambda x: 2 / np.pi * np.sum(weights * of_all * np.sin(t * x) / t) - probability, 1e-9, 50 * scale)

    return cdf, beside_points, half_interval(0.954499736), standard, student


# Six have each kind of limits with each law of the uncertainty.
@pytest.mark.parametrize("seed", [*range(6), *(pytest.param(seed, marks=pytest.mark.long) for seed in range(6, 12))])
def test_probabilities_and_e_n_are_those_of_scipy(tmp_path, seed):
    """Conformance of each point, acceptance by `point-risk`, E_n, k and effective degrees of freedom (ISO 13528, 9.7; GUM, G.4.1),
    for tolerances to one side, to two unlike ones, and to both."""
    draw = np.random.default_rng(seed)
    value, expanded, coverage = draw.uniform(5, 50), draw.uniform(0.2, 1), draw.choice([2, 1.96, 3])
    rectangular, gain, noise, repeats = bool(seed % 2), draw.choice([0, 0.01]), draw.choice([0.1, 0.5]), int(draw.choice([1, 2, 3, 5, 10]))
    minus, plus = [(1, 1), (0.6, 1.5), (np.inf, 0)][seed % 3]
    cdf, beside_points, of_measured, standard, student = of_error(expanded, coverage, rectangular, gain, noise, repeats, value)
    limits = {1: "tolerance = 1", 0.6: "tolerance = { minus = 0.6, plus = 1.5 }"}.get(minus)
    said = f"nominal = {value!r}\n{limits}" if limits else f"at-most = {value!r}\nmeasured = {value!r}"
    text = f"""fmu = "none.fmu"
[design]
method = "monte-carlo"
points = 30
[criteria.y]
variable = "y"
{said}
uncertainty = {expanded!r}
noise = {noise}
""" + (f"gain-uncertainty = {gain}\n" if gain else "") + (f"repeats = {repeats}\n" if repeats > 1 else "")
    text += 'uncertainty-distribution = "rectangular"\n' if rectangular else f"coverage = {coverage}\n"
    text += '[verdict]\nshare = "5 %"\npoint-risk = "10 %"\n'
    (tmp_path / "study.toml").write_text(text)
    values = value + draw.uniform(-2, 2, 30)
    (tmp_path / "table.csv").write_text("y\n" + "\n".join(repr(float(one)) for one in values) + "\n")
    asked = [PROGRAM, "judge", tmp_path / "study.toml", tmp_path / "table.csv", "--output", tmp_path / "out"]
    done = subprocess.run(asked, capture_output=True, text=True)
    assert done.returncode in (0, 1, 3), done.stderr
    rows = list(csv.DictReader((tmp_path / "out" / "points.csv").open()))
    for row, model in zip(rows, values, strict=True):
        low = cdf(model - value - plus) if np.isfinite(plus) else 0
        high = cdf(model - value + minus) if np.isfinite(minus) else 1
        conforming = high - low
        assert float(row["conformance"]) == pytest.approx(conforming, abs=1e-4), model
        accepted = -minus <= model - value <= plus and conforming >= 0.9
        assert row["accepted"] == str(accepted).lower(), (model, conforming)
    told = json.loads((tmp_path / "out" / "summary.json").read_text())["validation"]["y"]
    error, of_input, of_points = values.mean() - value, values.std(ddof=1), len(values)
    of_all = np.hypot(standard, of_input)
    # The value with the true parameters lies about the mean of the points, which errs, too.
    scale, freedom = of_input * np.sqrt(1 + 1 / of_points), of_points - 1
    of_model = scale * stats.t(freedom).ppf(0.5 + 0.954499736 / 2)
    assert told["e_n"] == pytest.approx(error / np.hypot(of_model, of_measured), abs=1e-4)
    assert told["u_val"] == pytest.approx(of_all, abs=1e-4)
    parts = (student / of_all) ** 4 / max(repeats - 1, 1) + (of_input / of_all) ** 4 / freedom
    assert told["freedom"] == pytest.approx(1 / parts, rel=1e-4)
    assert told["coverage"] * of_all == pytest.approx(beside_points(0.954499736, scale, freedom), abs=1e-4)
