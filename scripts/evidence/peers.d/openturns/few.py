"""The share of the paper's study by OpenTURNS' Gaussian processes of 100 runs."""
import openturns as ot
from paper import WINDOW, joint, model

x = ot.LHSExperiment(joint, 100).generate()
y = model(x)
points = joint.getSample(20000)
predicted = ot.Sample(points.getSize(), 0)
for k in range(y.getDimension()):
    covariance = ot.MaternModel(x.computeStandardDeviation(), [1.0], 2.5)
    fitter = ot.GaussianProcessFitter(x, y.getMarginal(k), covariance, ot.LinearBasisFactory(x.getDimension()).build())
    fitter.run()
    process = ot.GaussianProcessRegression(fitter.getResult())
    process.run()
    predicted.stack(process.getResult().getMetaModel()(points))
print("share:", sum(map(WINDOW.contains, predicted)) / points.getSize())
