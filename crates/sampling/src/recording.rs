//! Errors of a recording's rows, drawn again and again: what a measured curve may truly have been.

use crate::distribution::normal_quantile;
use crate::random::{Purpose, bits, pair};

/// Standard normal errors of a recording's rows. Those of any two rows have the same correlation: each is the sum of a part
/// that all rows share, such as an offset of the sensor, and a part of its own, such as noise.
///
/// An error depends on the seed, the replicate and the row alone. So two looks at the same recording, such as two criteria with
/// other windows, see the same errors.
#[derive(Clone, Debug)]
pub struct RowErrors {
    seed: u64,
    deviation: f64,
    /// The errors that all rows share, by replicate.
    common: Vec<f64>,
}

impl RowErrors {
    /// How many times the errors are drawn.
    pub const REPLICATES: usize = 256;

    /// Errors with a correlation from 0 to 1.
    ///
    /// The shared parts are the middles of slices of equal probability, in a random order: their distribution is that of the
    /// normal one as well as so many numbers can have it.
    pub fn new(seed: u64, correlation: f64) -> Self {
        let correlation = correlation.clamp(0.0, 1.0);
        let mut order: Vec<usize> = (0..Self::REPLICATES).collect();
        let place = |replicate: &usize| bits(seed, Purpose::Common, *replicate as u64, 0);
        order.sort_by_cached_key(place);
        let middle = |slice: usize| (slice as f64 + 0.5) / Self::REPLICATES as f64;
        let common = order
            .into_iter()
            .map(|slice| correlation.sqrt() * normal_quantile(middle(slice)));
        Self {
            seed,
            deviation: (1.0 - correlation).sqrt(),
            common: common.collect(),
        }
    }

    /// The part of a replicate's errors that all rows share.
    pub fn common(&self, replicate: usize) -> f64 {
        self.common[replicate]
    }

    /// Whether rows have errors of their own.
    pub fn has_own(&self) -> bool {
        self.deviation > 0.0
    }

    /// The parts of a replicate's errors that rows have of their own, from the row `first` on.
    pub fn own(&self, replicate: usize, first: u64, rows: usize) -> impl Iterator<Item = f64> + '_ {
        let last = first + rows as u64;
        let draw = move |number: u64| {
            let [u, v] = pair(self.seed, Purpose::Row, number, replicate as u32);
            // Box and Muller (1958), "A note on the generation of random normal deviates".
            let radius = self.deviation * (-2.0 * u.ln()).sqrt();
            let (sine, cosine) = (std::f64::consts::TAU * v).sin_cos();
            [
                (2 * number, radius * cosine),
                (2 * number + 1, radius * sine),
            ]
        };
        let drawn = (first / 2..last.div_ceil(2)).flat_map(draw);
        drawn
            .filter(move |(row, _)| (first..last).contains(row))
            .map(|(_, error)| error)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn errors(errors: &RowErrors, replicate: usize, first: u64, rows: usize) -> Vec<f64> {
        let common = errors.common(replicate);
        let parts = errors.own(replicate, first, rows);
        parts.map(|part| common + part).collect()
    }

    /// Variance 1, and the stated correlation between rows: over 256 replicates of 40 rows.
    #[test]
    fn rows_have_the_stated_correlation() {
        for correlation in [0.0, 0.3, 1.0] {
            let made = RowErrors::new(7, correlation);
            let (mut squares, mut products, mut sum) = (0.0, 0.0, 0.0);
            for replicate in 0..RowErrors::REPLICATES {
                let rows = errors(&made, replicate, 3, 40);
                sum += rows.iter().sum::<f64>() / 40.0;
                squares += rows.iter().map(|e| e * e).sum::<f64>() / 40.0;
                products += rows.windows(2).map(|w| w[0] * w[1]).sum::<f64>() / 39.0;
            }
            let [mean, variance, covariance] = [sum, squares, products].map(|sum| sum / 256.0);
            assert!(mean.abs() < 0.03, "{correlation}: {mean}");
            assert!((variance - 1.0).abs() < 0.06, "{correlation}: {variance}");
            assert!(
                (covariance - correlation).abs() < 0.06,
                "{correlation}: {covariance}"
            );
        }
    }

    #[test]
    fn the_shared_part_has_the_normal_distribution() {
        let made = RowErrors::new(1, 1.0);
        assert!(!made.has_own());
        let below = |z: f64| (0..256).filter(|&k| made.common(k) < z).count();
        // 256 Phi(z) by tables of the normal distribution.
        assert_eq!([below(0.0), below(1.0), below(-2.0)], [128, 215, 6]);
        let other = RowErrors::new(2, 1.0);
        assert!((0..256).any(|k| other.common(k) != made.common(k)));
    }

    #[test]
    fn a_row_has_its_error_wherever_the_look_begins() {
        let made = RowErrors::new(7, 0.5);
        let all = errors(&made, 9, 0, 50);
        for (first, rows) in [(0, 7), (1, 7), (12, 1), (13, 1), (20, 30)] {
            let part = errors(&made, 9, first as u64, rows);
            assert_eq!(part, all[first..first + rows]);
        }
        assert_ne!(all, errors(&made, 10, 0, 50));
    }
}
