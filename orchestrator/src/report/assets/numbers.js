"use strict";
// Special functions and intervals, as the crate `conformity` has them.
const Numbers = (() => {
  const ROOT_TWO = Math.SQRT2;

  // ---- the error function -------------------------------------------------------------------------
  // The series exp(-x^2) sum (2 x^2)^n / (2n+1)!! has positive terms only (Abramowitz and Stegun 1964, 7.1.6).
  const erfSeries = x => {
    let term = x, sum = x;
    for (let n = 1; term > sum * 1e-17; n++) sum += term *= 2 * x * x / (2 * n + 1);
    return 2 / Math.sqrt(Math.PI) * Math.exp(-x * x) * sum;
  };
  // The continued fraction x + (1/2)/(x + (2/2)/(x + (3/2)/(x + ... (7.1.14 there), from its far end.
  const erfcFraction = x => {
    let tail = x;
    for (let n = Math.ceil(20 + 240 / (x * x)); n > 0; n--) tail = x + 0.5 * n / tail;
    return Math.exp(-x * x) / (Math.sqrt(Math.PI) * tail);
  };
  const erfc = x => {
    const size = Math.abs(x);
    if (size > 27.3) return x > 0 ? 0 : 2;
    const own = size < 2.5 ? 1 - erfSeries(size) : erfcFraction(size);
    return x < 0 ? 2 - own : own;
  };

  /** The probability that a standard normal number is below z. */
  const below = z => 0.5 * erfc(-z / ROOT_TWO);

  /** The probability that it lies between two limits. */
  const between = (lower, upper) => {
    if (lower >= upper) return 0;
    // Far above the mean both probabilities round to 1: subtract the small tails.
    return lower > 0 ? below(-lower) - below(-upper) : below(upper) - below(lower);
  };

  // ---- two correlated normal numbers: Plackett's derivative, integrated over the arcsine of the correlation ----------
  const legendre = (() => {
    const nodes = 20, rule = [];
    for (let i = 0; i < nodes; i++) {
      let x = Math.cos(Math.PI * (i + 0.75) / (nodes + 0.5)), slope = 0;
      for (let turn = 0; turn < 8; turn++) {
        let before = 1, value = x;
        for (let k = 2; k <= nodes; k++) [before, value] = [value, ((2 * k - 1) * x * value - (k - 1) * before) / k];
        slope = nodes * (x * value - before) / (x * x - 1);
        x -= value / slope;
      }
      rule.push([x, 2 / ((1 - x * x) * slope * slope)]);
    }
    return rule;
  })();
  const cornerDensity = (h, k, correlation, cosine) => {
    if (!Number.isFinite(h) || !Number.isFinite(k)) return 0;
    const side = Math.sign(correlation);
    const square = (h - side * k) ** 2 + 2 * h * k * (side - correlation);
    return Math.exp(-square / (2 * cosine * cosine)) / (2 * Math.PI);
  };
  /** The probability that two standard normal numbers with a correlation between -1 and 1 lie between their limits. */
  const betweenBoth = (lower, upper, correlation) => {
    const alone = [0, 1].map(k => between(lower[k], upper[k]));
    if (Math.min(...alone) < 1e-17) return 0;
    const end = Math.asin(Math.abs(correlation)), side = Math.sign(correlation);
    let dependent = 0;
    for (let start = 0; start < end;) {
      const stop = Math.min(end, start + 0.6 * (Math.PI / 2 - start));
      const middle = 0.5 * (start + stop), half = 0.5 * (stop - start);
      for (const [node, weight] of legendre) {
        const angle = middle + half * node, sine = side * Math.sin(angle), cosine = Math.cos(angle);
        const density = (h, k) => side * half * weight * cornerDensity(h, k, sine, cosine);
        dependent += density(upper[0], upper[1]) - density(lower[0], upper[1]);
        dependent += density(lower[0], lower[1]) - density(upper[0], lower[1]);
      }
      start = stop;
    }
    return Math.min(Math.max(alone[0] * alone[1] + dependent, 0), 1);
  };

  // ---- the incomplete beta function -----------------------------------------------------------------
  // Stirling's series for arguments of 12 or more, reached by the recurrence.
  const lnGamma = x => {
    let shift = 0;
    for (; x < 12; x++) shift -= Math.log(x);
    const r = 1 / (x * x);
    const series = (1 / 12 - r * (1 / 360 - r * (1 / 1260 - r * (1 / 1680 - r * (1 / 1188 - r * 691 / 360360))))) / x;
    return shift + (x - 0.5) * Math.log(x) - x + 0.5 * Math.log(2 * Math.PI) + series;
  };
  // The continued fraction of DLMF 8.17.22 by the modified method of Lentz.
  const betaFraction = (a, b, x) => {
    const TINY = 1e-300;
    let c = 1, d = 1 / (1 - (a + b) * x / (a + 1) || TINY), value = d;
    for (let m = 1; m < 20000; m++) {
      const even = m * (b - m) * x / ((a + 2 * m - 1) * (a + 2 * m));
      d = 1 / (1 + even * d || TINY);
      c = 1 + even / c || TINY;
      value *= c * d;
      const odd = -(a + m) * (a + b + m) * x / ((a + 2 * m) * (a + 2 * m + 1));
      d = 1 / (1 + odd * d || TINY);
      c = 1 + odd / c || TINY;
      value *= c * d;
      if (Math.abs(c * d - 1) < 1e-16) break;
    }
    return value;
  };
  /** The regularised incomplete beta function. */
  const beta = (a, b, x) => {
    if (x <= 0) return 0;
    if (x >= 1) return 1;
    const front = Math.exp(lnGamma(a + b) - lnGamma(a) - lnGamma(b) + a * Math.log(x) + b * Math.log1p(-x));
    return x < (a + 1) / (a + b + 2) ? front * betaFraction(a, b, x) / a : 1 - front * betaFraction(b, a, 1 - x) / b;
  };

  // ---- errors that are not normal (`conformity::uncertainty::Law`): { normal, student, freedom, half_width } ----
  // The mean over the normal distributions of which the normal and Student's part are a mixture.
  const mixed = ({ normal, student, freedom }, of) => {
    if (student === 0) return of(normal);
    const step = 1.1 / Math.sqrt(freedom + 10);
    let sum = 0, weights = 0;
    for (const [first, by] of [[0, step], [-step, -step]]) {
      for (let place = first; ; place += by) {
        const weight = Math.exp(0.5 * freedom * (place - Math.expm1(place)));
        if (weight < 1e-14) break;
        sum += weight * of(Math.hypot(normal, student * Math.exp(-0.5 * place)));
        weights += weight;
      }
    }
    return sum / weights;
  };
  const belowBoth = (error, scale, half) => {
    if (half <= 1e-6 * scale) return below(error / scale);
    if (scale <= 1e-6 * half) return Math.min(Math.max(0.5 + 0.5 * error / half, 0), 1);
    const integral = z => z * below(z) + Math.exp(-0.5 * z * z) / Math.sqrt(2 * Math.PI);
    const area = integral((error + half) / scale) - integral((error - half) / scale);
    return Math.min(Math.max(area * scale / (2 * half), 0), 1);
  };
  const errorBelow = (law, error) => {
    if (!Number.isFinite(error)) return error > 0 ? 1 : 0;
    const tail = mixed(law, scale => belowBoth(-Math.abs(error), scale, law.half_width));
    return error > 0 ? 1 - tail : tail;
  };
  /** The probability that such an error lies between two limits. */
  const errorBetween = (law, lower, upper) => {
    if (lower >= upper) return 0;
    return lower > 0 ? errorBelow(law, -lower) - errorBelow(law, -upper) : errorBelow(law, upper) - errorBelow(law, lower);
  };
  /** The error as a standard normal number of the same probability (Abramowitz and Stegun 1964, 26.2.23, and Halley's steps). */
  const score = (law, error) => {
    const tail = errorBelow(law, -Math.abs(error));
    if (tail <= 0) return error > 0 ? Infinity : -Infinity;
    const t = Math.sqrt(-2 * Math.log(tail));
    let z = (2.515517 + t * (0.802853 + t * 0.010328)) / (1 + t * (1.432788 + t * (0.189269 + t * 0.001308))) - t;
    for (let turn = 0; turn < 3; turn++) {
      const off = (below(z) - tail) * Math.sqrt(2 * Math.PI) * Math.exp(0.5 * z * z);
      z -= off / (1 + 0.5 * z * off);
    }
    return error > 0 ? -z : z;
  };

  /** Where a function that grows from below 0 to above 0 between 0 and 1 changes its sign: just before and after. */
  const crossing = grows => {
    let low = 0, high = 1;
    while (high - low > 1e-14 * high) {
      const middle = 0.5 * (low + high);
      if (middle <= low || middle >= high) break;
      if (grows(middle) < 0) low = middle; else high = middle;
    }
    return [low, high];
  };

  // ---- limits and intervals -----------------------------------------------------------------------------
  const remembered = compute => {
    const known = new Map();
    return (...of) => {
      const key = of.join();
      if (!known.has(key)) known.set(key, compute(...of));
      return known.get(key);
    };
  };
  /** Within so many standard deviations a normal number lies with this probability. */
  const normalLimit = remembered(confidence => {
    const [low] = crossing(part => between(-40 * part, 40 * part) - confidence);
    return 40 * low;
  });
  /** The same of Student's distribution. */
  const studentLimit = remembered((confidence, freedom) => {
    if (freedom > 1e5) return normalLimit(confidence);
    const [part] = crossing(y => beta(0.5, freedom / 2, y) - confidence);
    return Math.sqrt(freedom * part / (1 - part));
  });

  /** Clopper and Pearson's interval of a share; the hits need not be whole. */
  const clopperPearson = remembered((hits, trials, confidence) => {
    const NONE = 0.1, tail = 0.5 * (1 - confidence), misses = trials - hits;
    const low = hits < NONE ? 0 : crossing(share => beta(hits, Math.max(misses, 0) + 1, share) - tail)[0];
    const high = misses < NONE ? 1 : crossing(share => beta(Math.max(hits, 0) + 1, misses, share) - 1 + tail)[1];
    return [low, high];
  });

  return { below, between, betweenBoth, errorBelow, errorBetween, score, beta, clopperPearson, studentLimit };
})();
