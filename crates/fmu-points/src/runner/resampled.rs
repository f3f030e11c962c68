//! The curves that a measured one may truly have been, by its uncertainty.

use crate::notices::Replicates;
use crate::task::Resampling;
use curves::{Metric, Pair};
use sampling::recording::RowErrors;

/// Draws of a measured curve's errors.
#[derive(Clone, Debug)]
pub(super) struct Draws {
    resampling: Resampling,
    errors: RowErrors,
    /// The errors of single rows in standard deviations, replicate by replicate; made when they are needed first.
    table: Option<Vec<f32>>,
}

impl Draws {
    pub(super) fn new(resampling: &Resampling) -> Self {
        Self {
            errors: RowErrors::new(resampling.seed, resampling.correlation),
            resampling: resampling.clone(),
            table: None,
        }
    }

    /// To which of the curves a model conforms; none where they are not known.
    pub(super) fn conforming(&mut self, metric: Metric, pair: &Pair<'_>) -> Replicates {
        let standard = &self.resampling.standard;
        let rows = pair.reference.len();
        if standard.len() != rows || pair.model.iter().any(|value| !value.is_finite()) {
            return Replicates::new();
        }
        if !self.errors.has_own() && matches!(metric, Metric::Rmse | Metric::Nrmse) {
            return self.by_moments(metric, pair);
        }
        let table = self.errors.has_own().then(|| {
            &**self
                .table
                .get_or_insert_with(|| table(&self.errors, self.resampling.first, rows))
        });
        let mut conforming = vec![0_u64; RowErrors::REPLICATES / 64];
        let mut truth = vec![0.0; rows];
        for replicate in 0..RowErrors::REPLICATES {
            let common = self.errors.common(replicate);
            let known = pair.reference.iter().zip(standard);
            match table {
                None => truth
                    .iter_mut()
                    .zip(known)
                    .for_each(|(truth, (value, width))| *truth = value + width * common),
                Some(table) => truth
                    .iter_mut()
                    .zip(known)
                    .zip(&table[replicate * rows..])
                    .for_each(|((truth, (value, width)), error)| {
                        *truth = value + width * (common + f64::from(*error));
                    }),
            }
            let value = metric.compare(&Pair {
                reference: &truth,
                ..*pair
            });
            note(&self.resampling, replicate, value, &mut conforming);
        }
        conforming
    }

    /// The same for an rmse where all rows share their error: the mean of (d - w z)^2 is a parabola in z.
    fn by_moments(&self, metric: Metric, pair: &Pair<'_>) -> Replicates {
        let rows = pair.reference.len() as f64;
        let known = pair.model.iter().zip(pair.reference);
        let [mut squares, mut mixed, mut widths] = [0.0; 3];
        for ((model, reference), width) in known.zip(&self.resampling.standard) {
            let deviation = model - reference;
            squares += deviation * deviation;
            mixed += deviation * width;
            widths += width * width;
        }
        let normaliser = match metric {
            Metric::Nrmse => pair.normaliser,
            _ => 1.0,
        };
        let mut conforming = vec![0_u64; RowErrors::REPLICATES / 64];
        for replicate in 0..RowErrors::REPLICATES {
            let z = self.errors.common(replicate);
            let mean = (squares - 2.0 * z * mixed + z * z * widths) / rows;
            // Rounding may leave less than nothing.
            let value = mean.max(0.0).sqrt() / normaliser;
            note(&self.resampling, replicate, value, &mut conforming);
        }
        conforming
    }
}

/// Notes whether a draw's value is within the limit.
fn note(resampling: &Resampling, replicate: usize, value: f64, conforming: &mut Replicates) {
    let conforms = (value - resampling.ideal).abs() <= resampling.tolerance;
    conforming[replicate / 64] |= u64::from(conforms) << (replicate % 64);
}

/// The errors of single rows, by replicate. Half the precision is plenty for them, and half the memory.
fn table(errors: &RowErrors, first: u64, rows: usize) -> Vec<f32> {
    let mut table = Vec::with_capacity(RowErrors::REPLICATES * rows);
    for replicate in 0..RowErrors::REPLICATES {
        table.extend(errors.own(replicate, first, rows).map(|error| error as f32));
    }
    table
}

