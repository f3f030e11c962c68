"""The paper's study with OpenTURNS and FMPy: 50 points, Sobol indices of 2,304 runs, and those of a polynomial of 200."""
import openturns as ot
from fmpy import extract, instantiate_fmu, read_model_description, simulate_fmu

INPUTS = {
    "bearing.radialClearance": ot.TruncatedDistribution(ot.Normal(20e-6, 5e-6), 2e-6, ot.TruncatedDistribution.LOWER),
    "load.stiffness": ot.Normal(100, 10), "load.damping": ot.Normal(14, 1.4), "load.preload": ot.Normal(48, 5.5),
    "load.eccentricity": ot.Normal(0.41e-3, 0.07e-3), "bearing.width": ot.Normal(19e-3, 0.19e-3),
    "bearing.diameter": ot.Normal(25e-3, 0.25e-3),
}
FIXED = {
    "bearing.roughness": 0, "thermal.freshOilShare": 0, "thermal.initialOilTemperature": 48 + 273.15,
    "thermal.initialBearingTemperature": 82 + 273.15, "oil.viscosityScale": 70.71, "thermal.filmCapacity": 116,
    "thermal.filmBushConductance": 0.1034, "thermal.filmShaftConductance": 0.2951, "thermal.bushCapacity": 215.2,
    "thermal.shaftCapacity": 47.87, "thermal.bushOilConductance": 0.02625, "thermal.shaftOilConductance": 0.39,
    "thermal.oilAmbientConductance": 0.5131, "thermal.initialFilmRise": -12.76, "thermal.initialShaftRise": 24.83,
}
OUTPUTS = ["sensor.oilTemperature", "sensor.bearingTemperature", "sensor.loadForce", "sensor.frictionPower"]
WINDOW = ot.Interval([48 - 0.5 + 273.15, 82 * 0.9925 + 273.15, 750 * 0.93, 14 - 3],
                     [48 + 0.5 + 273.15, 82 * 1.0075 + 273.15, 750 * 1.07, 14 + 3])

folder = extract("dist/PlainBearingStand.fmu")
description = read_model_description(folder)
fmu = instantiate_fmu(folder, description)


def simulate(x):
    fmu.reset()
    result = simulate_fmu(folder, model_description=description, fmu_instance=fmu, stop_time=150, output_interval=150,
                          start_values=FIXED | dict(zip(INPUTS, x)), output=OUTPUTS)
    return [result[name][-1] for name in OUTPUTS]


ot.RandomGenerator.SetSeed(1)
joint = ot.JointDistribution(list(INPUTS.values()))
joint.setDescription(list(INPUTS))
model = ot.MemoizeFunction(ot.PythonFunction(7, 4, simulate, n_cpus=2))

if __name__ == "__main__":
    event = ot.DomainEvent(ot.CompositeRandomVector(model, ot.RandomVector(joint)), WINDOW)
    share = ot.ProbabilitySimulationAlgorithm(event, ot.MonteCarloExperiment())
    share.setMaximumOuterSampling(1)
    share.setBlockSize(50)
    share.run()
    estimate, half = share.getResult().getProbabilityEstimate(), share.getResult().getConfidenceLength(0.95) / 2
    accepted = [k + 1 for k, y in enumerate(model.getOutputHistory()) if WINDOW.contains(y)]
    print("accepted:", len(accepted), "points:", accepted, "share:", estimate, "+-", half)

    x = ot.SobolIndicesExperiment(joint, 256, False).generate()
    y = model(x)
    few, held_out = joint.getSample(200), joint.getSample(50)
    of_few, of_held_out = model(few), model(held_out)
    basis = ot.OrthogonalProductPolynomialFactory(list(INPUTS.values()))
    terms = ot.FixedStrategy(basis, basis.getEnumerateFunction().getBasisSizeFromTotalDegree(3))
    sparse = ot.LeastSquaresStrategy(ot.LeastSquaresMetaModelSelectionFactory())
    for k, output in enumerate(OUTPUTS):
        indices = ot.MartinezSensitivityAlgorithm(x, y.getMarginal(k), 256)
        first, total = indices.getFirstOrderIndicesInterval(), indices.getTotalOrderIndicesInterval()
        chaos = ot.FunctionalChaosAlgorithm(few, of_few.getMarginal(k), joint, terms, sparse)
        chaos.run()
        polynomial = ot.FunctionalChaosSobolIndices(chaos.getResult())
        quality = ot.MetaModelValidation(of_held_out.getMarginal(k), chaos.getResult().getMetaModel()(held_out)).computeR2Score()
        for i, name in enumerate(INPUTS):
            print(output, name, "first", indices.getFirstOrderIndices()[i], first.getLowerBound()[i], first.getUpperBound()[i],
                  "total", indices.getTotalOrderIndices()[i], total.getLowerBound()[i], total.getUpperBound()[i],
                  "polynomial", polynomial.getSobolTotalIndex(i), "R2", quality[0])
