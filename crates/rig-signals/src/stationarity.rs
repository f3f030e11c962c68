//! Is a window steady? Trend and wander of the means of blocks.
//!
//! Samples of a fast record depend on each other; means of blocks (whole turns, where the turn is
//! known) hardly do. All tests work on them.

use sampling::statistics::{
    estimate::Estimate,
    moments::{mean, variance},
};
use serde::Serialize;
use statrs::distribution::{ContinuousCDF, Normal, StudentsT};

/// Result of the stationarity tests on a window.
#[derive(Debug, PartialEq, Serialize)]
pub struct Stationarity {
    /// The change over the window by the straight line through the block means, with its interval,
    /// in the signal's unit.
    pub change: Estimate,
    /// Probability of a trend as strong in a steady signal.
    pub trend_chance: f64,
    /// Probability that neighbouring block means of a steady signal lie as close together, against
    /// their scatter about the line: von Neumann (1941), "Distribution of the ratio of the mean
    /// square successive difference to the variance", Ann. Math. Stat. 12.
    pub wander_chance: f64,
    /// Whether the line's slope differs from 0 at the confidence asked for.
    pub trend: bool,
    /// Whether the signal wanders about the line, at the confidence asked for.
    pub drift: bool,
    /// Lag-1 correlation of the block means; the interval of the change allows for it.
    pub memory: f64,
    /// The number of blocks.
    pub blocks: usize,
}

impl Stationarity {
    /// Neither trend nor drift.
    pub fn steady(&self) -> bool {
        !self.trend && !self.drift
    }

    /// A line of a file of TOML about it, with the word for a signal that is not steady.
    pub fn comment(&self, otherwise: &str, unit: &str) -> String {
        let (word, change) = (if self.steady() { "steady" } else { otherwise }, self.change);
        format!(
            "# {word}: change over the window {:.2e} ({:.2e} to {:.2e}) {unit}",
            change.value, change.low, change.high
        )
    }
}

/// Means of equal blocks of `length` samples; a rest at the end is left out.
pub fn block_means(values: &[f64], length: usize) -> Vec<f64> {
    values.chunks_exact(length.max(1)).map(mean).collect()
}

/// Tests the means of blocks at a confidence such as 0.99. `None` for fewer than eight blocks.
pub fn test(blocks: &[f64], confidence: f64) -> Option<Stationarity> {
    const LEAST: usize = 8;
    if blocks.len() < LEAST {
        return None;
    }
    let n = blocks.len() as f64;
    let centre = mean(blocks);
    let places = (0..blocks.len()).map(|k| k as f64 - (n - 1.0) / 2.0);
    let pairs = || places.clone().zip(blocks);
    let spread: f64 = places.clone().map(|p| p * p).sum();
    let slope = pairs().map(|(p, v)| p * (v - centre)).sum::<f64>() / spread;
    let rest: Vec<f64> = pairs().map(|(p, v)| v - centre - slope * p).collect();
    let squares: f64 = rest.iter().map(|r| r * r).sum();
    let memory = correlation(&rest, squares);
    // Dependent blocks count less: Bartlett (1935), n (1 - r) / (1 + r).
    let effective = (n * (1.0 - memory) / (1.0 + memory)).clamp(4.0, n);
    let error = (squares / (effective - 2.0) / spread * (n / effective)).sqrt();
    let student = StudentsT::new(0.0, 1.0, effective - 2.0).ok()?;
    let chance = if error > 0.0 { 2.0 * student.sf((slope / error).abs()) } else { f64::from(slope == 0.0) };
    let width = student.inverse_cdf(0.5 + confidence / 2.0) * error;
    let wander_chance = von_neumann(&rest, squares);
    Some(Stationarity {
        change: Estimate::around(slope * (n - 1.0), width * (n - 1.0)),
        trend_chance: chance,
        wander_chance,
        trend: chance < 1.0 - confidence,
        drift: wander_chance < 1.0 - confidence,
        memory,
        blocks: blocks.len(),
    })
}

fn correlation(rest: &[f64], squares: f64) -> f64 {
    if squares > 0.0 { (rest.windows(2).map(|w| w[0] * w[1]).sum::<f64>() / squares).clamp(0.0, 0.9) } else { 0.0 }
}

/// The chance of a ratio of mean square successive difference to variance as small as this: about
/// normal around 2 n/(n-1), with variance 4 (n-2)/(n^2-1) (n/(n-1))^2.
fn von_neumann(rest: &[f64], squares: f64) -> f64 {
    if squares <= 0.0 {
        return 1.0;
    }
    let n = rest.len() as f64;
    let differences: f64 = rest.windows(2).map(|w| (w[1] - w[0]).powi(2)).sum();
    let ratio = differences / squares;
    let deviation = (4.0 * (n - 2.0) / (n * n - 1.0)).sqrt();
    Normal::standard().cdf((ratio - 2.0) / deviation)
}

/// Standard uncertainty of the mean of a record from its block means, allowing for their memory.
pub fn uncertainty_of_mean(blocks: &[f64]) -> f64 {
    let n = blocks.len() as f64;
    if blocks.len() < 2 {
        return f64::NAN;
    }
    let centre = mean(blocks);
    let rest: Vec<f64> = blocks.iter().map(|v| v - centre).collect();
    let memory = correlation(&rest, rest.iter().map(|r| r * r).sum());
    (variance(blocks, 1) / (n * (1.0 - memory) / (1.0 + memory)).max(1.0)).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng, rngs::StdRng};
    use rand_distr::StandardNormal;

    fn noise(n: usize, seed: u64) -> Vec<f64> {
        let mut random = StdRng::seed_from_u64(seed);
        (0..n).map(|_| random.sample(StandardNormal)).collect()
    }

    #[test]
    fn steady_signals_are_rarely_called_otherwise() {
        let alarms = (0..500).filter(|s| !test(&noise(60, *s), 0.99).unwrap().steady()).count();
        // 1 % for either test: 10 of 500 expected, 20 at most with probability 99.8 %.
        assert!(alarms <= 20, "{alarms}");
    }

    #[test]
    fn a_drifting_signal_is_called_drifting() {
        for seed in 0..50 {
            let mut values = noise(60, seed);
            values.iter_mut().enumerate().for_each(|(k, v)| *v += 0.08 * k as f64);
            let s = test(&values, 0.99).unwrap();
            assert!(s.trend && s.change.contains(0.08 * 59.0), "{s:?}");
        }
    }

    #[test]
    fn a_wandering_signal_without_trend_is_called_drifting() {
        let mut values = noise(80, 3);
        values.iter_mut().enumerate().for_each(|(k, v)| *v += if (20..60).contains(&k) { 4.0 } else { 0.0 });
        let s = test(&values, 0.99).unwrap();
        assert!(!s.trend && s.drift, "{s:?}");
    }

    #[test]
    fn constants_are_steady() {
        assert!(test(&[3.0; 20], 0.99).unwrap().steady());
        assert_eq!(test(&[3.0; 7], 0.99), None);
    }

    #[test]
    fn the_mean_of_independent_blocks_has_the_usual_uncertainty() {
        let values = noise(4000, 1);
        let u = uncertainty_of_mean(&block_means(&values, 40));
        assert!((u - 1.0 / 4000f64.sqrt()).abs() < 0.3 / 4000f64.sqrt(), "{u}");
    }
}
