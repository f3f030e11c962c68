//! How far a model is from the truth by itself, where that is unknown.
//!
//! A measured value differs from the prediction by the error of the measurement and by that of the model (Kennedy &
//! O'Hagan 2001, Bayesian calibration of computer models, J. Royal Statistical Society B 63, 425-464). Here the model's
//! error is an independent normal number for each case and quantity, with one unknown standard deviation a quantity. Its
//! prior is half-Cauchy at the scale of the measurement's accuracy: half of it lies below that scale, and it hardly
//! resists where the data show a much larger one (Gelman 2006, Prior distributions for variance parameters in
//! hierarchical models, Bayesian Analysis 1, 515-534).

use serde::Serialize;

use super::errors::Errors;
use super::problem::Problem;

/// A quantity whose discrepancy is unknown.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Unknown {
    /// The quantity's number.
    pub quantity: usize,
    /// The scale of the prior: the root mean square of the accuracies.
    pub scale: f64,
}

impl Unknown {
    /// The discrepancy of one of the quantities.
    pub fn of(problem: &Problem, quantity: usize) -> Self {
        let cases = problem.cases.iter();
        let squares = cases.map(|case| case.measured[quantity].accuracy.powi(2));
        let mean = squares.sum::<f64>() / problem.cases.len().max(1) as f64;
        Self { quantity, scale: mean.sqrt() }
    }

    /// The standard deviation at a place: the prior probability, from 0 to 1, of a smaller one.
    pub fn deviation(&self, place: f64) -> f64 {
        self.scale * (std::f64::consts::FRAC_PI_2 * place).tan()
    }

    /// The place of a standard deviation.
    pub fn place(&self, deviation: f64) -> f64 {
        (deviation / self.scale).atan() / std::f64::consts::FRAC_PI_2
    }
}

/// An estimate of a model discrepancy.
#[derive(Clone, Debug, Serialize)]
pub struct Discrepancy {
    /// The quantity.
    pub quantity: String,
    /// The unit of its numbers.
    pub unit: Option<String>,
    /// The most probable standard deviation; the search and the intervals around the optima take it as known.
    pub deviation: f64,
    /// Whether the data tell it from the accuracy of the measurement.
    pub told: bool,
    /// The scale of its prior: the accuracy of the measurement.
    pub scale: f64,
    /// Whether the last search left it as it took it; if not, more searches would change it, the optima and the intervals.
    pub settled: bool,
    /// From the sample of the posterior: the median, and the interval that holds it with 95 % probability.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sampled: Option<(f64, [f64; 2])>,
}

/// How much the logarithm of the likelihood must gain for a discrepancy to be told from none: that of the 95 % quantile of
/// a parameter at its bound, half of which is 0 and half chi-squared (Self & Liang 1987, J. American Statistical
/// Association 82, 605-610).
const GAIN: f64 = 1.353;

/// Places at which the likelihood is compared.
const PLACES: u32 = 2000;

impl Discrepancy {
    /// The most probable discrepancy of a quantity, given the predictions of a fit with so many unknowns; those of other
    /// quantities are known in the problem. A fit follows its data, so the squares of its misfits are too small; they count
    /// as so many degrees of freedom as they have.
    pub fn estimate(unknown: &Unknown, problem: &Problem, predicted: &[Vec<f64>], fitted: usize) -> Self {
        let values = problem.values();
        let factor = match values.checked_sub(fitted) {
            Some(left) if left > 0 => values as f64 / left as f64,
            _ => 1.0,
        };
        let at = |deviation: f64| {
            let errors = Errors::with(problem, |_, quantity| match quantity == unknown.quantity {
                true => deviation,
                false => 0.0,
            });
            errors.log_density(factor * errors.residuals(problem, predicted).norm_squared())
        };
        // The most probable variance is no larger than the largest square. Steps are even below the accuracy and grow in
        // proportion above it, so that a model that misses by thousands of accuracies is found, too.
        let pairs = problem.cases.iter().zip(predicted);
        let misfits =
            pairs.map(|(case, predicted)| (predicted[unknown.quantity] - case.measured[unknown.quantity].value).abs());
        let largest = misfits.fold(0.0, f64::max) * factor.sqrt();
        let reach = (largest / unknown.scale).asinh();
        let steps = (0..=PLACES).map(|k| f64::from(k) / f64::from(PLACES));
        let deviations = steps.map(|step| unknown.scale * (reach * step).sinh());
        let best = deviations.map(|deviation| (at(deviation), deviation));
        let greater = |a: (f64, f64), b: (f64, f64)| if b.0 > a.0 { b } else { a };
        let best = best.fold((f64::NEG_INFINITY, 0.0), greater);
        let quantity = &problem.quantities[unknown.quantity];
        Self {
            quantity: quantity.name.clone(),
            unit: quantity.unit.clone(),
            deviation: best.1,
            told: best.0 - at(0.0) > GAIN,
            scale: unknown.scale,
            settled: false,
            sampled: None,
        }
    }
}

