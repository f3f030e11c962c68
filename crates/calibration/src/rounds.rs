//! A search as a study asks for it.

use super::{
    local::{Limits, Minimum, minimise},
    objective::{Differences, Objective},
    optima::Optimum,
    outcome::IdentificationOutcome,
    problem::{NoPrediction, Problem, Simulate},
    search::{Effort, Progress, SearchError, search},
};

/// One search: its problem and its settings.
#[derive(Clone, Copy)]
pub struct Task<'a> {
    /// The problem.
    pub problem: &'a Problem,
    /// The distance of simulations for a derivative, as a part of that of the bounds.
    pub difference: f64,
    /// Where local searches begin.
    pub starts: &'a [Vec<f64>],
    /// How much to search.
    pub effort: Effort,
}

/// The end of the search.
pub struct Searched {
    /// The problem, with the gain errors that are parts of predicted values in units of the values.
    pub problem: Problem,
    /// The distinct minima.
    pub optima: Vec<Optimum>,
    /// The local searches.
    pub progress: Progress,
}

impl Searched {
    /// The result.
    pub fn outcome(&self) -> IdentificationOutcome {
        IdentificationOutcome::new(&self.problem, &self.optima, &self.progress)
    }
}

/// Searches; where gain errors are parts of predicted values, first without them, and then as parts of what the best fit predicts.
///
/// # Errors
/// Those of [`search`].
pub fn searched(task: &Task, model: &dyn Simulate, observe: &dyn Fn(&Progress)) -> Result<Searched, SearchError> {
    let find = |problem: &Problem| {
        let objective = Objective::new(problem, model, task.difference);
        search(&objective, task.starts, &task.effort, observe)
    };
    let mut problem = task.problem.clone();
    if let Some(first) = problem.with_parts(None) {
        let (optima, _) = find(&first)?;
        problem = settled(task, model, optima[0].minimum.clone())?;
    }
    let (optima, progress) = find(&problem)?;
    Ok(Searched { problem, optima, progress })
}

/// The problem whose gain errors are parts of what the fit predicts that they lead to, from a minimum on: each round
/// brings the prediction nearer to the last one by about the size of a gain error.
fn settled(task: &Task, model: &dyn Simulate, mut minimum: Minimum) -> Result<Problem, SearchError> {
    const ROUNDS: usize = 8;
    /// A relative change of a prediction that no result shows.
    const SETTLED: f64 = 1e-5;
    let limits = Limits { iterations: task.effort.iterations, decrease: 1e-7 };
    let mut problem = task.problem.clone();
    for _ in 0..ROUNDS {
        let predicted = minimum.misfit.predicted;
        problem = task.problem.with_parts(Some(&predicted)).unwrap_or(problem);
        let objective = Objective::new(&problem, model, task.difference);
        minimum = match minimise(&objective, minimum.places, &[], Differences::Central, &limits) {
            // The search that follows tells what fails.
            Err(NoPrediction::Here(_)) => break,
            ended => ended?,
        };
        let values = predicted.iter().zip(&minimum.misfit.predicted).flat_map(|(a, b)| a.iter().zip(b));
        if values.into_iter().all(|(before, now)| (now - before).abs() <= SETTLED * before.abs()) {
            break;
        }
    }
    Ok(problem)
}
