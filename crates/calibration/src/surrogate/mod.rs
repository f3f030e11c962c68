//! Surrogates in place of the model, where its runs are dear.
//!
//! The model is run at places that are spread evenly between the bounds, and a polynomial is fitted to each measured value
//! (the same as in `robustness`). The posterior is sampled on the polynomials; the next runs go where that sample is, half
//! of them spread evenly over its box and half at particles; new polynomials are fitted to the runs in that box, and so
//! on, until their error matters little or the runs are spent (Li & Marzouk 2014, Adaptive construction of surrogates for
//! the Bayesian solution of inverse problems, SIAM J. Sci. Comput. 36, A1163-A1186).
//!
//! The error of a polynomial counts as one more uncertainty of the measured value. It is the larger one of the
//! leave-one-out error and of the error at fresh runs, at particles that no polynomial has seen. Errors of several values
//! go together where the polynomials miss the same bend; independent ones that are as large in every direction are larger
//! by the root of the largest eigenvalue of their correlations.
//!
//! A region is left for good only where even the largest error of any run cannot bring the posterior back to it.

mod fitted;
pub mod outcome;
#[cfg(test)]
mod tests;
pub mod text;

use super::failures::Failures;
use super::local::is_over;
use super::objective::Objective;
use super::problem::{NoPrediction, Problem, Simulate};
use super::rounds::{self, searched};
use super::sample::{FEWEST, Settings, sample};
use super::search::SearchError;
pub use fitted::Surrogates;
use fitted::{Bounds, Run};
use outcome::SurrogateOutcome;

/// The first runs' part of all.
const FIRST: f64 = 0.4;

/// The part of all runs that checks the surrogates.
const CHECK: f64 = 0.15;

/// The most rounds after the first.
const ROUNDS: usize = 4;

/// An error of the surrogates that widens no interval by more than this part is small enough.
const SMALL: f64 = 0.01;

/// How far the box of the next runs goes beyond the sample's, as a part of its width on both sides.
const BEYOND: f64 = 0.25;

/// The problem that surrogates are made for.
#[derive(Clone, Copy)]
pub struct Task<'a> {
    /// The search that they serve; its local searches begin at the same places.
    pub search: rounds::Task<'a>,
    /// The most places at which the model is run.
    pub runs: usize,
    /// Places that are spread evenly: those of the first runs, then of each round.
    pub spread: &'a dyn Fn(usize, u64) -> Vec<Vec<f64>>,
    /// The seed of samples.
    pub seed: u64,
}

/// The surrogates, and the problem that counts their error.
pub struct Replaced {
    /// In place of the model.
    pub model: Surrogates,
    /// The problem, with accuracies that include the surrogates' errors.
    pub problem: Problem,
    /// Their results, for the reader.
    pub told: SurrogateOutcome,
    /// The places at which runs failed.
    pub failures: Failures,
    /// Of each of the first places, whether its runs ended.
    pub screened: Vec<bool>,
}

/// The fewest places from which surrogates of so many parameters can be made: the first ones allow a polynomial of degree 1.
pub fn fewest(problem: &Problem) -> u64 {
    let inputs = problem.free.len() + problem.latents.len();
    10 * (inputs as u64 + 1)
}

/// Makes surrogates of a model.
///
/// # Errors
/// When so many runs failed that there is nothing to fit, or those of the search and of the sample.
pub fn replaced(task: &Task<'_>, model: &dyn Simulate, observe: &dyn Fn(String)) -> Result<Replaced, SearchError> {
    let rounds::Task { problem, difference, effort, .. } = task.search;
    let mut work = Work {
        task,
        model: Objective::new(problem, model, difference),
        runs: Vec::new(),
        surrogates: Surrogates::new(problem),
    };
    let check = (task.runs as f64 * CHECK).ceil() as usize;
    let first = (task.runs as f64 * FIRST).ceil() as usize;
    let each = (task.runs - first - check).div_ceil(ROUNDS);
    work.run(&(task.spread)(first, 0))?;
    let screened: Vec<bool> = work.runs.iter().map(|run| run.predicted.is_ok()).collect();
    let whole = vec![[0.0, 1.0]; problem.unknowns()];
    if !work.surrogates.refine(&work.runs, whole) {
        return Err(work.too_few());
    }
    let mut rounds = 1;
    // Where runs fail, only nearer ones tell where that begins.
    while (work.widening(RMS) > SMALL || work.model.failures().failed > 0)
        && work.runs.len() + check < task.runs
        && !is_over(effort.deadline)
    {
        observe(format!("surrogate of round {rounds}, {} runs a case", work.runs.len()));
        let particles = work.sample(LARGEST, rounds as u64)?;
        let region = around(&particles);
        let room = task.runs - check - work.runs.len();
        let places = work.next(&particles, &region, each.min(room), rounds as u64);
        work.run(&places)?;
        if !work.surrogates.refine(&work.runs, region) {
            break;
        }
        rounds += 1;
    }
    observe(format!("surrogate of round {rounds}, checked at {check} particles"));
    let particles = work.sample(RMS, rounds as u64)?;
    let places = evenly(&particles, check);
    let checked = work.check(&places)?;
    let failures = work.model.failures();
    let counts = (rounds, work.runs.len() + check, failures.failed);
    let mut told = SurrogateOutcome::new(problem, &work.surrogates, counts, &checked);
    told.check_failed = places.len() - checked.len();
    Ok(Replaced { problem: told.widened(problem), model: work.surrogates, told, failures, screened })
}

