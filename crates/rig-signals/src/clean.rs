//! Spikes, marks of missing values and clipped samples of a recorded signal: found always, left out where the user wants it.

use nalgebra::DMatrix;
use sampling::statistics::moments::sorted;
use std::ops::Range;

/// Which doubtful samples of a signal its user wants left out: nothing goes that was not asked for.
#[derive(Clone, Copy, Debug, Default)]
pub struct Drop {
    /// Whether the user said what to do: then the samples that stay are no doubt.
    pub is_stated: bool,
    /// Samples that stand far from their neighbours.
    pub spikes: bool,
    /// Samples at an end of the sensor's range.
    pub clipped: bool,
}

/// A signal and what is doubtful in it.
pub struct Cleaned {
    /// The samples; not a number where one was left out.
    pub values: Vec<f64>,
    /// How many samples are spikes.
    pub spikes: usize,
    /// Values that stand far from all others, as marks of missing values do, each with how many samples have it.
    pub marks: Vec<(f64, usize)>,
    /// Which samples stand at the end of the sensor's range.
    pub clipped: Vec<bool>,
}

impl Cleaned {
    /// How many samples are clipped.
    pub fn clipped_count(&self) -> usize {
        self.clipped.iter().filter(|&&clipped| clipped).count()
    }

    /// Looks at the ends of those that are no spikes. A signal is clipped where the last level is taken much more often than the one
    /// next to it, by samples side by side; levels far from all others are marks.
    fn look_at_ends(&mut self, is_spike: &[bool]) {
        let rest: Vec<f64> =
            self.values.iter().zip(is_spike).map(|(v, spike)| if *spike { f64::NAN } else { *v }).collect();
        let mut ordered = sorted(rest.iter().copied().filter(|v| v.is_finite()).collect());
        // Marks at the other end may hide those at the first.
        for _ in 0..3 {
            let found = marks(&ordered);
            ordered.drain(..found.iter().map(|(_, count)| count).sum::<usize>());
            self.marks.extend(found);
            ordered.reverse();
        }
        for level in [clipping_level(ordered.iter()), clipping_level(ordered.iter().rev())] {
            let there: Vec<bool> = rest.iter().map(|value| level == Some(*value)).collect();
            let pairs = there.windows(2).filter(|w| w[0] && w[1]).count();
            // A signal that repeats itself has equal peaks, but no two of them side by side.
            if 4 * pairs >= there.iter().filter(|&&there| there).count() {
                self.clipped.iter_mut().zip(there).for_each(|(clipped, there)| *clipped |= there);
            }
        }
    }
}

/// Samples to either side of one whose median it is compared with: spikes may be three samples long.
const AROUND: usize = 3;
/// A spike is this many robust standard deviations from the median around it ...
const DEVIATIONS: f64 = 6.0;
/// ... and this part of the signal's range between the percentiles 5 and 95: the peaks of a smooth signal are none.
const PART: f64 = 0.1;
/// Nine samples of ten are no spikes, so their distances from the median show how far the signal itself strays: as many of
/// its deviations are needed. Of normal distances this part is within 1.645 deviations.
const USUAL: f64 = 0.9;
const USUAL_DEVIATIONS: f64 = 1.644_853_627;

/// How many samples on either side of a peak a polynomial follows, and its degree: from what follows the quickest signals to what
/// bears the most noise.
const BETWEEN: [[usize; 2]; 5] = [[3, 5], [4, 5], [4, 3], [5, 4], [6, 4]];
/// The same of samples on one side.
const BESIDE: [[usize; 2]; 6] = [[4, 1], [6, 1], [3, 2], [6, 2], [4, 3], [6, 5]];
/// A polynomial counts where so many standard deviations of its noise do not make it pass through a spike.
const CHANCE: f64 = 2.0;
/// The last digit of a slow signal flickers: a spike is more than this many levels of a coarse signal from the median.
const LEVELS: f64 = 2.5;

