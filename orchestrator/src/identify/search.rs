//! The deepest minimum: many local searches from a space-filling set of starts.
//!
//! Multi-start Levenberg-Marquardt is the strategy that served best in the comparison of Raue et
//! al. 2013 (Lessons learned from quantitative dynamical modeling in systems biology, PLoS ONE 8,
//! e74335): unlike evolution strategies it uses the structure of a sum of squares, a local search
//! that ends at the same minimum from many starts is evidence that nothing deeper was missed, and one that
//! doesn't shows where the others are. Starts are first screened by their misfit alone.

use std::time::Instant;

use super::local::{End, Limits, Minimum, minimise};
use super::objective::{Differences, Objective};
use super::problem::NoPrediction;

/// How much to search.
#[derive(Clone, Copy, Debug)]
pub struct Effort {
    /// How many of the screened starts are followed down to a minimum.
    pub descents: usize,
    /// The most iterations of each.
    pub iterations: usize,
    /// When time is up.
    pub deadline: Option<Instant>,
}

/// A local search that ended.
#[derive(Clone, Debug)]
pub struct Descent {
    /// The number of its start.
    pub start: usize,
    /// Where it ended; `None` where simulations failed.
    pub found: Option<Found>,
}

/// Where a local search ended.
#[derive(Clone, Debug)]
pub struct Found {
    /// The unknowns, as places between their bounds.
    pub places: Vec<f64>,
    /// The sum of squares.
    pub cost: f64,
    /// Why it ended.
    pub end: End,
}

/// How far a search has got.
#[derive(Clone, Debug, Default)]
pub struct Progress {
    /// The sum of squares at each start; `None` where a simulation failed.
    pub screened: Vec<Option<f64>>,
    /// The local searches.
    pub descents: Vec<Descent>,
}

impl Progress {
    /// The deepest place so far.
    pub fn best(&self) -> Option<&Found> {
        let found = self
            .descents
            .iter()
            .filter_map(|descent| descent.found.as_ref());
        found.min_by(|a, b| a.cost.total_cmp(&b.cost))
    }
}

/// Why there is no result.
#[derive(Debug, thiserror::Error)]
pub enum SearchError {
    /// No start could be simulated.
    #[error("none of the {0} starts could be simulated; the last one failed with: {1}")]
    NoStart(usize, String),
    /// Time was up before anything was found.
    #[error("the time limit ended the search before the first start was simulated")]
    NoTime,
    /// There are no further predictions.
    #[error("the search was stopped")]
    Stopped,
    /// The simulations around the minimum failed.
    #[error("around the minimum: {0}")]
    Simulation(String),
}

impl From<NoPrediction> for SearchError {
    fn from(error: NoPrediction) -> Self {
        match error {
            NoPrediction::Stopped => Self::Stopped,
            NoPrediction::Here(message) => Self::Simulation(message),
        }
    }
}

/// So many simulations are asked for at a time when starts are screened.
const TOGETHER: usize = 64;

/// Searches from starts (free parameters as places), and tells how far it has got.
///
/// # Errors
/// When nothing can be simulated, or time is up before anything was.
pub fn search(
    objective: &Objective<'_>,
    starts: &[Vec<f64>],
    settings: &Effort,
    observe: &dyn Fn(&Progress),
) -> Result<(Minimum, Progress), SearchError> {
    let in_time = || {
        settings
            .deadline
            .is_none_or(|deadline| Instant::now() < deadline)
    };
    let mut progress = Progress::default();
    let mut last_error = String::new();
    for starts in starts.chunks(TOGETHER.div_ceil(objective.problem.cases.len().max(1))) {
        if !in_time() {
            break;
        }
        let sets = starts.iter().map(|start| unknowns(objective, start));
        for misfit in objective.misfits(&sets.collect::<Vec<_>>())? {
            let cost = misfit.map(|misfit| misfit.cost());
            progress
                .screened
                .push(cost.map_err(|error| last_error = error).ok());
        }
        observe(&progress);
    }
    if progress.screened.is_empty() {
        return Err(SearchError::NoTime);
    }
    let ranked = ranked(&progress.screened);
    let Some(&first) = ranked.first() else {
        return Err(SearchError::NoStart(progress.screened.len(), last_error));
    };
    let limits = Limits {
        iterations: settings.iterations,
        decrease: 1e-4,
        deadline: settings.deadline,
    };
    for &start in ranked.iter().take(settings.descents) {
        if progress
            .descents
            .iter()
            .any(|descent| descent.start == start)
            || !in_time()
        {
            continue;
        }
        let from = unknowns(objective, &starts[start]);
        let minimum = match minimise(objective, from, &[], Differences::Forward, &limits) {
            Err(NoPrediction::Stopped) => return Err(SearchError::Stopped),
            other => other.ok(),
        };
        // One that time cut short is no minimum.
        if minimum
            .as_ref()
            .is_some_and(|minimum| minimum.end == End::Time)
            && progress.best().is_some()
        {
            break;
        }
        let found = minimum.map(|minimum| Found {
            cost: minimum.misfit.cost(),
            places: minimum.places,
            end: minimum.end,
        });
        progress.descents.push(Descent { start, found });
        observe(&progress);
    }
    let from = progress.best().map(|found| found.places.clone());
    let from = from.unwrap_or_else(|| unknowns(objective, &starts[first]));
    let limits = Limits {
        iterations: 2 * settings.iterations,
        decrease: 1e-7,
        ..limits
    };
    let minimum = minimise(objective, from, &[], Differences::Central, &limits)?;
    Ok((minimum, progress))
}

/// All unknowns at a start: latent parameters begin in the middle of their intervals.
fn unknowns(objective: &Objective<'_>, free: &[f64]) -> Vec<f64> {
    let mut places = free.to_vec();
    places.resize(objective.problem.unknowns(), 0.5);
    places
}

/// The starts that could be simulated, the best first.
fn ranked(screened: &[Option<f64>]) -> Vec<usize> {
    let mut order: Vec<(usize, f64)> = screened
        .iter()
        .enumerate()
        .filter_map(|(i, cost)| Some((i, (*cost)?)))
        .collect();
    order.sort_by(|a, b| a.1.total_cmp(&b.1));
    order.into_iter().map(|(index, _)| index).collect()
}
