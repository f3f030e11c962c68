"use strict";
// Sums over numbers from 0 to 1, and the intervals of their means, as `conformity::interval` has them.
const Moments = (() => {
  const LEAST_SAMPLES = 8;
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
  // Draws an interval out by what so many numbers may have missed.
  const drawnOut = (ends, lowered, numbers, confidence) => {
    const missed = Numbers.clopperPearson(0, numbers, confidence)[1], [low, high] = ends.map(clamp);
    return [Math.max(low - missed * lowered, 0), high + missed * (1 - high)];
  };
  const nearer = (all, scattering, confidence) => {
    const [low, high] = Numbers.clopperPearson(all.sum, all.count, confidence);
    return [Math.max(low, scattering[0]), Math.min(high, scattering[1])];
  };
  const ofNumbers = (all, confidence) => {
    const n = all.count, centre = mean(all);
    const variance = Math.max((all.squares - n * centre * centre) / (n - 1), 0);
    const half = Numbers.studentLimit(confidence, n - 1) * Math.sqrt(variance / n);
    return [centre - half, centre + half];
  };

  /** The interval of the mean of one sample, or of several that are independent of each other. */
  const ofMean = (parts, confidence) => {
    const all = total(parts);
    let scattering = [0, 1];
    if (parts.length >= LEAST_SAMPLES && parts.every(part => part.count > 0)) {
      const ends = Numbers.student(mean(all), parts.map(mean), confidence);
      scattering = drawnOut(ends, 1, all.count, confidence);
    } else if (all.count > 1) {
      scattering = drawnOut(ofNumbers(all, confidence), mean(all), all.count, confidence);
    }
    return nearer(all, scattering, confidence);
  };

  /** The interval of the mean of the numbers of a random part of the sample, such as the accepted points. */
  const ofPart = (parts, confidence) => {
    const all = total(parts), samples = parts.length;
    if (samples < LEAST_SAMPLES || all.count < 4 * samples) return ofMean([all], confidence);
    const ratio = mean(all), usual = all.count / samples;
    const values = parts.map(part => ratio + (part.sum - ratio * part.count) / usual);
    const ends = Numbers.student(ratio, values, confidence);
    return nearer(all, drawnOut(ends, 1, all.count, confidence), confidence);
  };

  return { none, take, merge, total, mean, complement, scaled, among, ofMean, ofPart };
})();
