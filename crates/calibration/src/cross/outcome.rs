//! The result of a cross-validation: plain data that becomes JSON.

use serde::Serialize;

use super::super::local::End;
use super::super::problem::{Case, Interval, Quantity};
use super::Whole;
use super::regression::leave_one_out;

/// A cross-validation.
#[derive(Clone, Debug, Serialize)]
pub struct CrossValidation {
    /// Errors of each quantity over all cases that could be predicted.
    pub quantities: Vec<QuantityErrors>,
    /// How far the free parameters move as cases are left out.
    pub free: Vec<Moves>,
    /// The cases.
    pub cases: Vec<HeldOut>,
}

/// Errors of a quantity: predicted less measured.
#[derive(Clone, Debug, Serialize)]
pub struct QuantityErrors {
    /// The quantity.
    pub quantity: String,
    /// The unit of its numbers.
    pub unit: Option<String>,
    /// Of the fit to all cases.
    pub fitted: Option<ErrorSize>,
    /// Of the model fitted to the other cases.
    pub predicted: Option<ErrorSize>,
    /// The same with the latent parameters that fit the case's own results best; `None` without latent parameters.
    pub own: Option<ErrorSize>,
    /// Of a linear regression of the other cases on known values and middles of intervals; `None` where there is
    /// nothing to regress on, or the cases are too few.
    pub linear: Option<ErrorSize>,
    /// Of the mean of the other cases.
    pub mean: Option<ErrorSize>,
}

/// The size of errors.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ErrorSize {
    /// Root of the mean square.
    pub rms: f64,
    /// The largest absolute one.
    pub largest: f64,
    /// The case that has the largest one.
    pub case: String,
}

/// A free parameter over all searches.
#[derive(Clone, Debug, Serialize)]
pub struct Moves {
    /// Its name.
    pub name: String,
    /// The unit of its numbers.
    pub unit: Option<String>,
    /// From all cases.
    pub value: f64,
    /// The least value, and the label of the case that was left out then.
    pub least: Option<(f64, String)>,
    /// The greatest value.
    pub greatest: Option<(f64, String)>,
}

/// A case that was left out.
#[derive(Clone, Debug, Default, Serialize)]
pub struct HeldOut {
    /// Name, for people.
    pub label: String,
    /// Why the search over the other cases ended.
    pub end: Option<End>,
    /// Why there is no prediction.
    pub failure: Option<String>,
    /// How many of the simulations over the intervals of latent parameters failed.
    pub failed_simulations: usize,
    /// The free parameters from the other cases.
    pub free: Vec<f64>,
    /// The results.
    pub results: Vec<HeldOutResult>,
    /// The latent parameters.
    pub latents: Vec<Needed>,
    /// The sums of squares of the case's own results, with its best latent parameters within the intervals, and
    /// within twice as wide ones.
    pub squares: Option<[f64; 2]>,
}

/// A result of a case that was left out.
#[derive(Clone, Debug, Default, Serialize)]
pub struct HeldOutResult {
    /// The quantity.
    pub quantity: String,
    /// The measured value.
    pub measured: f64,
    /// The accuracy of the measurement, with the model's discrepancy, where there is one, added; without shared errors, which
    /// every prediction below counts as far as it knows them.
    pub accuracy: f64,
    /// By the fit to all cases.
    pub fitted: f64,
    /// By the model fitted to the other cases; the mean over the intervals of latent parameters.
    pub predicted: Option<f64>,
    /// The standard deviation over these intervals, and of nothing else: 0 without latent parameters.
    pub spread: Option<f64>,
    /// With the latent parameters that fit the case's own results best.
    pub own: Option<f64>,
    /// By a linear regression of the other cases.
    pub linear: Option<f64>,
    /// The mean of the other cases.
    pub mean: Option<f64>,
}

/// A latent parameter of a case that was left out.
#[derive(Clone, Debug, Serialize)]
pub struct Needed {
    /// Its name.
    pub name: String,
    /// The interval that it was known to lie in.
    pub interval: [f64; 2],
    /// The value that fits the case's own results best, searched to half a width beyond the interval.
    pub value: f64,
    /// Whether this value lies outside of the interval.
    pub outside: bool,
}

