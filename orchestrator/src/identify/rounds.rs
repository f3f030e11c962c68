//! The search with unknown discrepancies of the model: it alternates with their estimates.

use super::discrepancy::{Discrepancy, Unknown, widened};
use super::objective::Objective;
use super::optima::Optimum;
use super::problem::{Problem, Simulate};
use super::search::{Effort, Progress, SearchError, search};

/// The most searches.
const ROUNDS: usize = 6;

/// A discrepancy stays when it changes by less than this part of itself and of its scale.
const CLOSE: f64 = 0.05;

/// What is searched for, and how.
#[derive(Clone, Copy)]
pub struct Task<'a> {
    /// The problem without discrepancies.
    pub problem: &'a Problem,
    /// The unknown discrepancies.
    pub unknown: &'a [Unknown],
    /// The distance of simulations for a derivative, as a part of that of the bounds.
    pub difference: f64,
    /// Where local searches begin.
    pub starts: &'a [Vec<f64>],
    /// How much to search.
    pub effort: Effort,
}

/// What the search has found.
pub struct Found {
    /// The problem with the discrepancies found.
    pub problem: Problem,
    /// The distinct minima.
    pub optima: Vec<Optimum>,
    /// The local searches of the last round.
    pub progress: Progress,
    /// The discrepancies.
    pub discrepancies: Vec<Discrepancy>,
}

/// Searches; where discrepancies are unknown, again with those that the search before has left, until they stay.
///
/// # Errors
/// Those of [`search`].
pub fn searched(
    task: &Task<'_>,
    model: &dyn Simulate,
    observe: &dyn Fn(&Progress),
) -> Result<Found, SearchError> {
    let mut problem = task.problem.clone();
    let mut known = vec![0.0; task.unknown.len()];
    let mut round = 1;
    loop {
        let objective = Objective::new(&problem, model, task.difference);
        let (optima, progress) = search(&objective, task.starts, &task.effort, observe)?;
        let predicted = optima.first().map(|own| &own.minimum.misfit.predicted[..]);
        let estimate = |unknown| {
            let fitted = task.problem.free.len();
            let predicted = predicted.unwrap_or_default();
            Discrepancy::estimate(unknown, task.problem, predicted, fitted)
        };
        let discrepancies: Vec<Discrepancy> = task.unknown.iter().map(estimate).collect();
        let pairs = discrepancies.iter().zip(&known);
        let stays = |(found, known): (&Discrepancy, &f64)| {
            (found.deviation - known).abs() <= CLOSE * (found.scale + known)
        };
        if pairs.into_iter().all(stays) || round == ROUNDS {
            return Ok(Found {
                problem,
                optima,
                progress,
                discrepancies,
            });
        }
        known = discrepancies.iter().map(|found| found.deviation).collect();
        problem = widened(task.problem, task.unknown, &known);
        round += 1;
    }
}
