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

  const independent = (all, confidence) => Numbers.clopperPearson(all.sum, all.count, confidence);

  /** The interval of the mean of independent numbers, or of several samples that are independent of each other. */
  const ofMean = (parts, confidence) => {
    const all = total(parts);
    if (parts.length < Numbers.LEAST_SAMPLES || parts.some(part => part.count === 0)) return independent(all, confidence);
    return Numbers.ofSamples(mean(all), parts.map(mean), all.count, confidence);
  };

  /** The interval of the mean of the numbers of a random part of the sample, such as the accepted points. */
  const ofPart = (parts, confidence) => {
    const all = total(parts), samples = parts.length;
    if (samples < Numbers.LEAST_SAMPLES || all.count === 0) return independent(all, confidence);
    const ratio = mean(all), usual = all.count / samples;
    const values = parts.map(part => ratio + (part.sum - ratio * part.count) / usual);
    const ends = Numbers.ofSamples(ratio, values, all.count, confidence);
    return all.count < 4 * samples ? Numbers.wider(ends, independent(all, confidence)) : ends;
  };

  return { none, take, merge, total, mean, complement, scaled, among, ofMean, ofPart };
})();