impl CrossValidation {
    /// Sums up what leaving out the cases has told.
    pub(super) fn new(whole: &Whole<'_>, cases: Vec<HeldOut>) -> Self {
        let quantities = whole.problem.quantities.iter().enumerate();
        Self {
            quantities: quantities.map(|(k, quantity)| errors(quantity, &cases, k)).collect(),
            free: (0..whole.problem.free.len()).map(|index| moves(whole, &cases, index)).collect(),
            cases,
        }
    }
}

/// Predictions of a quantity, case by case: by a linear regression of the other cases, and by their mean.
pub(super) type Plain = [Vec<Option<f64>>; 2];

/// The plain predictions of each quantity.
pub(super) fn plain(whole: &Whole<'_>) -> Vec<Plain> {
    let problem = whole.problem;
    let rows: Vec<Vec<f64>> = whole.known.iter().zip(&problem.cases).map(row).collect();
    let none = vec![Vec::new(); rows.len()];
    let of = |quantity: usize| {
        let cases = problem.cases.iter();
        let measured: Vec<f64> = cases.map(|case| case.measured[quantity].value).collect();
        let linear = match rows == none {
            true => vec![None; rows.len()],
            false => leave_one_out(&rows, &measured),
        };
        [linear, leave_one_out(&none, &measured)]
    };
    (0..problem.quantities.len()).map(of).collect()
}

/// The mean and deviation predicted for a case before its measurement is used.
fn row((known, case): (&Vec<f64>, &Case)) -> Vec<f64> {
    let middle = |interval: &Interval| interval.value(0.5);
    let known = known.iter().copied();
    known.chain(case.latents.iter().map(middle)).collect()
}

impl HeldOut {
    /// A case without predictions by the model.
    pub(super) fn new(whole: &Whole<'_>, case: usize, plain: &[Plain]) -> Self {
        let Case { label, measured, .. } = &whole.problem.cases[case];
        let shifts = whole.problem.shifts(whole.minimum.misfit.sources(whole.problem));
        let result = |(k, quantity): (usize, &Quantity)| HeldOutResult {
            quantity: quantity.name.clone(),
            measured: measured[k].value,
            accuracy: measured[k].accuracy,
            fitted: whole.minimum.misfit.predicted[case][k] + shifts[case][k],
            linear: plain[k][0][case],
            mean: plain[k][1][case],
            ..HeldOutResult::default()
        };
        let quantities = whole.problem.quantities.iter().enumerate();
        Self { label: label.clone(), results: quantities.map(result).collect(), ..Self::default() }
    }
}

fn errors(quantity: &Quantity, cases: &[HeldOut], index: usize) -> QuantityErrors {
    let of = |value: fn(&HeldOutResult) -> Option<f64>| size(cases, index, value);
    QuantityErrors {
        quantity: quantity.name.clone(),
        unit: quantity.unit.clone(),
        fitted: of(|result| Some(result.fitted)),
        predicted: of(|result| result.predicted),
        own: of(|result| result.own),
        linear: of(|result| result.linear),
        mean: of(|result| result.mean),
    }
}

/// The size of the errors over all cases that were predicted; `None` where one of these has no value.
fn size(cases: &[HeldOut], index: usize, value: impl Fn(&HeldOutResult) -> Option<f64>) -> Option<ErrorSize> {
    let (mut count, mut squares, mut largest) = (0, 0.0, None);
    for case in cases.iter().filter(|case| case.failure.is_none()) {
        let result = &case.results[index];
        let error = (value(result)? - result.measured).abs();
        count += 1;
        squares += error * error;
        if largest.is_none_or(|(most, _)| error > most) {
            largest = Some((error, &case.label));
        }
    }
    let (largest, case) = largest?;
    Some(ErrorSize { rms: (squares / f64::from(count)).sqrt(), largest, case: case.clone() })
}

fn moves(whole: &Whole<'_>, cases: &[HeldOut], index: usize) -> Moves {
    let predicted = cases.iter().filter(|case| case.failure.is_none());
    let values: Vec<(f64, String)> = predicted.map(|case| (case.free[index], case.label.clone())).collect();
    let order = |a: &&(f64, String), b: &&(f64, String)| a.0.total_cmp(&b.0);
    let free = &whole.problem.free[index];
    Moves {
        name: free.name.clone(),
        unit: free.unit.clone(),
        value: free.value(whole.minimum.places[index]),
        least: values.iter().min_by(order).cloned(),
        greatest: values.iter().max_by(order).cloned(),
    }
}
