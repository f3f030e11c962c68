//! Cross-validation: each case is predicted from the others.
//!
//! A fit can follow the very cases that it was made from, so its misfits say little about other ones. Here one case is
//! left out at a time, the free parameters are found from the others, and the case that was left out is predicted with
//! them (leave one out; Stone 1974, Cross-validatory choice and assessment of statistical predictions, J. Royal
//! Statistical Society B 36, 111-147). Each search begins at the fit to all cases.
//!
//! Nothing but its interval is known of a latent parameter of the case that is left out. The prediction is therefore
//! the mean over the interval. Beside it stands what the case says itself when the free parameters stay as they are:
//! the latent values that it needs, and whether they lie within the interval.
//!
//! An error that the case shares with others, such as the zero error of a sensor, is predicted as well: the other cases tell
//! of it.

pub mod outcome;
mod regression;
#[cfg(test)]
mod tests;
pub mod text;

use std::time::Instant;

use nalgebra::DMatrix;
use sampling::statistics::moments::{mean, variance};

use super::errors::Errors;
use super::local::{End, Limits, Minimum, minimise};
use super::objective::{Differences, Objective, finite};
use super::problem::{Effect, Interval, NoPrediction, NotNormal, Prediction, Problem, Query, Simulate, Source};
use outcome::{CrossValidation, HeldOut, Needed};

/// Points over the intervals of latent parameters that a prediction is averaged over.
const POINTS: usize = 16;

/// How far beyond its interval a latent parameter is searched, in half-widths.
const BEYOND: f64 = 1.0;

/// The fit to all cases, with which cross-validation starts.
#[derive(Clone, Copy)]
pub struct Whole<'a> {
    /// The problem with all cases.
    pub problem: &'a Problem,
    /// The model.
    pub model: &'a dyn Simulate,
    /// How far apart simulations stand for a derivative, as a part of the distance between the bounds.
    pub difference: f64,
    /// The fit to all cases: where each search begins.
    pub minimum: &'a Minimum,
    /// The cases' known parameters: a linear regression predicts from them.
    pub known: &'a [Vec<f64>],
    /// The most iterations of a search.
    pub iterations: usize,
    /// When time is up.
    pub deadline: Option<Instant>,
}

impl Whole<'_> {
    fn limits(&self, decrease: f64) -> Limits {
        Limits { iterations: self.iterations, decrease, deadline: self.deadline }
    }
}

/// Leaves each case out in turn, and tells which one is at work. A case that cannot be predicted has a message instead.
///
/// # Errors
/// When there are no further predictions.
pub fn cross_validate(whole: &Whole<'_>, observe: &dyn Fn(usize)) -> Result<CrossValidation, NoPrediction> {
    let cases = 0..whole.problem.cases.len();
    let plain = outcome::plain(whole);
    let held_out = |case| {
        observe(case);
        let told = HeldOut::new(whole, case, &plain);
        match predicted(whole, case, told.clone()) {
            Err(NoPrediction::Here(message)) => Ok(HeldOut { failure: Some(message), ..told }),
            told => told,
        }
    };
    let cases = cases.map(held_out).collect::<Result<_, _>>()?;
    Ok(CrossValidation::new(whole, cases))
}

/// Adds the predictions of a case from the others.
fn predicted(whole: &Whole<'_>, case: usize, mut told: HeldOut) -> Result<HeldOut, NoPrediction> {
    let (others, minimum) = without(whole, case)?;
    if minimum.end == End::Time {
        // What is there is still the fit to all cases, or on the way from it: no prediction.
        return Err(NoPrediction::Here(
            "the time limit came before the search over the other cases had ended".to_owned(),
        ));
    }
    let places = &minimum.places[..whole.problem.free.len()];
    told.end = Some(minimum.end);
    told.free = whole.problem.free_values(places);
    let sources = minimum.misfit.sources(&others);
    forecast(whole, case, &mut told)?;
    own_latents(whole, case, places, (&others, sources), &mut told)?;
    // What is measured is the truth and what the others say of the errors that this case shares with them.
    let shifts = whole.problem.shifts(sources);
    for (result, shift) in told.results.iter_mut().zip(&shifts[case]) {
        for value in [&mut result.predicted, &mut result.own].into_iter().flatten() {
            *value += shift;
        }
    }
    Ok(told)
}

