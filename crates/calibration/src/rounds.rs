//! A search as a study asks for it.

use super::{
    objective::Objective,
    optima::Optimum,
    outcome::IdentificationOutcome,
    problem::{Problem, Simulate},
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

/// Searches; where gain errors are parts of predicted values, first without them, for these values.
///
/// # Errors
/// Those of [`search`].
pub fn searched(task: &Task<'_>, model: &dyn Simulate, observe: &dyn Fn(&Progress)) -> Result<Searched, SearchError> {
    let find = |problem: &Problem| {
        let objective = Objective::new(problem, model, task.difference);
        search(&objective, task.starts, &task.effort, observe)
    };
    let mut problem = task.problem.clone();
    if let Some(first) = problem.with_parts(None) {
        let (optima, _) = find(&first)?;
        problem = problem.with_parts(Some(&optima[0].minimum.misfit.predicted)).unwrap_or(problem);
    }
    let (optima, progress) = find(&problem)?;
    Ok(Searched { problem, optima, progress })
}
