"""Risks with limits that stand alone, uneven tolerances and errors that are not normal, against integrals in numpy and scipy."""

import json
import subprocess

import numpy as np
import pytest
from scipy import special, stats
from test_acceptance import PROGRAM

POINTS = 20_000
NODES, WEIGHTS = np.polynomial.legendre.leggauss(200)
# Of the smooth integrals inside.
INNER, INNER_WEIGHTS = np.polynomial.legendre.leggauss(48)


def error_below(normal, student, freedom, half_width):
    """The distribution function of the sum of a normal, a Student's and a rectangular error."""
    scale = normal or student
    if scale == 0:
        return lambda x: np.clip(0.5 + 0.5 * x / half_width, 0, 1)

    def smooth(x):
        if not normal * student:
            return special.ndtr(x / normal) if normal else special.stdtr(freedom, x / student)
        z = 9 * INNER
        return special.stdtr(freedom, (np.asarray(x)[..., None] - normal * z) / student) @ (9 * INNER_WEIGHTS * stats.norm.pdf(z))

    if half_width == 0:
        return smooth
    return lambda x: sum(w * smooth(x - half_width * node) for node, w in zip(INNER, INNER_WEIGHTS, strict=True)) / 2


def integrated(below, lower, upper, mean, deviation):
    """Consumer's and producer's risk of simple acceptance over a normal population."""
    ends = [mean - 9 * deviation, *(x for x in (lower, upper) if np.isfinite(x)), mean + 9 * deviation]
    risks = [0.0, 0.0]
    for left, right in zip(ends, ends[1:], strict=False):
        x = 0.5 * (left + right) + 0.5 * (right - left) * NODES
        conforms = below(upper - x) - below(lower - x)
        is_accepted = lower <= 0.5 * (left + right) <= upper
        share = 0.5 * (right - left) * WEIGHTS * stats.norm.pdf(x, mean, deviation)
        risks[0 if is_accepted else 1] += np.sum(share * ((1 - conforms) if is_accepted else conforms))
    return risks


def judged(folder, criteria, columns):
    text = f'fmu = "none.fmu"\n[design]\nmethod = "monte-carlo"\npoints = {len(columns[0])}\n{criteria}'
    (folder / "study.toml").write_text(text)
    rows = [",".join(["point", *"xyz"[: len(columns)]])]
    rows += [",".join([str(k + 1), *(repr(float(v)) for v in row)]) for k, row in enumerate(zip(*columns, strict=True))]
    (folder / "table.csv").write_text("\n".join(rows) + "\n")
    asked = [PROGRAM, "judge", folder / "study.toml", folder / "table.csv", "--output", folder / "out"]
    done = subprocess.run(asked, capture_output=True, text=True)
    assert done.returncode in (0, 1, 3), done.stderr
    return json.loads((folder / "out" / "summary.json").read_text())


INFINITE = np.inf
CASES = {
    "one-sided": ("at-most = 85\nuncertainty = 0.5", (0.25, 0, 0, 0), -INFINITE, 85, (84, 0.6)),
    "rectangular": (
        'at-most = 85\nuncertainty = 0.433\nuncertainty-distribution = "rectangular"', (0, 0, 0, 0.433), -INFINITE, 85, (84, 0.6),
    ),
    "Student": (f"at-least = 83.2\nnoise = {0.25 * 3**0.5!r}\nrepeats = 3", (0, 0.25, 2, 0), 83.2, INFINITE, (84, 0.6)),
    "Student and normal": (
        f"nominal = 84\ntolerance = {{ minus = 0.5, plus = 1 }}\nuncertainty = 0.3\nnoise = {0.2 * 2**0.5!r}\nrepeats = 2",
        (0.15, 0.2, 1, 0), 83.5, 85, (84, 0.6),
    ),
    "all three": (
        f'nominal = 84\ntolerance = {{ minus = 0.5, plus = 1 }}\nuncertainty = 0.3\nuncertainty-distribution = "rectangular"\n'
        f"noise = {0.2 * 5**0.5!r}\nrepeats = 5\ngain-uncertainty = {0.2 / 84!r}",
        (0.1, 0.2, 4, 0.3), 83.5, 85, (84, 0.6),
    ),
    "bearing, C_m = 1": ("nominal = 82\ntolerance = 0.615\nuncertainty = 0.615", (0.3075, 0, 0, 0), 81.385, 82.615, (81.486108, 0.345215)),
    "load, C_m = 4": (
        "nominal = 750\ntolerance = 52.5\nuncertainty = 13.125", (6.5625, 0, 0, 0), 697.5, 802.5, (769.503815, 89.266864),
    ),
}
PUBLISHED = {"one-sided": (0.02514, 0.01096), "rectangular": (0.02640, 0.01211), "bearing, C_m = 1": (0.1338, 0.0984), "load, C_m = 4": (0.0199, 0.0188)}


@pytest.mark.parametrize("given", CASES)
def test_risks_are_the_integrals_of_jcgm_106(tmp_path, given):
    keys, law, lower, upper, population = CASES[given]
    values = stats.norm.ppf((np.arange(POINTS) + 0.5) / POINTS, *population)
    risk = judged(tmp_path, f'[criteria.x]\nvariable = "x"\n{keys}\n', [values])["risk"]
    expected = integrated(error_below(*law), lower, upper, *population)
    np.testing.assert_allclose([risk["consumer"], risk["producer"]], expected, rtol=0, atol=1e-4)
    if given in PUBLISHED:
        np.testing.assert_allclose(expected, PUBLISHED[given], rtol=0, atol=6e-5)


def test_a_product_is_no_second_measurement(tmp_path):
    """Power from a torque at a known speed: whoever conforms in one does in the other, and the joint risk is that of one."""
    torque = stats.norm.ppf((np.arange(2000) + 0.5) / 2000, 0.5, 0.02)
    study = '[fixed]\nspeed = 30\n[criteria.M]\nvariable = "x"\nnominal = 0.5\ntolerance = "5 %"\nuncertainty = "4 %"\n'
    alone = judged(tmp_path, study, [torque])["risk"]
    power = '[criteria.P]\nvariable = "y"\nnominal = 15\ntolerance = "5 %"\nderived = { from = "M", by = "speed" }\n'
    both = judged(tmp_path, study + power, [torque, 30 * torque])["risk"]
    assert both["consumer"] == pytest.approx(alone["consumer"], abs=1e-9)
    assert both["conformance_probability"] == pytest.approx(alone["conformance_probability"], abs=1e-9)
