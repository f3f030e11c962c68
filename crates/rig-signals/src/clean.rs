//! Spikes and clipped samples of a recorded signal.

use sampling::statistics::moments::sorted;

/// A signal without its spikes.
#[derive(Clone, Debug, PartialEq)]
pub struct Cleaned {
    /// The samples; not a number where there was a spike.
    pub values: Vec<f64>,
    /// How many spikes were left out.
    pub spikes: usize,
    /// How many samples stood far from all others at one value, which says that there is none; left out, too.
    pub marks: usize,
    /// Which samples stand at the end of the sensor's range.
    pub clipped: Vec<bool>,
}

impl Cleaned {
    /// How many samples are clipped.
    pub fn clipped_count(&self) -> usize {
        self.clipped.iter().filter(|&&clipped| clipped).count()
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

/// Finds spikes by Hampel's identifier (Hampel 1974; Davies and Gather 1993, "The identification of multiple outliers", J.
/// Am. Stat. Assoc. 88), with one scale for the whole record, and clipped samples by an end of the range that is taken
/// much more often than the level next to it, by samples side by side.
pub fn clean(values: &[f64]) -> Cleaned {
    let known: Vec<usize> = (0..values.len())
        .filter(|&k| values[k].is_finite())
        .collect();
    let samples: Vec<f64> = known.iter().map(|&k| values[k]).collect();
    let mut cleaned = Cleaned {
        values: values.to_vec(),
        spikes: 0,
        marks: 0,
        clipped: vec![false; values.len()],
    };
    if samples.len() <= 2 * AROUND {
        return cleaned;
    }
    let off = |k: usize| samples[k] - median_around(&samples, k);
    let off: Vec<f64> = (0..samples.len()).map(off).collect();
    let ordered = sorted(samples.to_vec());
    // Of a sample's distance from the middle of its neighbours, noise is 1.2 standard deviations and a slope nothing.
    let bends = samples
        .windows(3)
        .map(|w| (w[1] - (w[0] + w[2]) / 2.0).abs());
    // The median of the sizes is 0.6745 standard deviations of normal noise.
    let scale = at_part(&sorted(bends.collect()), 0.5) / (0.674_489_75 * 1.5_f64.sqrt());
    let range = at_part(&ordered, 0.95) - at_part(&ordered, 0.05);
    let distances = sorted(off.iter().map(|off| off.abs()).collect());
    let strays = at_part(&distances, USUAL) / USUAL_DEVIATIONS;
    let least = (DEVIATIONS * scale.max(strays)).max(PART * range);
    for (&place, off) in known.iter().zip(&off) {
        if range > 0.0 && off.abs() > least {
            cleaned.values[place] = f64::NAN;
            cleaned.spikes += 1;
        }
    }
    let rest = cleaned.values.iter().copied().filter(|v| v.is_finite());
    let rest = sorted(rest.collect());
    let ends = [
        clipping_level(rest.iter()),
        clipping_level(rest.iter().rev()),
    ];
    for end in ends.into_iter().flatten() {
        let there: Vec<bool> = cleaned.values.iter().map(|value| *value == end).collect();
        let pairs = there.windows(2).filter(|w| w[0] && w[1]).count();
        let others: Vec<f64> = rest.iter().copied().filter(|value| *value != end).collect();
        if is_mark(end, &others, rest.len()) {
            let found = cleaned.values.iter_mut().filter(|value| **value == end);
            cleaned.marks += found.map(|value| *value = f64::NAN).count();
            continue;
        }
        // A signal that repeats itself has equal peaks, but no two of them side by side.
        if 4 * pairs >= there.iter().filter(|&&there| there).count() {
            let pairs = cleaned.clipped.iter_mut().zip(there);
            pairs.for_each(|(clipped, there)| *clipped |= there);
        }
    }
    cleaned
}

/// Whether a level is a mark of missing values, such as -9999: farther from all others, growing, than these are from each
/// other, and rare.
fn is_mark(level: f64, others: &[f64], all: usize) -> bool {
    const TIMES: f64 = 3.0;
    const RARE: usize = 10;
    let [Some(low), Some(high)] = [others.first(), others.last()] else {
        return false;
    };
    let away = (low - level).max(level - high);
    high > low && away > TIMES * (high - low) && RARE * (all - others.len()) < all
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
    let [first, second] = counts[..] else {
        return None;
    };
    // What rests is at zero.
    let many = levels[0] != 0.0 && first >= LEAST.max(all / 1000) && first > TIMES * second;
    many.then(|| levels[0])
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng, rngs::StdRng};
    use rand_distr::StandardNormal;
    use std::f64::consts::TAU;

    fn signal(noise: f64) -> Vec<f64> {
        let mut random = StdRng::seed_from_u64(3);
        let wave = |k: u32| 1.0 + 0.6 * (TAU * f64::from(k) / 40.0).sin();
        (0..4000)
            .map(|k| wave(k) + noise * random.sample::<f64, _>(StandardNormal))
            .collect()
    }

    #[test]
    fn a_clean_signal_stays() {
        for noise in [0.0, 0.001, 0.05, 0.2] {
            let values = signal(noise);
            let cleaned = clean(&values);
            assert_eq!((cleaned.spikes, cleaned.clipped_count()), (0, 0), "{noise}");
            assert_eq!(cleaned.values, values);
        }
        // Steps are no spikes, and a constant has neither spikes nor a range.
        let steps: Vec<f64> = (0..400)
            .map(|k| f64::from(k / 20 % 2) + 0.01 * f64::from(k % 7))
            .collect();
        assert_eq!(clean(&steps).spikes, 0);
        assert_eq!(clean(&[3.0; 50]).clipped_count(), 0);
        // A turn of whole samples repeats its peaks exactly.
        let coarse: Vec<f64> = signal(0.0)
            .iter()
            .map(|v| (v * 50.0).round() / 50.0)
            .collect();
        assert_eq!(clean(&coarse).clipped_count(), 0);
    }

    #[test]
    fn spikes_are_left_out() {
        let mut values = signal(0.05);
        for place in [1, 100, 101, 102, 1500, 3998] {
            values[place] += 4.0;
        }
        values[700] = -5.0;
        values[800] = f64::NAN;
        let cleaned = clean(&values);
        assert_eq!(cleaned.spikes, 7);
        let missing = cleaned.values.iter().filter(|v| v.is_nan()).count();
        assert_eq!(missing, 8);
        assert!(cleaned.values[101].is_nan() && cleaned.values[700].is_nan());
    }

    /// The fastest of these tones has eight samples a turn: its peaks are far from the median around them.
    #[test]
    fn peaks_of_a_quick_signal_are_no_spikes() {
        for seed in 0..10 {
            let mut random = StdRng::seed_from_u64(seed);
            let tones: Vec<[f64; 2]> = (0..40)
                .map(|_| {
                    [
                        random.random_range(0.5..30.0),
                        random.random_range(0.0..TAU),
                    ]
                })
                .collect();
            let at = |k: u32| {
                let time = f64::from(k) / 250.0;
                tones
                    .iter()
                    .map(|[frequency, phase]| (TAU * frequency * time + phase).sin())
                    .sum::<f64>()
            };
            let mut values: Vec<f64> = (0..3000).map(at).collect();
            assert_eq!(clean(&values).spikes, 0, "seed {seed}");
            for place in [500, 1200, 1201, 2500] {
                values[place] += 60.0;
            }
            let cleaned = clean(&values);
            assert_eq!(cleaned.spikes, 4, "seed {seed}");
            assert!(cleaned.values[1201].is_nan());
        }
    }

    #[test]
    fn a_run_of_marks_is_no_part_of_the_signal() {
        let mut values = signal(0.05);
        values[2000..2040].fill(-9999.0);
        let cleaned = clean(&values);
        assert_eq!(
            (cleaned.marks, cleaned.spikes, cleaned.clipped_count()),
            (40, 0, 0)
        );
        assert!(cleaned.values[2020].is_nan());
        // What rests for long is a level of its own.
        values[2000..2900].fill(-9999.0);
        assert_eq!(clean(&values).marks, 0);
    }

    #[test]
    fn clipped_samples_are_known_at_either_end() {
        for sign in [1.0, -1.0] {
            let values: Vec<f64> = signal(0.05).iter().map(|v| sign * v.min(1.45)).collect();
            let cleaned = clean(&values);
            let expected = values.iter().filter(|&&v| v == sign * 1.45).count();
            assert!(expected > 400);
            assert_eq!((cleaned.clipped_count(), cleaned.spikes), (expected, 0));
        }
    }
}
