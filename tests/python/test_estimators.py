"""Sensitivity indices against SALib and OpenTURNS, on the runs of the stand itself."""

import csv
import json
import subprocess

import numpy as np
import pytest
from test_acceptance import PROGRAM, ROOT

STUDY = ROOT / "studies" / "paper-table3.toml"
PARAMETERS, BASE = 7, 128
# Estimates of one design scatter, so bounds are asked of the means over these.
SEEDS = (1, 2, 3, 4)
CRITERIA = ["T_oil", "T_bearing", "F_N", "P_fr"]


def orchestrator(*arguments):
    # The stand spoils nothing: processes for thousands of short runs would take seven times as long.
    subprocess.run([PROGRAM, *map(str, arguments), "--isolation", "none"], cwd=ROOT, check=True, capture_output=True)


def results(folder):
    """The result, and the runs as columns."""
    with (folder / "sensitivity-runs.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert all(row["status"] == "ok" for row in rows)
    names = list(rows[0])[:-2]
    columns = {name: np.array([float(row[name]) for row in rows]) for name in names}
    columns["verified"] = np.array([float(row["verified"] == "true") for row in rows])
    result = json.loads((folder / "sensitivity.json").read_text())
    return {output["name"]: output for output in result["outputs"]}, columns, names[:PARAMETERS]


def values(estimates):
    return np.array([estimate["value"] for estimate in estimates])


def problem(names):
    return {"num_vars": len(names), "names": names, "bounds": [[0, 1]] * len(names)}


@pytest.fixture(scope="module")
def designs(tmp_path_factory):
    """For each seed what `results` gives."""
    found = []
    for seed in SEEDS:
        folder = tmp_path_factory.mktemp(f"seed{seed}")
        orchestrator("sensitivity", STUDY, "--base", BASE, "--seed", seed, "--output", folder)
        found.append(results(folder))
    return found


def blocks(y):
    """A, B and the mixed samples, a column a parameter."""
    y = y.reshape(BASE, PARAMETERS + 2)
    return y[:, 0], y[:, -1], y[:, 1:-1]


@pytest.mark.parametrize("name", CRITERIA)
def test_few_runs_that_carry_the_variance_tell_no_interval(designs, name):
    # Where the film is thinnest, a few runs are so much warmer that they carry most of the variance.
    for outputs, columns, _ in designs:
        squares = (columns[name] - columns[name].mean()) ** 2
        carriers = 2 * BASE / squares.size * squares.sum() ** 2 / (squares**2).sum()
        for order in ("first", "total"):
            assert all((one["high"] is None) == (carriers < 8) for one in outputs[name]["sobol"][order]), carriers


@pytest.mark.parametrize("order", ["first", "total"])
@pytest.mark.parametrize("name", CRITERIA)
def test_sobol_indices_agree_with_openturns(designs, name, order):
    import openturns as ot
    ours, lows, highs = [], [], []
    for outputs, columns, _ in designs:
        a, b, mixed = blocks(columns[name])
        inputs = ot.Sample(np.zeros((BASE * (PARAMETERS + 2), PARAMETERS)))
        stacked = ot.Sample(np.concatenate([a, b, *mixed.T])[:, None])
        theirs = ot.SaltelliSensitivityAlgorithm(inputs, stacked, BASE)
        ot.RandomGenerator.SetSeed(1)
        theirs.setBootstrapSize(300)
        interval = theirs.getFirstOrderIndicesInterval() if order == "first" else theirs.getTotalOrderIndicesInterval()
        lows.append(list(interval.getLowerBound()))
        highs.append(list(interval.getUpperBound()))
        ours.append(values(outputs[name]["sobol"][order]))
    low, mean, high = (np.mean(each, axis=0) for each in (lows, ours, highs))
    assert np.all(mean >= low) and np.all(mean <= high), (low, mean, high)


def test_elementary_effects_equal_salib(tmp_path):
    from SALib.analyze import morris
    orchestrator("sensitivity", STUDY, "--morris", "12", "--output", tmp_path)
    outputs, columns, names = results(tmp_path)
    # The grid behind the parameters: the ranks of their four levels.
    grid = np.column_stack([np.unique(columns[name].round(12), return_inverse=True)[1] / 3 for name in names])
    for name in CRITERIA:
        expected = morris.analyze(problem(names), grid, columns[name], num_levels=4, seed=1)
        effects = outputs[name]["morris"]
        scale = max(np.abs(expected["mu"]).max(), 1)
        assert np.allclose([e["mu"] for e in effects], expected["mu"], rtol=0, atol=1e-10 * scale)
        assert np.allclose([e["mu_star"]["value"] for e in effects], expected["mu_star"], rtol=0, atol=1e-10 * scale)
        assert np.allclose([e["sigma"] for e in effects], expected["sigma"], rtol=0, atol=1e-10 * scale)


def test_the_clearance_dominates_the_bearing_temperature(tmp_path):
    orchestrator("sensitivity", STUDY, "--base", "512", "--output", tmp_path)
    outputs, _, names = results(tmp_path)
    assert outputs["T_bearing"]["dominant"] == "bearing.radialClearance"
    assert values(outputs["T_bearing"]["sobol"]["total"])[names.index("bearing.radialClearance")] > 0.8