/// Finds spikes, marks of missing values and clipped samples, and leaves out those that the user does not want.
pub fn clean(values: &[f64], drop: Drop) -> Cleaned {
    let known: Vec<usize> = (0..values.len()).filter(|&k| values[k].is_finite()).collect();
    let samples: Vec<f64> = known.iter().map(|&k| values[k]).collect();
    let mut cleaned =
        Cleaned { values: values.to_vec(), spikes: 0, marks: Vec::new(), clipped: vec![false; values.len()] };
    if samples.len() <= 2 * AROUND {
        return cleaned;
    }
    let mut is_spike = vec![false; values.len()];
    for (place, spike) in known.iter().zip(spikes(&known, &samples)) {
        is_spike[*place] = spike;
    }
    cleaned.spikes = is_spike.iter().filter(|spike| **spike).count();
    cleaned.look_at_ends(&is_spike);
    for (k, value) in cleaned.values.iter_mut().enumerate() {
        if (drop.spikes && is_spike[k]) || (drop.clipped && cleaned.clipped[k]) {
            *value = f64::NAN;
        }
    }
    cleaned
}

/// Which samples at their places in the recording are spikes, by Hampel's identifier (Hampel 1974; Davies and Gather 1993, "The
/// identification of multiple outliers", J. Am. Stat. Assoc. 88), with one scale for the whole record. What follows from its
/// neighbours is none (as clicks are told from music: Godsill and Rayner 1998, "Digital Audio Restoration", chapter 5).
fn spikes(known: &[usize], samples: &[f64]) -> Vec<bool> {
    let off = |k: usize| samples[k] - median_around(samples, k);
    let off: Vec<f64> = (0..samples.len()).map(off).collect();
    let ordered = sorted(samples.to_vec());
    // Of a sample's distance from the middle of its neighbours, noise is 1.2 standard deviations and a slope nothing.
    let bends = samples.windows(3).map(|w| (w[1] - (w[0] + w[2]) / 2.0).abs());
    // The median of the sizes is 0.6745 standard deviations of normal noise.
    let scale = at_part(&sorted(bends.collect()), 0.5) / (0.674_489_75 * 1.5_f64.sqrt());
    let range = at_part(&ordered, 0.95) - at_part(&ordered, 0.05);
    let distances = sorted(off.iter().map(|off| off.abs()).collect());
    let strays = at_part(&distances, USUAL) / USUAL_DEVIATIONS;
    let step = ordered.windows(2).map(|w| w[1] - w[0]).filter(|step| *step > 0.0).fold(f64::INFINITY, f64::min);
    let least = DEVIATIONS * scale.max(strays);
    let least = least.max(PART * range).max(LEVELS * step);
    let mut spikes: Vec<bool> = off.iter().map(|off| range > 0.0 && off.abs() > least).collect();
    let signal = Signal { known, samples, off: &off, scale };
    signal.keep_what_follows(&mut spikes);
    spikes
}

/// A signal with samples that may be spikes.
struct Signal<'a> {
    /// Places of the samples in the recording.
    known: &'a [usize],
    samples: &'a [f64],
    /// How far each sample is from the median around it.
    off: &'a [f64],
    /// The standard deviation of the noise.
    scale: f64,
}

