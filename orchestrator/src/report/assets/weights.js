"use strict";
// Other distributions of the parameters, by importance weights: each point counts as much as it is more probable in the changed
// study than in the study that drew it (Owen 2013, "Monte Carlo theory, methods and examples", 9.2).
const Weights = (() => {
  /** Fewer effective points than this tell little. */
  const FEW = 100;
  /** How far a distribution may be changed: beyond, a few points carry all the weight. */
  const REACH = { mean: 1, deviation: [0.5, 1.3] };
  const possible = ({ distribution }) => ["normal", "truncated-normal", "lognormal"].includes(distribution);

  // The logarithm of the density, but for a constant of the distribution; points outside of a cut do not occur in either study.
  const density = ({ distribution, mean, deviation }) => {
    if (distribution !== "lognormal") return x => -0.5 * ((x - mean) / deviation) ** 2;
    const variance = Math.log(1 + (deviation / mean) ** 2), centre = Math.log(mean) - variance / 2;
    return x => -0.5 * (Math.log(x) - centre) ** 2 / variance;
  };

  /** A weight for each point, with a mean of 1; `changes` has the new mean and deviation by the parameter's index. */
  const of = (parameters, changes, columns, size) => {
    const logs = new Float64Array(size);
    for (const key of Object.keys(changes)) {
      const before = density(parameters[key]), after = density({ ...parameters[key], ...changes[key] }), x = columns[key];
      for (let i = 0; i < size; i++) logs[i] += after(x[i]) - before(x[i]);
    }
    const most = logs.reduce((a, b) => Math.max(a, b), -Infinity);
    const weights = logs.map(log => Math.exp(log - most)), mean = weights.reduce((a, b) => a + b, 0) / size;
    return weights.map(weight => weight / mean);
  };

  /** The effective number of points. */
  const effective = weights => weights.length ** 2 / weights.reduce((sum, w) => sum + w * w, 0);

  /** The weighted mean of numbers, all of them or those of some points. */
  const mean = (weights, numbers, some) => {
    let top = 0, bottom = 0;
    for (let i = 0; i < weights.length; i++) {
      if (some && !some[i]) continue;
      top += weights[i] * numbers(i);
      bottom += weights[i];
    }
    return bottom > 0 ? top / bottom : null;
  };

  // The upper end for a share: Fay and Feuer's (1997, Statistics in Medicine 16, 791-801) for a weighted count, as a share. One
  // more point might have met the criteria, and it might have had the largest weight.
  const upper = (weights, holds, own, most, confidence) => {
    let sum = most, squares = most ** 2;
    for (let i = 0; i < weights.length; i++) if (holds(i)) {
      sum += weights[i];
      squares += weights[i] ** 2;
    }
    const points = Math.min(own, weights.length * sum / squares), count = Math.min(sum * points / weights.length - 1, points);
    return Numbers.clopperPearson(Math.max(count, 0), points, confidence)[1];
  };

  /** The interval of a weighted share: Clopper and Pearson's for as many points as the weights leave on its two sides. */
  const interval = (weights, flags, confidence) => {
    const share = mean(weights, i => flags[i]), n = weights.length;
    let variance = 0;
    for (let i = 0; i < n; i++) variance += (weights[i] * (flags[i] - share)) ** 2;
    // The points that carry the share may be weighted unlike the rest.
    const own = variance > 0 ? share * (1 - share) * n * n / variance : Infinity;
    const points = Math.min(effective(weights), own), most = weights.reduce((a, b) => Math.max(a, b), 0);
    const [low, high] = Numbers.clopperPearson(share * points, points, confidence);
    return [
      Math.min(low, 1 - upper(weights, i => !flags[i], points, most, confidence)),
      Math.max(high, upper(weights, i => flags[i], points, most, confidence)),
    ];
  };

  return { FEW, REACH, possible, of, effective, mean, interval };
})();
