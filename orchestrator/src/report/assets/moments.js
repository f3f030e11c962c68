"use strict";
// Sums over numbers from 0 to 1, and the intervals of their means, as `conformity::interval` has them.
const Moments = (() => {
  const none = () => ({ count: 0, sum: 0, squares: 0 });
  const take = (moments, number) => {
    moments.count += 1;
    moments.sum += number;
    moments.squares += number * number;
  };
  const merge = (into, other) => {
    into.count += other.count;
    into.sum += other.sum;
    into.squares += other.squares;
    return into;
  };
  const total = parts => parts.reduce(merge, none());
  const mean = moments => moments.sum / Math.max(moments.count, 1);
  const complement = ({ count, sum, squares }) => ({
    count,
    sum: Math.max(count - sum, 0),
    squares: Math.max(count - 2 * sum + squares, 0),
  });
  const scaled = ({ count, sum, squares }, factor) => ({ count, sum: factor * sum, squares: factor * factor * squares });
  const among = (moments, count) => ({ ...moments, count });

  const clamp = v => Math.min(Math.max(v, 0), 1);
  // Draws an interval out by what so many independent numbers may have missed.
  const drawnOut = (ends, all, confidence) => {
    const missed = Numbers.clopperPearson(0, all.count, confidence)[1], [low, high] = ends.map(clamp);
    return [Math.max(low - missed * mean(all), 0), high + missed * (1 - high)];
  };
  const ofNumbers = (all, confidence) => {
    const n = all.count, centre = mean(all);
    const variance = Math.max((all.squares - n * centre * centre) / (n - 1), 0);
    const half = Numbers.studentLimit(confidence, n - 1) * Math.sqrt(variance / n);
    return [centre - half, centre + half];
  };
  /** The interval of the mean of independent numbers, or of several nets that are independent of each other. */
  const ofMean = (parts, confidence) => {
    const all = total(parts);
    // Each net is one trial.
    if (parts.length > 1) {
      const sum = parts.reduce((a, part) => a + mean(part), 0);
      return parts.every(part => part.count > 0) ? Numbers.clopperPearson(sum, parts.length, confidence) : [0, 1];
    }
    const [low, high] = Numbers.clopperPearson(all.sum, all.count, confidence);
    if (all.count < 2) return [low, high];
    const scattering = drawnOut(ofNumbers(all, confidence), all, confidence);
    return [Math.max(low, scattering[0]), Math.min(high, scattering[1])];
  };

  /** The interval of the mean of the numbers of a random part of the sample, such as the accepted points. */
  const ofPart = (parts, confidence) => {
    const all = total(parts);
    if (parts.length < 2 || all.count === 0) return ofMean([all], confidence);
    const trials = all.count ** 2 / parts.reduce((a, part) => a + part.count ** 2, 0);
    return Numbers.clopperPearson(mean(all) * trials, trials, confidence);
  };

  /** The interval of a share of points that belong in turn to independent nets, by the count of each. */
  const ofCounts = (hits, points, confidence) => {
    const size = k => Math.floor(points / hits.length) + (k < points % hits.length ? 1 : 0);
    return ofMean(hits.map((count, k) => ({ count: size(k), sum: count, squares: count })), confidence);
  };

  return { none, take, merge, total, mean, complement, scaled, among, ofMean, ofPart, ofCounts };
})();
