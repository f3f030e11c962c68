//! The result of a cross-validation: plain data that becomes JSON.

use serde::Serialize;

use super::super::local::End;
use super::super::problem::{Case, Interval, Problem};
use super::regression::leave_one_out;
use super::{Fold, Whole};

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
#[derive(Clone, Debug, Serialize)]
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
#[derive(Clone, Debug, Serialize)]
pub struct HeldOutResult {
    /// The quantity.
    pub quantity: String,
    /// The measured value.
    pub measured: f64,
    /// The accuracy of the measurement, with the model's discrepancy, where there is one, added.
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
    /// Gathers what leaving out the cases has told.
    pub(super) fn new(whole: &Whole<'_>, folds: &[Result<Fold, String>]) -> Self {
        let problem = whole.problem;
        let rows: Vec<Vec<f64>> = whole.known.iter().zip(&problem.cases).map(row).collect();
        let columns: Vec<Column> = (0..problem.quantities.len())
            .map(|quantity| Column::new(problem, &rows, quantity))
            .collect();
        Self {
            quantities: (columns.iter().enumerate())
                .map(|(quantity, column)| errors(whole, folds, column, quantity))
                .collect(),
            free: (0..problem.free.len())
                .map(|index| moves(whole, folds, index))
                .collect(),
            cases: (folds.iter().enumerate())
                .map(|(case, fold)| held_out(whole, fold.as_ref(), &columns, case))
                .collect(),
        }
    }
}

/// What is known of a case before it is measured.
fn row((known, case): (&Vec<f64>, &Case)) -> Vec<f64> {
    let middle = |interval: &Interval| interval.value(0.5);
    let known = known.iter().copied();
    known.chain(case.latents.iter().map(middle)).collect()
}

/// Predictions of a quantity, case by case.
struct Column {
    measured: Vec<f64>,
    linear: Vec<Option<f64>>,
    mean: Vec<Option<f64>>,
}

impl Column {
    fn new(problem: &Problem, rows: &[Vec<f64>], quantity: usize) -> Self {
        let cases = problem.cases.iter();
        let measured: Vec<f64> = cases.map(|case| case.measured[quantity].value).collect();
        let none = vec![Vec::new(); rows.len()];
        let bare = rows.iter().all(Vec::is_empty);
        Self {
            linear: if bare {
                vec![None; rows.len()]
            } else {
                leave_one_out(rows, &measured)
            },
            mean: leave_one_out(&none, &measured),
            measured,
        }
    }
}

fn errors(
    whole: &Whole<'_>,
    folds: &[Result<Fold, String>],
    column: &Column,
    quantity: usize,
) -> QuantityErrors {
    let of_all = |value: &dyn Fn(&Fold) -> Option<f64>| {
        let values = folds.iter().map(|fold| value(fold.as_ref().ok()?));
        size(whole.problem, folds, &column.measured, values)
    };
    let of = |values: &[Option<f64>]| {
        size(
            whole.problem,
            folds,
            &column.measured,
            values.iter().copied(),
        )
    };
    let fitted = whole.minimum.misfit.predicted.iter();
    let fitted: Vec<_> = fitted.map(|row| Some(row[quantity])).collect();
    let named = &whole.problem.quantities[quantity];
    QuantityErrors {
        quantity: named.name.clone(),
        unit: named.unit.clone(),
        fitted: of(&fitted),
        predicted: of_all(&|fold| Some(fold.forecast.mean[quantity])),
        own: of_all(&|fold| Some(fold.own.as_ref()?.predicted[quantity])),
        linear: of(&column.linear),
        mean: of(&column.mean),
    }
}

/// The size of the errors over all cases that were predicted; `None` where one of these has no value.
fn size(
    problem: &Problem,
    folds: &[Result<Fold, String>],
    measured: &[f64],
    values: impl Iterator<Item = Option<f64>>,
) -> Option<ErrorSize> {
    let (mut count, mut squares, mut largest) = (0, 0.0, None);
    for (case, (value, measured)) in values.zip(measured).enumerate() {
        if folds[case].is_err() {
            continue;
        }
        let error = (value? - measured).abs();
        count += 1;
        squares += error * error;
        if largest.is_none_or(|(most, _)| error > most) {
            largest = Some((error, case));
        }
    }
    let (largest, case) = largest?;
    Some(ErrorSize {
        rms: (squares / f64::from(count)).sqrt(),
        largest,
        case: problem.cases[case].label.clone(),
    })
}

fn moves(whole: &Whole<'_>, folds: &[Result<Fold, String>], index: usize) -> Moves {
    let pairs = folds.iter().zip(&whole.problem.cases);
    let values: Vec<(f64, String)> = pairs
        .filter_map(|(fold, case)| Some((fold.as_ref().ok()?.free[index], case.label.clone())))
        .collect();
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

fn held_out(
    whole: &Whole<'_>,
    fold: Result<&Fold, &String>,
    columns: &[Column],
    case: usize,
) -> HeldOut {
    let Case {
        label,
        latents,
        measured,
    } = &whole.problem.cases[case];
    let own = fold.ok().and_then(|fold| fold.own.as_ref());
    let forecast = fold.ok().map(|fold| &fold.forecast);
    let result = |(quantity, column): (usize, &Column)| HeldOutResult {
        quantity: whole.problem.quantities[quantity].name.clone(),
        measured: measured[quantity].value,
        accuracy: measured[quantity].accuracy,
        fitted: whole.minimum.misfit.predicted[case][quantity],
        predicted: forecast.map(|forecast| forecast.mean[quantity]),
        spread: forecast.map(|forecast| forecast.deviation[quantity]),
        own: own.map(|own| own.predicted[quantity]),
        linear: column.linear[case],
        mean: column.mean[case],
    };
    let needed = own.iter().flat_map(|own| &own.needed);
    let needed = whole.problem.latents.iter().zip(latents).zip(needed);
    let needed = needed.map(|((latent, &Interval { min, max }), &value)| Needed {
        name: latent.name.clone(),
        interval: [min, max],
        value,
        outside: !(min..=max).contains(&value),
    });
    HeldOut {
        label: label.clone(),
        end: fold.ok().map(|fold| fold.end),
        failure: fold.err().cloned(),
        failed_simulations: forecast.map_or(0, |forecast| forecast.failed),
        free: fold.map_or_else(|_| Vec::new(), |fold| fold.free.clone()),
        results: columns.iter().enumerate().map(result).collect(),
        latents: needed.collect(),
        squares: own.map(|own| own.squares),
    }
}
