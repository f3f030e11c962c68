"""Probabilities that a part conforms, given uncertain measured values, against draws of the measurement's errors."""

import json
import subprocess

import numpy as np
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
        conforming = np.array([np.mean(np.all(np.abs(row + errors) <= tolerance, axis=1)) for row in values])
        summary = judged(tmp_path / str(number), values, correlated)
        found = [summary["expected_verified"] / POINTS, summary["risk"]["consumer"], summary["risk"]["producer"]]
        drawn = [conforming.mean(), np.mean((1 - conforming) * accepted), np.mean(conforming * ~accepted)]
        # Four standard errors of a share of so many draws.
        np.testing.assert_allclose(found, drawn, rtol=0, atol=4 * 0.5 / DRAWS**0.5)
        expected.append(drawn[0])
    assert abs(expected[0] - expected[1]) > 0.004, "the correlations must matter"
