//! The deepest minima: many local searches from a space-filling set of starts.
//!
//! Multi-start Levenberg-Marquardt is the strategy that served best in the comparison of Raue et
//! al. 2013 (Lessons learned from quantitative dynamical modeling in systems biology, PLoS ONE 8,
//! e74335): unlike evolution strategies it uses the structure of a sum of squares, a local search
//! that ends at the same minimum from many starts is evidence that nothing deeper was missed, and one that
//! doesn't shows where the others are. Starts are first screened by their misfit alone.

use statrs::function::gamma::ln_gamma;

use super::{
    failures::Failures,
    local::{End, Limits, Minimum, minimise},
    objective::{Differences, Objective},
    optima::{Optima, Optimum},
    problem::{NoPrediction, Problem},
    sample::SampleError,
};

/// How much to search.
#[derive(Clone, Copy, Debug)]
pub struct Effort {
    /// How many of the screened starts are followed down for each minimum that is found.
    pub descents: usize,
    /// The most iterations of each.
    pub iterations: usize,
}

/// How far a search has got.
#[derive(Clone, Debug, Default)]
pub struct Progress {
    /// The sum of squares at each start; `None` where a simulation failed.
    pub screened: Vec<Option<f64>>,
    /// The ends of the local searches; `None` where simulations failed.
    pub descents: Vec<Option<Minimum>>,
    /// The places at which runs failed.
    pub failures: Failures,
}

impl Progress {
    /// The deepest place so far.
    pub fn best(&self) -> Option<&Minimum> {
        self.descents.iter().flatten().min_by(|a, b| a.cost().total_cmp(&b.cost()))
    }
}

/// Why there is no result.
#[derive(Debug, thiserror::Error)]
pub enum SearchError {
    /// No start could be simulated.
    #[error("none of the {0} starts could be simulated; the last one failed with: {1}")]
    NoStart(usize, String),
    /// The posterior could not be sampled.
    #[error(transparent)]
    Sample(#[from] SampleError),
    /// There are no surrogates.
    #[error("{0}")]
    Surrogate(String),
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

/// How many simulations are requested at a time while starts are screened.
const TOGETHER: usize = 64;

/// Searches from starts (free parameters as places), and tells how far it has got. What comes back are the distinct
/// minima that could be the right one, that with the largest part of the posterior first.
///
/// # Errors
/// When nothing can be simulated.
pub fn search(
    objective: &Objective,
    starts: &[Vec<f64>],
    settings: &Effort,
    observe: &dyn Fn(&Progress),
) -> Result<(Vec<Optimum>, Progress), SearchError> {
    let mut progress = Progress::default();
    let mut last_error = String::new();
    for starts in starts.chunks(TOGETHER.div_ceil(objective.problem.cases.len().max(1))) {
        let sets = starts.iter().map(|start| unknowns(objective.problem, start));
        for misfit in objective.misfits(&sets.collect::<Vec<_>>())? {
            let misfit = misfit.map_err(|error| last_error = error);
            progress.screened.push(misfit.ok().map(|misfit| misfit.cost()));
        }
        observe(&progress);
    }
    let order = order(starts, &progress.screened);
    let Some(&first) = order.first() else { return Err(SearchError::NoStart(progress.screened.len(), last_error)) };
    let deepest = Limits { iterations: 2 * settings.iterations, decrease: 1e-7 };
    let mut optima = Optima::new(objective, deepest);
    let mut queue = order.into_iter();
    // As many descents for each minimum: where there are several, there may be more.
    while progress.descents.len() < settings.descents * optima.count().max(1) {
        let quota = settings.descents * optima.count().max(1) - progress.descents.len();
        let batch: Vec<usize> = queue.by_ref().take(quota).collect();
        if batch.is_empty() {
            break;
        }
        let ends = descend(objective, starts, &batch, settings, &mut progress, observe)?;
        for end in ends {
            // A search that was still on its way down has found no minimum; only the deepest is followed further.
            if end.end == End::Converged || end.cost() < optima.least() {
                optima.add(&end)?;
            }
        }
    }
    if optima.count() == 0 {
        let start = unknowns(objective.problem, &starts[first]);
        let none = Limits { iterations: 0, ..deepest };
        optima.add(&minimise(objective, start, &[], Differences::Forward, &none)?)?;
    }
    let mut ranked = optima.weighed();
    for optimum in &mut ranked {
        optimum.look_at_ends(objective)?;
        if objective.failures().failed > 0 {
            optimum.look_around(objective)?;
        }
    }
    progress.failures = objective.failures();
    Ok((ranked, progress))
}

/// Follows starts down; the ends come with the deepest first.
fn descend(
    objective: &Objective,
    starts: &[Vec<f64>],
    batch: &[usize],
    settings: &Effort,
    progress: &mut Progress,
    observe: &dyn Fn(&Progress),
) -> Result<Vec<Minimum>, SearchError> {
    let limits = Limits { iterations: settings.iterations, decrease: 1e-4 };
    let mut ends: Vec<Minimum> = Vec::new();
    for &start in batch {
        let from = unknowns(objective.problem, &starts[start]);
        let minimum = match minimise(objective, from, &[], Differences::Forward, &limits) {
            Err(NoPrediction::Stopped) => return Err(SearchError::Stopped),
            other => other.ok(),
        };
        ends.extend(minimum.clone());
        progress.descents.push(minimum);
        observe(progress);
    }
    ends.sort_by(|a, b| a.cost().total_cmp(&b.cost()));
    Ok(ends)
}

/// All unknowns at a start: latent parameters begin in the middle of their intervals.
pub fn unknowns(problem: &Problem, free: &[f64]) -> Vec<f64> {
    let mut places = free.to_vec();
    places.resize(problem.unknowns(), 0.5);
    places
}

/// The starts that could be simulated, in the order in which they are followed. Those without a better one near them
/// come first: they lead to different minima, while the best of all may all lead to the same. Near is what multi-level
/// single linkage calls so (Rinnooy Kan & Timmer 1987, Stochastic global optimization methods II, Mathematical
/// Programming 39, 57-78, equation 3 with sigma = 2). Among each kind the best come first.
fn order(starts: &[Vec<f64>], screened: &[Option<f64>]) -> Vec<usize> {
    let mut ranked: Vec<(usize, f64)> =
        screened.iter().enumerate().filter_map(|(i, cost)| Some((i, (*cost)?))).collect();
    ranked.sort_by(|a, b| a.1.total_cmp(&b.1));
    let near = linkage(ranked.len(), starts.first().map_or(0, Vec::len));
    let square = |a: usize, b: usize| -> f64 { starts[a].iter().zip(&starts[b]).map(|(a, b)| (a - b).powi(2)).sum() };
    let leads = |place: usize| {
        let mut better = ranked[..place].iter();
        better.all(|&(other, _)| square(ranked[place].0, other) > near * near)
    };
    let places = 0..ranked.len();
    let (first, later): (Vec<usize>, Vec<usize>) = places.partition(|&place| leads(place));
    first.into_iter().chain(later).map(|place| ranked[place].0).collect()
}

/// The critical distance of multi-level single linkage in the unit cube.
fn linkage(starts: usize, dimensions: usize) -> f64 {
    const SIGMA: f64 = 2.0;
    let (n, d) = (starts.max(1) as f64, dimensions.max(1) as f64);
    let part = SIGMA * n.ln() / n;
    ((ln_gamma(1.0 + 0.5 * d) + part.ln()) / d).exp() / std::f64::consts::PI.sqrt()
}
