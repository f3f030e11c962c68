"""Rare shares by OpenTURNS with at most 150 runs: WHAT HOW, of stand, branches or oscillator, by form or gp.

form: FORM, then importance sampling around its design point. gp: a Gaussian process with runs where its sign is least known (Echard
et al. 2011), since OpenTURNS 1.27 has no such loop. 20,000 points tell 0.3 % to 13 %."""
import math
import sys

import openturns as ot

RUNS, POPULATION, BATCH = 150, 20_000, 5


def branches(z):
    x, y = z
    curved, total, apart = 3 + 0.1 * (x - y) ** 2, (x + y) / math.sqrt(2), 6 / math.sqrt(2)
    return [min(curved - total, curved + total, x - y + apart, y - x + apart)]


def oscillator(x):
    c1, c2, m, r, t1, f1 = x
    square = (c1 + c2) / m
    return [3 * r - abs(2 * f1 / (m * square) * math.sin(math.sqrt(square) * t1 / 2))]


def stand():
    from paper import joint, model
    return joint, lambda x: [28 - model(x)[3]]


def normal(function, means, deviations):
    return ot.JointDistribution([ot.Normal(*pair) for pair in zip(means, deviations)]), function


SUBJECTS = {
    "stand": stand,
    "branches": lambda: normal(branches, [0, 0], [1, 1]),
    "oscillator": lambda: normal(oscillator, [1, 0.1, 1, 0.5, 1, 1], [0.1, 0.01, 0.05, 0.05, 0.2, 0.2]),
}


def form(joint, margin):
    event = ot.ThresholdEvent(ot.CompositeRandomVector(margin, ot.RandomVector(joint)), ot.Less(), 0)
    solver = ot.AbdoRackwitz()
    # At the means the branches' least margin has a kink, and differences no slope.
    solver.setStartingPoint(joint.getMean() + 0.1 * joint.getStandardDeviation())
    solver.setMaximumCallsNumber(RUNS // 2)
    first = ot.FORM(solver, event)
    first.run()
    around = ot.PostAnalyticalImportanceSampling(first.getResult())
    around.setMaximumOuterSampling(RUNS - margin.getOutputHistory().getSize())
    around.setMaximumCoefficientOfVariation(0)
    around.run()
    result = around.getResult()
    return result.getProbabilityEstimate(), result.getConfidenceLength(0.95) / 2


def gp(joint, margin):
    scores_of = joint.getIsoProbabilisticTransformation()
    population = joint.getSample(POPULATION)
    scores = scores_of(population)
    wide = ot.JointDistribution([ot.Uniform(-4, 4)] * joint.getDimension())
    x = joint.getInverseIsoProbabilisticTransformation()(ot.LHSExperiment(wide, 20).generate())
    y = margin(x)
    while True:
        covariance = ot.MaternModel([1.0] * x.getDimension(), [1.0], 2.5)
        fitter = ot.GaussianProcessFitter(scores_of(x), y, covariance, ot.ConstantBasisFactory(x.getDimension()).build())
        fitter.run()
        process = ot.GaussianProcessRegression(fitter.getResult())
        process.run()
        mean = process.getResult().getMetaModel()(scores)
        variance = ot.GaussianProcessConditionalCovariance(process.getResult()).getConditionalMarginalVariance(scores)
        doubt = [abs(m[0]) / math.sqrt(max(v[0], 1e-300)) for m, v in zip(mean, variance)]
        order = sorted(range(POPULATION), key=doubt.__getitem__)[:BATCH]
        if doubt[order[0]] > 2 or x.getSize() + BATCH > RUNS:
            return sum(m[0] < 0 for m in mean) / POPULATION, math.nan
        x.add(population.select(order))
        y.add(margin(population.select(order)))


joint, function = SUBJECTS[sys.argv[1]]()
ot.RandomGenerator.SetSeed(1)
margin = ot.MemoizeFunction(ot.PythonFunction(joint.getDimension(), 1, function))
estimate, half = {"form": form, "gp": gp}[sys.argv[2]](joint, margin)
print("share:", estimate, "+-", half, "runs:", margin.getOutputHistory().getSize())
