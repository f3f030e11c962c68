//! Where a sample lies: its interval, less the gaps in which there is nothing of it.

use super::super::posterior::interval;

/// A gap is wider than so many spacings on both sides of it: among 10,000 random spacings one in 300 samples has such a
/// one by chance.
const GAP: f64 = 15.0;

/// Spacings on each side that a gap is compared with.
const NEAR: usize = 16;

/// A gap has at least so many different values on each side.
const LEAST: usize = 8;

/// Narrower gaps than this part of the interval are not worth two intervals.
const WORTH: f64 = 0.05;

/// The value below which a part of a sorted sample lies: a further value of the same kind lies below it with just this
/// probability.
pub fn quantile(sorted: &[f64], part: f64) -> f64 {
    let Some(last) = sorted.len().checked_sub(1) else { return f64::NAN };
    let place = (part * (sorted.len() + 1) as f64 - 1.0).clamp(0.0, last as f64);
    let below = place.floor() as usize;
    let above = (below + 1).min(last);
    sorted[below] + (place - below as f64) * (sorted[above] - sorted[below])
}

/// The intervals that hold 95 % of a sorted sample between bounds: its [`interval`] without the gaps between modes.
pub fn regions(sorted: &[f64], bounds: [f64; 2]) -> Vec<[f64; 2]> {
    let [low, high] = interval(bounds, |part| quantile(sorted, part));
    let mut values = sorted.to_vec();
    values.dedup();
    let mut regions = Vec::new();
    let mut start = low;
    for k in 1..values.len() {
        let (left, right) = (values[k - 1], values[k]);
        if left < low || right > high || k < LEAST || values.len() - k < LEAST {
            continue;
        }
        let before = k.min(NEAR) - 1;
        let after = (values.len() - k).min(NEAR) - 1;
        let behind = (left - values[k - 1 - before]) / before as f64;
        let ahead = (values[k + after] - right) / after as f64;
        let width = right - left;
        if width > GAP * behind.max(ahead) && width > WORTH * (high - low) {
            regions.push([start, left + behind]);
            start = right - ahead;
        }
    }
    regions.push([start, high]);
    regions
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::rngs::StdRng;
    use rand::{RngExt, SeedableRng};
    use rand_distr::StandardNormal;
    use statrs::distribution::{ContinuousCDF, Normal};

    const ANY: [f64; 2] = [f64::NEG_INFINITY, f64::INFINITY];

    /// Of an exponential sample, most probable at 0, the interval holds the bound: its end is the 95 % quantile, ln 20.
    #[test]
    fn a_sample_at_a_bound_has_a_one_sided_interval() {
        let even = (0..4000).map(|k| -((f64::from(k) + 0.5) / 4000.0).ln());
        let mut values: Vec<f64> = even.collect();
        values.sort_by(f64::total_cmp);
        let [[low, high]] = regions(&values, [0.0, 50.0])[..] else {
            panic!("one interval");
        };
        assert!(low == 0.0 && (high - 20.0_f64.ln()).abs() < 0.01, "{low} .. {high}");
        // Nothing but the bounds is known: the middle 95 % of them.
        let even: Vec<f64> = (0..4000).map(|k| (f64::from(k) + 0.5) / 4000.0).collect();
        let [[low, high]] = regions(&even, [0.0, 1.0])[..] else {
            panic!("one interval");
        };
        assert!((low - 0.025).abs() < 1e-3 && (high - 0.975).abs() < 1e-3, "{low} .. {high}");
    }

    /// The density of a lognormal number vanishes at 0: its interval does not begin there, though that would be shorter.
    #[test]
    fn a_skewed_sample_that_keeps_off_a_bound_has_two_ends() {
        let normal = Normal::standard();
        let at = |part: f64| (0.8 * normal.inverse_cdf(part)).exp();
        let values: Vec<f64> = (0..4000).map(|k| at((f64::from(k) + 0.5) / 4000.0)).collect();
        let [[low, high]] = regions(&values, [0.0, f64::INFINITY])[..] else {
            panic!("one interval");
        };
        assert!(at(0.95) < 0.97 * (at(0.975) - at(0.025)));
        let expected = [at(0.025), at(0.975)];
        assert!(
            (low - expected[0]).abs() < 0.01 && (high - expected[1]).abs() < 0.2,
            "{low} .. {high}, not {expected:?}"
        );
    }

    #[test]
    fn one_mode_has_one_interval_that_holds_as_much_as_it_says() {
        let mut random = StdRng::seed_from_u64(4);
        let (mut held, mut parts) = (0.0, 0);
        for _ in 0..200 {
            let mut values: Vec<f64> = (0..400).map(|_| random.sample(StandardNormal)).collect();
            values.sort_by(f64::total_cmp);
            let regions = regions(&values, ANY);
            parts += regions.len();
            let fresh = (0..500).map(|_| random.sample::<f64, _>(StandardNormal));
            let inside = |x: &f64| regions.iter().any(|[a, b]| (a..=b).contains(&x));
            held += fresh.filter(inside).count() as f64;
        }
        // Each interval's own content scatters by 1.1 %, so the mean over 200 by 0.1 %.
        assert!((held / 100_000.0 - 0.95).abs() < 0.004, "{held}");
        assert_eq!(parts, 200);
    }

    #[test]
    fn modes_apart_have_an_interval_each_and_hold_as_much() {
        let mut random = StdRng::seed_from_u64(5);
        let mut held = 0.0;
        let draw = |random: &mut StdRng| {
            let mode = if random.random::<f64>() < 0.2 { 3.0 } else { 0.0 };
            mode + 0.1 * random.sample::<f64, _>(StandardNormal)
        };
        for _ in 0..200 {
            let mut values: Vec<f64> = (0..400).map(|_| draw(&mut random)).collect();
            values.sort_by(f64::total_cmp);
            let regions = regions(&values, ANY);
            assert_eq!(regions.len(), 2, "{regions:?}");
            let fresh = (0..500).map(|_| draw(&mut random));
            let inside = |x: &f64| regions.iter().any(|[a, b]| (a..=b).contains(&x));
            held += fresh.filter(inside).count() as f64;
        }
        assert!((held / 100_000.0 - 0.95).abs() < 0.006, "{held}");
    }
}
