"""The posterior of the paper's study by OpenTURNS' Gaussian processes of 80 runs: mean and deviation of the clearance."""
import openturns as ot
from paper import INPUTS, joint, model

MEASURED = [48 + 273.15, 82 + 273.15, 750, 14]
ACCURACY = [0.5 / 3 ** 0.5, 0.615 / 3 ** 0.5, 52.5 / 3 ** 0.5, 0.452]
STEPS = 20_000

x = ot.LHSExperiment(joint, 80).generate()
y = model(x)
predictions = []
for k in range(y.getDimension()):
    covariance = ot.MaternModel(x.computeStandardDeviation(), [1.0], 2.5)
    fitter = ot.GaussianProcessFitter(x, y.getMarginal(k), covariance, ot.LinearBasisFactory(x.getDimension()).build())
    fitter.run()
    process = ot.GaussianProcessRegression(fitter.getResult())
    process.run()
    predictions.append(process.getResult().getMetaModel())
predicted = ot.AggregatedFunction(predictions)
error = ot.Normal(MEASURED, ACCURACY)
density = ot.PythonFunction(7, 1, lambda p: [joint.computeLogPDF(p) + error.computeLogPDF(predicted(p))])
deviations = joint.getStandardDeviation()
proposal = ot.Normal([0] * 7, [0.3 * deviation for deviation in deviations])
sampler = ot.RandomWalkMetropolisHastings(density, joint.getRange(), joint.getMean(), proposal)
sampler.setBurnIn(STEPS // 10)
sample = sampler.getSample(STEPS).getMarginal(list(INPUTS).index("bearing.radialClearance"))
print("clearance:", 1e6 * sample.computeMean()[0], "+-", 1e6 * sample.computeStandardDeviation()[0], "um")
