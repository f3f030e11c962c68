"""The budget of an identified parameter, by which sensor's offset, gain and noise it is uncertain, against generalised least squares in
numpy: a gain error is a part of what the fit predicts."""

import json
import subprocess

import numpy as np
import pytest
from functions import pack
from scipy.optimize import least_squares
from test_acceptance import PROGRAM

ROWS = np.linspace(0.5, 3.0, 12)
LOW, HIGH = np.array([1.0, 0.2]), np.array([4.0, 2.0])


def model(x):
    """product, linear and wave at x1 = s, x2 = ROWS, x3 = r, one after the other, with their derivatives; s and r are unknown."""
    s, r = x
    one, none = np.ones_like(ROWS), np.zeros_like(ROWS)
    values = [s * ROWS, s + 2 * ROWS + 3 * r, (np.sin(6 * s) + 0.3 * s) * one]
    by_s = [ROWS, one, (6 * np.cos(6 * s) + 0.3) * one]
    return np.concatenate(values), np.column_stack([np.concatenate(by_s), np.concatenate([none, 3 * one, none])])


class Record:
    """Three sensors with random errors, and what they read."""

    NAMES = ("product", "linear", "wave")

    def __init__(self, seed):
        random = np.random.default_rng(seed)
        self.truth = random.uniform([2.0, 0.5], [3.0, 1.5])
        self.noise, self.offset = random.uniform(0.05, 0.3, 3), random.uniform(0.02, 0.2, 3)
        self.gain = random.uniform(0.2, 1.0, 3) * random.choice([0.005, 0.02, 0.05])
        self.sensor = np.repeat(np.eye(3), len(ROWS), axis=0)
        scatter = random.normal(size=len(self.sensor)) * (self.sensor @ self.noise)
        read = model(self.truth)[0]
        self.values = read * (1 + self.sensor @ (self.gain * random.normal(size=3))) + self.sensor @ (self.offset * random.normal(size=3)) + scatter

    def columns(self, predicted):
        return np.column_stack([self.sensor * self.offset, self.sensor * self.gain * predicted[:, None]])

    def weights(self, predicted):
        columns = self.columns(predicted)
        return np.linalg.inv(np.diag((self.sensor @ self.noise) ** 2) + columns @ columns.T)

    def fit(self, predicted, start):
        half = np.linalg.cholesky(self.weights(predicted)).T
        return least_squares(lambda x: half @ (model(x)[0] - self.values), start, lambda x: half @ model(x)[1], xtol=1e-14, ftol=1e-14).x

    def budgets(self):
        """The budgets of s and r, with their values."""
        found = self.truth
        for _ in range(20):
            predicted, slopes = model(found)
            found = self.fit(predicted, found)
        predicted, slopes = model(found)
        prior = np.diag(12 / (HIGH - LOW) ** 2)
        weights = self.weights(predicted)
        covariance = np.linalg.inv(slopes.T @ weights @ slopes + prior)
        pull = covariance @ slopes.T @ weights
        shares = {f"noise of {name}": (pull ** 2 @ (self.sensor[:, k] * self.noise[k] ** 2)) for k, name in enumerate(self.NAMES)}
        words = [f"{what} of {name}" for what in ("a zero error", "a gain error") for name in self.NAMES]
        shares |= dict(zip(words, (pull @ self.columns(predicted)).T ** 2, strict=True))
        shares["what was known before"] = np.diag(covariance @ prior @ covariance)
        return found, {name: share / np.diag(covariance) for name, share in shares.items()}

    def write(self, folder):
        rows = np.column_stack([ROWS, self.values.reshape(3, -1).T]).tolist()
        (folder / "cases.csv").write_text("x2,product,linear,wave\n" + "".join(",".join(map(repr, row)) + "\n" for row in rows))
        text = 'fmu = "functions.fmu"\n[identify]\ncases = "cases.csv"\n[identify.known.x2]\ncolumn = "x2"\n'
        for name, low, high in zip(("x1", "x3"), LOW, HIGH, strict=True):
            text += f"[identify.free.{name}]\nmin = {low}\nmax = {high}\n"
        for k, name in enumerate(self.NAMES):
            text += (f'[identify.measured.{name}]\nvariable = "{name}"\ncolumn = "{name}"\naccuracy = {self.noise[k]}\n'
                     f'uncertainty = {2 * self.offset[k]}\ngain-uncertainty = "{200 * self.gain[k]} %"\n')
        (folder / "study.toml").write_text(text)


@pytest.mark.parametrize("seed", [0, 2])
def test_budgets_are_those_of_generalised_least_squares(tmp_path, seed):
    pack(tmp_path, 3, *Record.NAMES)
    record = Record(seed)
    record.write(tmp_path)
    subprocess.run([PROGRAM, "identify", "study.toml", "--isolation", "none", "--output", "out"], cwd=tmp_path, check=True, capture_output=True)
    told = json.loads((tmp_path / "out" / "identification.json").read_text())
    found, expected = record.budgets()
    for k, influence in enumerate(told["influence"]):
        assert abs(told["optima"][0]["free"][k]["value"] - found[k]) < 1e-4 * (HIGH - LOW)[k]
        budget = {part["from"]: part["share"] for part in influence["budget"]}
        for name, shares in expected.items():
            assert abs(budget.get(name, 0.0) - shares[k]) < 1e-4, (influence["parameter"], name)