/// Some of the cases of a model.
struct Part<'a> {
    model: &'a dyn Simulate,
    cases: Vec<usize>,
}

impl Simulate for Part<'_> {
    fn simulate(&self, queries: &[Query]) -> Result<Vec<Prediction>, NoPrediction> {
        let whole = |query: &Query| Query { case: self.cases[query.case], ..query.clone() };
        self.model.simulate(&queries.iter().map(whole).collect::<Vec<_>>())
    }
}

/// The free parameters from all cases but one, and the problem that these cases are.
fn without(whole: &Whole<'_>, left_out: usize) -> Result<(Problem, Minimum), NoPrediction> {
    let cases: Vec<usize> = (0..whole.problem.cases.len()).filter(|&case| case != left_out).collect();
    let mut places = whole.minimum.places.clone();
    places.drain(whole.problem.latents_of(left_out));
    let problem = with_cases(whole.problem, &cases);
    let model = Part { model: whole.model, cases };
    let objective = Objective::new(&problem, &model, whole.difference);
    let [rough, fine] = [1e-4, 1e-7].map(|decrease| whole.limits(decrease));
    let near = minimise(&objective, places, &[], Differences::Forward, &rough)?;
    let minimum = minimise(&objective, near.places, &[], Differences::Central, &fine)?;
    Ok((problem, minimum))
}

/// The problem with some of its cases.
fn with_cases(problem: &Problem, cases: &[usize]) -> Problem {
    let some = cases.iter().map(|&case| problem.cases[case].clone());
    let sources = problem.sources.iter().map(|source| {
        let effects = source.effects.iter().filter_map(|effect| {
            let case = cases.iter().position(|&case| case == effect.case)?;
            Some(Effect { case, ..*effect })
        });
        Source { effects: effects.collect(), rectangular: source.rectangular }
    });
    let not_normal = problem.not_normal.iter().filter_map(|value| {
        let case = cases.iter().position(|&case| case == value.case)?;
        Some(NotNormal { case, ..*value })
    });
    Problem { cases: some.collect(), sources: sources.collect(), not_normal: not_normal.collect(), ..problem.clone() }
}

/// The problem of a single case when others have told of the shared errors: their means are taken from the measured values,
/// and what is left of them are new sources.
fn alone(whole: &Problem, case: usize, (others, means): (&Problem, &[f64])) -> Problem {
    let mut problem = with_cases(whole, &[case]);
    let shifts = problem.shifts(means);
    for (measured, shift) in problem.cases[0].measured.iter_mut().zip(&shifts[0]) {
        measured.value -= shift;
    }
    // With M = L L' their covariance M^-1 is that of L'^-1 z, with z standard normal.
    let left = Errors::new(others).halved(DMatrix::identity(means.len(), means.len()));
    let mixed = (0..means.len()).map(|row| {
        let sources = problem.sources.iter().enumerate();
        let effects = sources.flat_map(|(number, source)| {
            let part = left[(row, number)];
            source.effects.iter().map(move |effect| Effect { part: None, change: part * effect.change, ..*effect })
        });
        Source { effects: effects.filter(|effect| effect.change != 0.0).collect(), rectangular: false }
    });
    problem.sources = mixed.collect();
    problem
}

