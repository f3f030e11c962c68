"""The paper's study with FMPy and SALib: 50 points, and Sobol indices of 2,304 runs."""
from concurrent.futures import ProcessPoolExecutor

import numpy as np
from fmpy import extract, instantiate_fmu, read_model_description, simulate_fmu
from SALib.analyze import sobol as indices
from SALib.sample import latin, sobol

PROBLEM = {
    "names": ["bearing.radialClearance", "load.stiffness", "load.damping", "load.preload", "load.eccentricity",
              "bearing.width", "bearing.diameter"],
    "num_vars": 7,
    "dists": ["truncnorm"] + 6 * ["norm"],
    "bounds": [[2e-6, 1, 20e-6, 5e-6], [100, 10], [14, 1.4], [48, 5.5], [0.41e-3, 0.07e-3], [19e-3, 0.19e-3],
               [25e-3, 0.25e-3]],
}
FIXED = {
    "bearing.roughness": 0, "thermal.freshOilShare": 0, "thermal.initialOilTemperature": 48 + 273.15,
    "thermal.initialBearingTemperature": 82 + 273.15, "oil.viscosityScale": 70.71, "thermal.filmCapacity": 116,
    "thermal.filmBushConductance": 0.1034, "thermal.filmShaftConductance": 0.2951, "thermal.bushCapacity": 215.2,
    "thermal.shaftCapacity": 47.87, "thermal.bushOilConductance": 0.02625, "thermal.shaftOilConductance": 0.39,
    "thermal.oilAmbientConductance": 0.5131, "thermal.initialFilmRise": -12.76, "thermal.initialShaftRise": 24.83,
}
OUTPUTS = ["sensor.oilTemperature", "sensor.bearingTemperature", "sensor.loadForce", "sensor.frictionPower"]
NOMINAL = np.array([48 + 273.15, 82 + 273.15, 750, 14])
TOLERANCE = np.array([0.5, 0.0075 * 82, 0.07 * 750, 3])

folder = extract("dist/PlainBearingStand.fmu")
description = read_model_description(folder)
fmu = instantiate_fmu(folder, description)


def simulate(x):
    fmu.reset()
    result = simulate_fmu(folder, model_description=description, fmu_instance=fmu, stop_time=150, output_interval=150,
                          start_values=FIXED | dict(zip(PROBLEM["names"], x)), output=OUTPUTS)
    return [result[name][-1] for name in OUTPUTS]


def run(points):
    with ProcessPoolExecutor(2) as pool:
        return np.array(list(pool.map(simulate, points, chunksize=10)))


accepted = (abs(run(latin.sample(PROBLEM, 50, seed=1)) - NOMINAL) <= TOLERANCE).all(axis=1)
print("accepted:", accepted.sum(), "points:", *np.flatnonzero(accepted) + 1)
results = run(sobol.sample(PROBLEM, 256, calc_second_order=False, seed=1))
for output, values in zip(OUTPUTS, results.T):
    found = indices.analyze(PROBLEM, values, calc_second_order=False, seed=1)
    for i, name in enumerate(PROBLEM["names"]):
        print(output, name, "first", found["S1"][i], "+-", found["S1_conf"][i], "total", found["ST"][i], "+-", found["ST_conf"][i])