/// Which of two errors is counted.
const RMS: usize = 0;
const LARGEST: usize = 1;

/// Surrogates that are being made.
struct Work<'a> {
    task: &'a Task<'a>,
    model: Objective<'a>,
    runs: Vec<Run>,
    surrogates: Surrogates,
}

impl Work<'_> {
    /// Runs the model with all cases at these places.
    fn asked(&self, places: &[Vec<f64>]) -> Result<Vec<Run>, NoPrediction> {
        let misfits = self.model.misfits(places)?;
        let runs = places
            .iter()
            .zip(misfits)
            .map(|(places, misfit)| Run { places: places.clone(), predicted: misfit.map(|misfit| misfit.predicted) });
        Ok(runs.collect())
    }

    fn run(&mut self, places: &[Vec<f64>]) -> Result<(), NoPrediction> {
        self.runs.extend(self.asked(places)?);
        Ok(())
    }

    fn too_few(&self) -> SearchError {
        let ended = self.runs.iter().filter(|run| run.predicted.is_ok()).count();
        let mut failed = self.runs.iter().filter_map(|run| run.predicted.as_ref().err());
        let last =
            failed.next_back().map_or_else(String::new, |reason| format!("; the last one failed with: {reason}"));
        SearchError::Surrogate(format!(
            "the first {} runs a case leave {ended} to fit a surrogate to, which is too few: give more with --surrogate{last}",
            self.runs.len()
        ))
    }

    /// Accuracies with one of the errors of the last surrogates.
    fn widened(&self, which: usize) -> Problem {
        let layer = self.surrogates.last();
        let (errors, factor) = (layer.errors(), layer.together.sqrt());
        let problem = self.model.problem;
        problem.widened(|case, quantity| factor * errors[case][quantity][which])
    }

    /// By which part the errors widen the accuracy of any value, at most.
    fn widening(&self, which: usize) -> f64 {
        let widened = self.widened(which);
        let pairs = self.model.problem.cases.iter().zip(&widened.cases);
        let pairs = pairs.flat_map(|(a, b)| a.measured.iter().zip(&b.measured));
        pairs.map(|(a, b)| b.accuracy / a.accuracy - 1.0).fold(0.0, f64::max)
    }

    /// Particles of the posterior by the surrogates, with one of their errors.
    fn sample(&self, which: usize, round: u64) -> Result<Vec<Vec<f64>>, SearchError> {
        let problem = self.widened(which);
        let search = rounds::Task { problem: &problem, ..self.task.search };
        let searched = searched(&search, &self.surrogates, &|_| ())?;
        let unknowns = problem.unknowns() as u64;
        let settings = Settings {
            particles: FEWEST.max(20 * unknowns),
            seed: self.task.seed.wrapping_add(round),
            deadline: search.effort.deadline,
        };
        let objective = Objective::new(&problem, &self.surrogates, search.difference);
        let sample = sample(&objective, &searched.optima, &settings, &|_, _| ())?;
        let particles = sample.particles.into_iter();
        let places = particles.map(|mut particle| {
            particle.places.truncate(problem.unknowns());
            particle.places
        });
        Ok(places.collect())
    }

    /// The next places: half of them spread over the box, half at particles.
    fn next(&self, particles: &[Vec<f64>], region: &Bounds, count: usize, round: u64) -> Vec<Vec<f64>> {
        let spread = (self.task.spread)(count.div_ceil(2), round);
        let inside = |places: &Vec<f64>| -> Vec<f64> {
            let pairs = places.iter().zip(region);
            pairs.map(|(place, [low, high])| low + place * (high - low)).collect()
        };
        let mut places: Vec<Vec<f64>> = spread.iter().map(inside).collect();
        places.extend(evenly(particles, count / 2));
        places
    }

    /// The surrogates' errors at places that they have not seen: a row each, with the values case by case. Places at which
    /// the model's runs fail are left out.
    fn check(&self, places: &[Vec<f64>]) -> Result<Vec<Vec<f64>>, NoPrediction> {
        let runs = self.asked(places)?;
        let rounds::Task { problem, difference, .. } = self.task.search;
        let ours = Objective::new(problem, &self.surrogates, difference).misfits(places)?;
        let pairs = runs.iter().zip(ours);
        let errors = pairs.filter_map(|(run, ours)| {
            let theirs = run.predicted.as_ref().ok()?.iter().flatten();
            let ours = ours.ok()?;
            let ours = ours.predicted.iter().flatten();
            Some(ours.zip(theirs).map(|(ours, theirs)| ours - theirs).collect())
        });
        Ok(errors.collect())
    }
}

/// The box of a sample, and some room around it.
fn around(particles: &[Vec<f64>]) -> Bounds {
    let unknowns = particles.first().map_or(0, Vec::len);
    let side = |k: usize| {
        let places = particles.iter().map(|particle| particle[k]);
        let low = places.clone().fold(f64::INFINITY, f64::min);
        let high = places.fold(f64::NEG_INFINITY, f64::max);
        let room = BEYOND * (high - low);
        [(low - room).max(0.0), (high + room).min(1.0)]
    };
    (0..unknowns).map(side).collect()
}

/// So many particles, every k-th of them.
fn evenly(particles: &[Vec<f64>], count: usize) -> Vec<Vec<f64>> {
    let count = count.min(particles.len());
    let at = |k: usize| particles[(2 * k + 1) * particles.len() / (2 * count)].clone();
    (0..count).map(at).collect()
}