/// The prediction of a case by its free parameters: the mean over all values that its latent parameters may have.
fn forecast(whole: &Whole<'_>, case: usize, told: &mut HeldOut) -> Result<(), NoPrediction> {
    let intervals = &whole.problem.cases[case].latents;
    let query = |places: Vec<f64>| {
        let pairs = intervals.iter().zip(places);
        Query { case, free: told.free.clone(), latents: pairs.map(|(interval, place)| interval.value(place)).collect() }
    };
    let queries: Vec<Query> = lattice(intervals.len()).into_iter().map(query).collect();
    let mut rows = Vec::new();
    let mut message = String::new();
    for prediction in whole.model.simulate(&queries)? {
        match finite(prediction) {
            Ok(predicted) => rows.push(predicted),
            Err(error) => message = error,
        }
    }
    if rows.is_empty() {
        return Err(NoPrediction::Here(message));
    }
    told.failed_simulations = queries.len() - rows.len();
    for (k, result) in told.results.iter_mut().enumerate() {
        let column: Vec<f64> = rows.iter().map(|row| row[k]).collect();
        result.predicted = Some(mean(&column));
        result.spread = Some(variance(&column, 0).sqrt());
    }
    Ok(())
}

/// Evenly spread places between the ends of intervals: the midpoint rule for one of them, and beside it a lattice with
/// the powers of an irrational number (Kronecker's) for further ones.
fn lattice(dimensions: usize) -> Vec<Vec<f64>> {
    const IRRATIONAL: f64 = 0.618_033_988_749_894_9;
    if dimensions == 0 {
        return vec![Vec::new()];
    }
    let place = |i: usize, k: usize| match k {
        0 => (i as f64 + 0.5) / POINTS as f64,
        _ => (0.5 + i as f64 * IRRATIONAL.powi(k as i32)).fract(),
    };
    (0..POINTS).map(|i| (0..dimensions).map(|k| place(i, k)).collect()).collect()
}

/// The latent parameters of a case, from the free ones given as places.
fn own_latents(
    whole: &Whole<'_>,
    case: usize,
    free: &[f64],
    shared: (&Problem, &[f64]),
    told: &mut HeldOut,
) -> Result<(), NoPrediction> {
    let known = &whole.problem.cases[case].latents;
    if known.is_empty() {
        return Ok(());
    }
    let problem = alone(whole.problem, case, shared);
    let wide: Vec<Interval> = known.iter().map(widened).collect();
    let within = latents(whole, (&problem, case), known, free)?;
    let needed = latents(whole, (&problem, case), &wide, free)?;
    told.squares = Some([&within, &needed].map(|minimum| minimum.misfit.data_cost(&problem)));
    let predicted = within.misfit.predicted.into_iter().flatten();
    for (result, value) in told.results.iter_mut().zip(predicted) {
        result.own = Some(value);
    }
    let known = whole.problem.latents.iter().zip(known);
    let values = wide.iter().zip(&needed.places[free.len()..]);
    let needed = known.zip(values).map(|((latent, known), (interval, &place))| {
        let (Interval { min, max }, value) = (*known, interval.value(place));
        Needed { name: latent.name.clone(), interval: [min, max], value, outside: !(min..=max).contains(&value) }
    });
    told.latents = needed.collect();
    Ok(())
}

fn widened(interval: &Interval) -> Interval {
    let more = 0.5 * BEYOND * (interval.max - interval.min);
    Interval { min: interval.min - more, max: interval.max + more }
}

/// The latent parameters of a case within intervals, the free parameters held.
fn latents(
    whole: &Whole<'_>,
    (alone, case): (&Problem, usize),
    intervals: &[Interval],
    free: &[f64],
) -> Result<Minimum, NoPrediction> {
    let mut problem = alone.clone();
    problem.cases[0].latents = intervals.to_vec();
    let model = Part { model: whole.model, cases: vec![case] };
    let objective = Objective::new(&problem, &model, whole.difference);
    let mut places = free.to_vec();
    places.resize(problem.unknowns(), 0.5);
    let held: Vec<usize> = (0..free.len()).collect();
    let limits = whole.limits(1e-6);
    minimise(&objective, places, &held, Differences::Central, &limits)
}