#[cfg(test)]
mod tests {
    use super::*;
    use conformity::normal::between;

    fn resampling(correlation: f64, tolerance: f64) -> Resampling {
        Resampling {
            standard: vec![0.5; 400],
            correlation,
            seed: 3,
            first: 0,
            ideal: 0.0,
            tolerance,
        }
    }

    fn share(resampling: &Resampling, metric: Metric, deviation: f64) -> f64 {
        let reference = vec![1.0; 400];
        let model = vec![1.0 + deviation; 400];
        let conforming = Draws::new(resampling).conforming(metric, &Pair::new(&reference, &model));
        f64::from(conforming.iter().map(|bits| bits.count_ones()).sum::<u32>()) / 256.0
    }

    /// A model that is off by a constant, under an error that all rows share, is the one number of JCGM 106:2012, 7.4:
    /// p_c = Phi((T - d) / u) - Phi((-T - d) / u).
    #[test]
    fn a_shared_error_is_that_of_one_number() {
        for metric in [Metric::Rmse, Metric::MaxError, Metric::Area] {
            for deviation in [0.0, 0.4, 1.0, 1.5, -1.0] {
                let expected = between((-1.0 - deviation) / 0.5, (1.0 - deviation) / 0.5);
                let share = share(&resampling(1.0, 1.0), metric, deviation);
                // Whole draws of 256 only.
                assert!(
                    (share - expected).abs() < 1.5 / 256.0,
                    "{deviation}: {share} {expected}"
                );
            }
        }
    }

    /// Independent errors of 400 rows leave an rmse of sqrt(d^2 + u^2), give or take a few hundredths.
    #[test]
    fn independent_errors_add_their_variance() {
        let rmse = 0.3_f64.hypot(0.5);
        let near = |tolerance: f64| share(&resampling(0.0, tolerance), Metric::Rmse, 0.3);
        assert_eq!([near(0.9 * rmse), near(1.1 * rmse)], [0.0, 1.0]);
        assert!((near(rmse) - 0.5).abs() < 0.1, "{}", near(rmse));
        // The largest of 400 errors is below x with probability (2 Phi(x) - 1)^400.
        let expected = between(-3.0, 3.0).powi(400);
        let share = share(&resampling(0.0, 1.5), Metric::MaxError, 0.0);
        assert!((share - expected).abs() < 0.1, "{share} {expected}");
    }

    /// The parabola against the metric itself: a hair of correlation less takes the other way.
    #[test]
    fn both_ways_to_an_rmse_agree() {
        let reference: Vec<f64> = (0..400).map(|k| f64::from(k % 17)).collect();
        let model: Vec<f64> = (0..400)
            .map(|k| f64::from(k % 17) + 0.02 * f64::from(k % 5))
            .collect();
        let pair = Pair {
            normaliser: 16.0,
            ..Pair::new(&reference, &model)
        };
        for (metric, tolerance) in [(Metric::Rmse, 0.6), (Metric::Nrmse, 0.05)] {
            let of = |correlation: f64| {
                Draws::new(&resampling(correlation, tolerance)).conforming(metric, &pair)
            };
            let differing = of(1.0)
                .into_iter()
                .zip(of(1.0 - 1e-12))
                .map(|(a, b)| (a ^ b).count_ones());
            assert_eq!(differing.sum::<u32>(), 0, "{metric:?}");
            assert!(of(1.0).iter().any(|bits| *bits != 0 && *bits != u64::MAX));
        }
    }

    #[test]
    fn what_is_not_known_is_not_told() {
        let unknown = Resampling {
            standard: Vec::new(),
            ..resampling(1.0, 1.0)
        };
        let pair = Pair::new(&[1.0, 2.0], &[1.0, 2.0]);
        assert!(
            Draws::new(&unknown)
                .conforming(Metric::Rmse, &pair)
                .is_empty()
        );
    }
}
