"""The points of designs as the program runs them."""

import csv
import json
import subprocess

import numpy as np
from scipy.stats import norm
from test_acceptance import PROGRAM, ROOT

NAMES = [f"thermal.{part}Temperature" for part in ["initialOil", "initialBearing", "ambient"]]
NAMES += ["bearing.radialClearance", "bearing.width", "oil.density15", "load.preload"]
STARTS = [321.15, 355.15, 295.15, 2e-5, 0.019, 880, 48]


def points(folder, method, count, seed, more=""):
    """A design's points in the unit cube."""
    text = f"fmu = {json.dumps(str(ROOT / 'dist' / 'PlainBearingStand.fmu'))}\n[simulation]\nstop = 0.01\nstep = 0.01\n"
    text += f"[design]\nmethod = '{method}'\npoints = {count}\nseed = {seed}\n"
    for name, start in zip(NAMES, STARTS):
        text += f"[parameters.\"{name}\"]\ndistribution = 'uniform'\nmin = {start}\nmax = {1.01 * start}\n"
    text += "[criteria.F]\nvariable = 'sensor.loadForce'\nnominal = 0\ntolerance = 1e9\n"
    (folder / "study.toml").write_text(text + more)
    command = [PROGRAM, "verify", folder / "study.toml", "--output", folder / f"out-{count}-{seed}", "--isolation", "none",
               "--extra-runs", "0"]
    subprocess.run(command, check=True, capture_output=True)
    with (folder / f"out-{count}-{seed}" / "points.csv").open() as file:
        rows = list(csv.DictReader(file))
    low = np.array(STARTS)
    return (np.array([[float(row[name]) for name in NAMES] for row in rows]) - low) / (0.01 * low)


def test_hypercubes_hold_a_point_in_each_slice(tmp_path):
    for column in points(tmp_path, "latin-hypercube", 200, 5).T:
        assert np.array_equal(np.sort(np.floor(column * 200)), np.arange(200))


def test_correlated_hypercubes_are_correlated_as_wanted(tmp_path):
    pairs = {(0, 1): 0.8, (0, 3): -0.5, (5, 6): 0.3}
    more = "".join(f"[[correlations]]\nbetween = {json.dumps([NAMES[a], NAMES[b]])}\ncoefficient = {r}\n"
                   for (a, b), r in pairs.items())
    found = points(tmp_path, "latin-hypercube", 1000, 5, more)
    wanted = np.eye(7)
    for (a, b), r in pairs.items():
        wanted[a, b] = wanted[b, a] = r
    # Four standard errors.
    np.testing.assert_allclose(np.corrcoef(norm.ppf(found).T), wanted, rtol=0, atol=4 / np.sqrt(1000))
