//! The curves that a measured one may truly have been, by its uncertainty.

use crate::{notices::Replicates, task::Resampling};
use curves::{Metric, Pair};
use sampling::recording::RowErrors;

/// Draws of a measured curve's errors.
#[derive(Debug)]
pub struct Draws {
    resampling: Resampling,
    drawn: RowErrors,
    /// The errors of single rows in standard deviations, replicate by replicate; made when they are needed first.
    table: Option<Vec<f32>>,
}

impl Draws {
    pub fn new(resampling: &Resampling) -> Self {
        let rectangular = resampling.errors.as_ref().is_some_and(|errors| errors.rectangular);
        Self { drawn: RowErrors::new(resampling.seed, rectangular), resampling: resampling.clone(), table: None }
    }

    /// To which of the curves a model conforms; none where they are not known.
    pub fn conforming(&mut self, metric: Metric, pair: &Pair) -> Replicates {
        let rows = pair.reference.len();
        let known =
            self.resampling.errors.as_ref().filter(|errors| errors.shared.len() == rows && errors.own.len() == rows);
        let Some(errors) = known else { return Replicates::new() };
        if pair.model.iter().any(|value| !value.is_finite()) {
            return Replicates::new();
        }
        let has_own = errors.own.iter().any(|own| *own > 0.0);
        if !has_own && errors.gain == 0.0 && matches!(metric, Metric::Rmse | Metric::Nrmse) {
            return self.by_moments(&errors.shared, metric, pair);
        }
        if has_own && self.table.is_none() {
            self.table = Some(table(&self.drawn, self.resampling.first, rows));
        }
        let mut conforming = vec![0_u64; RowErrors::REPLICATES / 64];
        let mut truth = vec![0.0; rows];
        for replicate in 0..RowErrors::REPLICATES {
            let sign = self.resampling.sign;
            let common = sign * self.drawn.common(replicate);
            let gain = sign * errors.gain * self.drawn.gain(replicate);
            let known = pair.reference.iter().zip(&errors.shared);
            for (truth, (value, width)) in truth.iter_mut().zip(known) {
                *truth = value * (1.0 + gain) + width * common;
            }
            if let Some(table) = &self.table {
                let single = table[replicate * rows..].iter().zip(&errors.own);
                for (truth, (error, width)) in truth.iter_mut().zip(single) {
                    *truth += width * f64::from(*error);
                }
            }
            note(&self.resampling, replicate, metric.compare(&Pair { reference: &truth, ..*pair }), &mut conforming);
        }
        conforming
    }

    /// The same for an rmse where all rows share their error: the mean of (d - w z)^2 is a parabola in z.
    fn by_moments(&self, shared: &[f64], metric: Metric, pair: &Pair) -> Replicates {
        let rows = pair.reference.len() as f64;
        let known = pair.model.iter().zip(pair.reference);
        let [mut squares, mut mixed, mut widths] = [0.0; 3];
        for ((model, reference), width) in known.zip(shared) {
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
            let z = self.resampling.sign * self.drawn.common(replicate);
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
    use crate::task::CurveErrors;
    use conformity::normal::between;

    fn errors(correlation: f64) -> CurveErrors {
        CurveErrors {
            shared: vec![0.5 * correlation.sqrt(); 400],
            gain: 0.0,
            own: vec![0.5 * (1.0 - correlation).sqrt(); 400],
            coverage: [2.0; 2],
            rectangular: false,
        }
    }

    fn resampling(correlation: f64, tolerance: f64) -> Resampling {
        Resampling { errors: Some(errors(correlation)), sign: 1.0, seed: 3, first: 0, ideal: 0.0, tolerance }
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
                assert!((share - expected).abs() < 1.5 / 256.0, "{deviation}: {share} {expected}");
            }
        }
    }

    /// A rectangular offset: the part of the limits in which the model conforms. A gain of a constant curve is an offset, too.
    #[test]
    fn rectangles_and_gains_are_those_of_one_number() {
        let resampling = resampling(1.0, 1.0);
        let with = |errors: CurveErrors| Resampling { errors: Some(errors), ..resampling.clone() };
        let rectangular = with(CurveErrors { rectangular: true, ..errors(1.0) });
        // Limits of +-0.866 about a model that is 0.6 off, of which +-1 conforms.
        let expected = (0.5 * 3.0_f64.sqrt() + 0.4) / 3.0_f64.sqrt();
        let part = share(&rectangular, Metric::Rmse, 0.6);
        assert!((part - expected).abs() < 1.5 / 256.0, "{part} {expected}");
        let gain = with(CurveErrors { gain: 0.5, ..errors(0.0) });
        let gain = with(CurveErrors { own: vec![0.0; 400], ..gain.errors.unwrap() });
        let part = share(&gain, Metric::Rmse, 0.6);
        let expected = between(-1.6 / 0.5, 0.4 / 0.5);
        assert!((part - expected).abs() < 1.5 / 256.0, "{part} {expected}");
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
        let model: Vec<f64> = (0..400).map(|k| f64::from(k % 17) + 0.02 * f64::from(k % 5)).collect();
        let pair = Pair { normaliser: 16.0, ..Pair::new(&reference, &model) };
        for (metric, tolerance) in [(Metric::Rmse, 0.6), (Metric::Nrmse, 0.05)] {
            let of = |correlation: f64| Draws::new(&resampling(correlation, tolerance)).conforming(metric, &pair);
            let differing = of(1.0).into_iter().zip(of(1.0 - 1e-12)).map(|(a, b)| (a ^ b).count_ones());
            assert_eq!(differing.sum::<u32>(), 0, "{metric:?}");
            assert!(of(1.0).iter().any(|bits| *bits != 0 && *bits != u64::MAX));
        }
    }

    #[test]
    fn what_is_not_known_is_not_told() {
        let unknown = Resampling { errors: None, ..resampling(1.0, 1.0) };
        let pair = Pair::new(&[1.0, 2.0], &[1.0, 2.0]);
        assert!(Draws::new(&unknown).conforming(Metric::Rmse, &pair).is_empty());
    }
}
