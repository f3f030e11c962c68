//! Errors of a recording's rows, drawn again and again: what a measured curve may truly have been.

use crate::{
    distribution::normal_quantile,
    random::{Purpose, bits, pair},
};

/// Standard errors of a recording's rows, by parts: one that all rows share, such as an offset of the sensor, another one that
/// they share, such as its gain, and a part of each row's own, such as noise.
///
/// An error depends on the seed, the replicate and the row alone. So two looks at the same recording, such as two criteria with
/// other windows, see the same errors.
#[derive(Clone, Debug)]
pub struct RowErrors {
    seed: u64,
    /// The errors that all rows share, by replicate.
    common: Vec<f64>,
    gain: Vec<f64>,
}

impl RowErrors {
    /// How many times the errors are drawn.
    pub const REPLICATES: usize = 256;

    /// Errors of which the first shared part is normal, or as probable everywhere between limits.
    ///
    /// The shared parts are the middles of slices of equal probability, in a random order: their distribution is that of the
    /// stated one as well as so many numbers can have it.
    pub fn new(seed: u64, rectangular: bool) -> Self {
        let sliced = |part: u32, quantile: fn(f64) -> f64| {
            let mut order: Vec<usize> = (0..Self::REPLICATES).collect();
            order.sort_by_cached_key(|replicate| bits(seed, Purpose::Common, *replicate as u64, part));
            let middle = |slice: usize| (slice as f64 + 0.5) / Self::REPLICATES as f64;
            order.into_iter().map(|slice| quantile(middle(slice))).collect()
        };
        let even = |place: f64| 3.0_f64.sqrt() * (2.0 * place - 1.0);
        Self {
            seed,
            common: sliced(0, if rectangular { even } else { normal_quantile }),
            gain: sliced(1, normal_quantile),
        }
    }

    /// The part of a replicate's errors that all rows share.
    pub fn common(&self, replicate: usize) -> f64 {
        self.common[replicate]
    }

    /// The other part that they share.
    pub fn gain(&self, replicate: usize) -> f64 {
        self.gain[replicate]
    }

    /// The parts of a replicate's errors that rows have of their own, from the row `first` on.
    pub fn own(&self, replicate: usize, first: u64, rows: usize) -> impl Iterator<Item = f64> + '_ {
        let last = first + rows as u64;
        let draw = move |number: u64| {
            let [u, v] = pair(self.seed, Purpose::Row, number, replicate as u32);
            // Box and Muller (1958), "A note on the generation of random normal deviates".
            let radius = (-2.0 * u.ln()).sqrt();
            let (sine, cosine) = (std::f64::consts::TAU * v).sin_cos();
            [(2 * number, radius * cosine), (2 * number + 1, radius * sine)]
        };
        (first / 2..last.div_ceil(2))
            .flat_map(draw)
            .filter(move |(row, _)| (first..last).contains(row))
            .map(|(_, error)| error)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn errors(errors: &RowErrors, replicate: usize, first: u64, rows: usize) -> Vec<f64> {
        errors.own(replicate, first, rows).collect()
    }

    /// Variance 1, and no correlation between rows, or with what they share: over 256 replicates of 40 rows.
    #[test]
    fn parts_are_standard_and_independent() {
        let made = RowErrors::new(7, false);
        let (mut squares, mut products, mut mixed, mut shared) = (0.0, 0.0, 0.0, 0.0);
        for replicate in 0..RowErrors::REPLICATES {
            let rows = errors(&made, replicate, 3, 40);
            squares += rows.iter().map(|e| e * e).sum::<f64>() / 40.0 / 256.0;
            products += rows.windows(2).map(|w| w[0] * w[1]).sum::<f64>() / 39.0 / 256.0;
            mixed += rows[0] * made.common(replicate) / 256.0;
            shared += made.gain(replicate) * made.common(replicate) / 256.0;
        }
        assert!((squares - 1.0).abs() < 0.06, "{squares}");
        assert!(products.abs() < 0.03 && mixed.abs() < 0.2 && shared.abs() < 0.2, "{products} {mixed} {shared}");
    }

    #[test]
    fn the_shared_part_has_the_stated_distribution() {
        let made = RowErrors::new(1, false);
        let below = |z: f64| (0..256).filter(|&k| made.common(k) < z).count();
        // 256 Phi(z) by tables of the normal distribution.
        assert_eq!([below(0.0), below(1.0), below(-2.0)], [128, 215, 6]);
        let even = RowErrors::new(1, true);
        let square = (0..256).map(|k| even.common(k).powi(2)).sum::<f64>() / 256.0;
        let most = (0..256).map(|k| even.common(k)).fold(0.0, f64::max);
        assert!((square - 1.0).abs() < 1e-4 && (most - 3.0_f64.sqrt()).abs() < 0.01, "{square} {most}");
        let other = RowErrors::new(2, false);
        assert!((0..256).any(|k| other.common(k) != made.common(k)));
    }

    #[test]
    fn a_row_has_its_error_wherever_the_look_begins() {
        let made = RowErrors::new(7, false);
        let all = errors(&made, 9, 0, 50);
        for (first, rows) in [(0, 7), (1, 7), (12, 1), (13, 1), (20, 30)] {
            let part = errors(&made, 9, first as u64, rows);
            assert_eq!(part, all[first..first + rows]);
        }
        assert_ne!(all, errors(&made, 10, 0, 50));
    }
}
