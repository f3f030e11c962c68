"""The paper's study with gemseo-fmu: 50 points, and Sobol indices of 2,304 runs."""
from fmpy import extract, instantiate_fmu, read_model_description, simulate_fmu
from gemseo import sample_disciplines
from gemseo.algos.parameter_space import ParameterSpace
from gemseo.core.discipline.discipline import Discipline
from gemseo.uncertainty.sensitivity.sobol_analysis import SobolAnalysis
from numpy import array

NORMAL = {
    "load.stiffness": (100, 10), "load.damping": (14, 1.4), "load.preload": (48, 5.5),
    "load.eccentricity": (0.41e-3, 0.07e-3), "bearing.width": (19e-3, 0.19e-3), "bearing.diameter": (25e-3, 0.25e-3),
}
FIXED = {
    "bearing.roughness": 0, "thermal.freshOilShare": 0, "thermal.initialOilTemperature": 48 + 273.15,
    "thermal.initialBearingTemperature": 82 + 273.15, "oil.viscosityScale": 70.71, "thermal.filmCapacity": 116,
    "thermal.filmBushConductance": 0.1034, "thermal.filmShaftConductance": 0.2951, "thermal.bushCapacity": 215.2,
    "thermal.shaftCapacity": 47.87, "thermal.bushOilConductance": 0.02625, "thermal.shaftOilConductance": 0.39,
    "thermal.oilAmbientConductance": 0.5131, "thermal.initialFilmRise": -12.76, "thermal.initialShaftRise": 24.83,
}
WINDOWS = {
    "sensor.oilTemperature": (48 + 273.15, 0.5), "sensor.bearingTemperature": (82 + 273.15, 0.0075 * 82),
    "sensor.loadForce": (750, 0.07 * 750), "sensor.frictionPower": (14, 3),
}

space = ParameterSpace()
space.add_random_variable("bearing.radialClearance", "OTDistribution", interfaced_distribution="Normal",
                          interfaced_distribution_parameters=(20e-6, 5e-6), lower_bound=2e-6)
for name, (mean, deviation) in NORMAL.items():
    space.add_random_variable(name, "OTNormalDistribution", mu=mean, sigma=deviation)

folder = extract("dist/PlainBearingStand.fmu")
description = read_model_description(folder)
fmu = instantiate_fmu(folder, description)


class Stand(Discipline):  # FMUDiscipline sets fixed parameters again after the initialisation, which this FMU refuses
    def __init__(self):
        super().__init__()
        self.io.input_grammar.update_from_names(space.variable_names)
        self.io.output_grammar.update_from_names(WINDOWS)

    def _run(self, input_data):
        fmu.reset()
        result = simulate_fmu(folder, model_description=description, fmu_instance=fmu, stop_time=150, output_interval=150,
                              start_values=FIXED | {name: x[0] for name, x in input_data.items()}, output=list(WINDOWS))
        return {name: array([result[name][-1]]) for name in WINDOWS}


stand = Stand()
data = sample_disciplines([stand], space, list(WINDOWS), algo_name="OT_MONTE_CARLO", n_samples=50, seed=1, n_processes=2)
accepted = [k + 1 for k in range(50) if all(
    abs(data.get_view(variable_names=name).to_numpy()[k, 0] - nominal) <= tolerance
    for name, (nominal, tolerance) in WINDOWS.items())]
print("accepted:", len(accepted), "points:", accepted)

analysis = SobolAnalysis()
analysis.compute_samples([stand], space, 2304, list(WINDOWS), compute_second_order=False,
                         algo_settings={"n_processes": 2, "seed": 1})
analysis.compute_indices(algo=analysis.Algorithm.MARTINEZ)
first, total = analysis.get_intervals(), analysis.get_intervals(False)
for name in WINDOWS:
    for x in space.variable_names:
        print(name, x, "first", analysis.indices.first[name][0][x][0], *first[name][0][x].ravel(),
              "total", analysis.indices.total[name][0][x][0], *total[name][0][x].ravel())