/// The problem with discrepancies added to its accuracies.
pub fn widened(problem: &Problem, unknown: &[Unknown], deviations: &[f64]) -> Problem {
    problem.widened(|_, quantity| of_quantity(unknown, deviations, quantity))
}

/// The discrepancy of a quantity: 0 where none is unknown.
pub(crate) fn of_quantity(unknown: &[Unknown], deviations: &[f64], quantity: usize) -> f64 {
    let mut pairs = unknown.iter().zip(deviations);
    let pair = pairs.find(|(unknown, _)| unknown.quantity == quantity);
    pair.map_or(0.0, |(_, deviation)| *deviation)
}

#[cfg(test)]
mod tests {
    use super::super::testing::{self, measured};
    use super::*;
    use rand::rngs::StdRng;
    use rand::{RngExt, SeedableRng};
    use rand_distr::StandardNormal;

    fn problem(misfits: &[f64], accuracy: f64) -> (Problem, Vec<Vec<f64>>) {
        let cases = misfits.iter().map(|&value| measured(&[value], accuracy));
        let problem = testing::problem(Vec::new(), cases.collect());
        (problem, vec![vec![0.0]; misfits.len()])
    }

    #[test]
    fn a_place_and_its_deviation_belong_together() {
        let unknown = Unknown { quantity: 0, scale: 0.2 };
        assert_eq!(unknown.deviation(0.0), 0.0);
        assert!((unknown.deviation(0.5) - 0.2).abs() < 1e-12);
        assert!((unknown.place(unknown.deviation(0.83)) - 0.83).abs() < 1e-12);
    }

    /// With equal accuracies the likelihood is greatest where accuracy and discrepancy together explain the mean square.
    #[test]
    fn the_most_probable_discrepancy_is_the_excess_of_the_mean_square() {
        let misfits = [0.5, -0.7, 0.2, 0.9, -0.4, -0.6, 0.1, 0.8];
        let (problem, predicted) = problem(&misfits, 0.3);
        let unknown = Unknown::of(&problem, 0);
        assert!((unknown.scale - 0.3).abs() < 1e-12);
        let mean = misfits.iter().map(|m| m * m).sum::<f64>() / 8.0;
        let discrepancy = Discrepancy::estimate(&unknown, &problem, &predicted, 0);
        assert!((discrepancy.deviation - (mean - 0.09).sqrt()).abs() < 2e-3, "{discrepancy:?}");
        assert!(discrepancy.told);
        // With two fitted unknowns the same misfits count for six values.
        let fitted = Discrepancy::estimate(&unknown, &problem, &predicted, 2);
        assert!((fitted.deviation - (mean * 8.0 / 6.0 - 0.09).sqrt()).abs() < 2e-3);
        let wide = widened(&problem, &[unknown], &[0.4]);
        assert!((wide.cases[3].measured[0].accuracy - 0.5).abs() < 1e-12);
    }

    /// A model may miss by any number of accuracies: nothing caps the discrepancy.
    #[test]
    fn a_discrepancy_of_many_accuracies_is_found() {
        let misfits = [0.5, -0.7, 0.2, 0.9, -0.4, -0.6, 0.1, 0.8];
        let mean = misfits.iter().map(|m| m * m).sum::<f64>() / 8.0;
        for accuracy in [1e-2, 1e-4, 1e-6] {
            let (problem, predicted) = problem(&misfits, accuracy);
            let unknown = Unknown::of(&problem, 0);
            let discrepancy = Discrepancy::estimate(&unknown, &problem, &predicted, 0);
            let ratio = discrepancy.deviation / mean.sqrt();
            assert!((ratio - 1.0).abs() < 0.01, "{accuracy}: {discrepancy:?}");
            assert!(discrepancy.told);
        }
        let (problem, predicted) = problem(&[0.0; 4], 0.1);
        let unknown = Unknown::of(&problem, 0);
        let discrepancy = Discrepancy::estimate(&unknown, &problem, &predicted, 0);
        assert_eq!((discrepancy.deviation, discrepancy.told), (0.0, false));
    }

    /// Without a discrepancy one is told in about 5 % of records; with one of twice the accuracy nearly always.
    #[test]
    fn a_discrepancy_is_told_only_where_there_is_one() {
        let mut random = StdRng::seed_from_u64(7);
        let mut told = [0, 0];
        for (count, deviation) in told.iter_mut().zip([0.1, 0.1 * 5.0_f64.sqrt()]) {
            for _ in 0..400 {
                let draw = |_| deviation * random.sample::<f64, _>(StandardNormal);
                let misfits: Vec<f64> = (0..20).map(draw).collect();
                let (problem, predicted) = problem(&misfits, 0.1);
                let unknown = Unknown::of(&problem, 0);
                *count += u32::from(Discrepancy::estimate(&unknown, &problem, &predicted, 0).told);
            }
        }
        // 20 expected, with a standard deviation of 4.4.
        assert!((4..36).contains(&told[0]), "{told:?}");
        assert!(told[1] > 380, "{told:?}");
    }
}