impl Signal<'_> {
    /// Takes out of the spikes what follows from samples around.
    fn keep_what_follows(&self, spikes: &mut [bool]) {
        let places: Vec<usize> = (0..spikes.len()).filter(|&k| spikes[k]).collect();
        for run in places.chunk_by(|a, b| a + 1 == *b) {
            let all = run[0]..run[run.len() - 1] + 1;
            let rest = self.spikes_within(all.clone());
            all.filter(|k| !rest.contains(k)).for_each(|k| spikes[k] = false);
        }
    }

    /// What is left of samples side by side without those that follow from samples before, behind or on both sides: the peak
    /// of a signal follows from those on both sides, the first swing after a step from those behind.
    fn spikes_within(&self, mut run: Range<usize>) -> Range<usize> {
        while !run.is_empty() {
            let before = |count: usize| run.start.saturating_sub(count)..run.start;
            let behind = |count: usize| run.end..(run.end + count).min(self.samples.len());
            if run.len() <= AROUND
                && BETWEEN.iter().any(|&[count, degree]| {
                    let around: Vec<usize> = before(count).chain(behind(count)).collect();
                    run.clone().all(|k| self.follows(k, &around, degree))
                })
            {
                return run.start..run.start;
            }
            let ends = |place: usize, others: &dyn Fn(usize) -> Range<usize>| {
                BESIDE.iter().any(|&[count, degree]| self.follows(place, &Vec::from_iter(others(count)), degree))
            };
            if ends(run.end - 1, &behind) {
                run.end -= 1;
            } else if ends(run.start, &before) {
                run.start += 1;
            } else {
                break;
            }
        }
        run
    }

    /// Whether the polynomial of a degree through others, by least squares, passes a sample nearer than half way from the
    /// median, and not by chance.
    fn follows(&self, place: usize, others: &[usize], degree: usize) -> bool {
        let at = |k: usize| self.known[k] as f64 - self.known[place] as f64;
        let Some(weights) = DMatrix::from_fn(others.len(), degree + 1, |row, power| at(others[row]).powi(power as i32))
            .pseudo_inverse(1e-12)
            .ok()
            .filter(|_| others.len() > degree)
        else {
            return false;
        };
        let weights = weights.row(0);
        let value: f64 = weights.iter().zip(others).map(|(weight, &k)| weight * self.samples[k]).sum();
        let half = self.off[place].abs() / 2.0;
        CHANCE * weights.norm() * self.scale <= half && (self.samples[place] - value).abs() <= half
    }
}

/// The first levels that are marks of missing values, such as -9999, and how many samples have each: farther from all others than these
/// are from each other, and rare, or absurd.
fn marks(ordered: &[f64]) -> Vec<(f64, usize)> {
    const LEVELS: usize = 3;
    const TIMES: f64 = 3.0;
    const ABSURD: f64 = 10.0;
    const RARE: usize = 10;
    let levels: Vec<&[f64]> = ordered.chunk_by(|a, b| a == b).collect();
    let are_marks = |count: &usize| {
        let (those, others) = levels.split_at(*count);
        let [mark, next, last] = [those[count - 1][0], others[0][0], others[others.len() - 1][0]];
        let samples: usize = those.iter().map(|level| level.len()).sum();
        let [away, range] = [mark - next, next - last].map(f64::abs);
        // A machine that rests stands nearer to 0 than one that runs.
        let is_absurd = mark.abs() > next.abs().max(last.abs()) && away > ABSURD * range;
        let rare = if is_absurd { 2 } else { RARE };
        // Several samples each: a signal that begins is no row of marks.
        let stand = *count == 1 || those.iter().all(|level| level.len() > 1);
        range > 0.0 && stand && away > TIMES * range && rare * samples < ordered.len()
    };
    let count = (1..levels.len().min(LEVELS + 1)).rfind(are_marks).unwrap_or(0);
    levels[..count].iter().map(|level| (level[0], level.len())).collect()
}

fn at_part(sorted: &[f64], part: f64) -> f64 {
    sorted[((sorted.len() - 1) as f64 * part).round() as usize]
}

/// The median of as many samples on either side; the first and the last sample are their own.
fn median_around(samples: &[f64], place: usize) -> f64 {
    let around = AROUND.min(place).min(samples.len() - 1 - place);
    sorted(samples[place - around..=place + around].to_vec())[around]
}

/// The first level, if so many samples stand at it that the signal must have been cut there.
fn clipping_level<'a>(ordered: impl ExactSizeIterator<Item = &'a f64>) -> Option<f64> {
    const LEAST: usize = 5;
    const TIMES: usize = 4;
    let all = ordered.len();
    let (mut levels, mut counts) = (Vec::new(), Vec::new());
    for &value in ordered {
        if levels.last() != Some(&value) {
            if levels.len() == 2 {
                break;
            }
            levels.push(value);
            counts.push(0);
        }
        *counts.last_mut()? += 1;
    }
    let [first, second] = counts[..] else { return None };
    // What rests is at zero.
    let many = levels[0] != 0.0 && first >= LEAST.max(all / 1000) && first > TIMES * second;
    many.then(|| levels[0])
}

#[cfg(test)]
mod tests;
