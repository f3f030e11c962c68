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

use std::time::Instant;

use super::discrepancy::Unknown;
use super::failures::Failures;
use super::objective::Objective;
use super::problem::{NoPrediction, Problem, Query, Simulate};
use super::rounds::{self, searched};
use super::sample::{FEWEST, SampleError, Settings, sample};
use super::search::{Effort, SearchError};
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

/// What surrogates are made for.
#[derive(Clone, Copy)]
pub struct Task<'a> {
    /// The problem.
    pub problem: &'a Problem,
    /// Quantities whose discrepancy is unknown.
    pub unknown: &'a [Unknown],
    /// The most places at which the model is run.
    pub runs: usize,
    /// Places that are spread evenly: those of the first runs, then of each round.
    pub spread: &'a dyn Fn(usize, u64) -> Vec<Vec<f64>>,
    /// Where local searches on the surrogates begin.
    pub starts: &'a [Vec<f64>],
    /// The distance of simulations for a derivative.
    pub difference: f64,
    /// How hard to search.
    pub effort: Effort,
    /// The seed of samples.
    pub seed: u64,
}

/// The surrogates, and the problem that counts their error.
pub struct Replaced {
    /// In place of the model.
    pub model: Surrogates,
    /// The problem, with accuracies that include the surrogates' errors.
    pub problem: Problem,
    /// What is to be said of them.
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
pub fn replaced(
    task: &Task<'_>,
    model: &dyn Simulate,
    observe: &dyn Fn(String),
) -> Result<Replaced, SearchError> {
    let mut work = Work {
        task,
        model,
        runs: Vec::new(),
        failures: Failures::default(),
        surrogates: Surrogates::new(task.problem),
    };
    let check = (task.runs as f64 * CHECK).ceil() as usize;
    let first = (task.runs as f64 * FIRST).ceil() as usize;
    let each = (task.runs - first - check).div_ceil(ROUNDS);
    work.run((task.spread)(first, 0))?;
    let screened: Vec<bool> = work.runs.iter().map(|run| run.predicted.is_ok()).collect();
    let whole = vec![[0.0, 1.0]; task.problem.unknowns()];
    if !work.surrogates.refine(&work.runs, whole) {
        return Err(work.too_few());
    }
    let mut rounds = 1;
    // Where runs fail, only nearer ones tell where that begins.
    while (work.widening(RMS) > SMALL || work.failures.failed > 0)
        && work.runs.len() + check < task.runs
        && in_time(task)
    {
        observe(format!(
            "surrogate of round {rounds}, {} runs a case",
            work.runs.len()
        ));
        let particles = work.sample(LARGEST, rounds as u64)?;
        let region = around(&particles);
        let room = task.runs - check - work.runs.len();
        let places = work.next(&particles, &region, each.min(room), rounds as u64);
        work.run(places)?;
        if !work.surrogates.refine(&work.runs, region) {
            break;
        }
        rounds += 1;
    }
    observe(format!(
        "surrogate of round {rounds}, checked at {check} particles"
    ));
    let particles = work.sample(RMS, rounds as u64)?;
    let places = evenly(&particles, check);
    let checked = work.check(&places)?;
    let mut told = SurrogateOutcome::new(
        task.problem,
        &work.surrogates,
        (rounds, work.runs.len() + check, work.failures.failed),
        &checked,
    );
    told.check_failed = places.len() - checked.len();
    Ok(Replaced {
        problem: told.widened(task.problem),
        model: work.surrogates,
        told,
        failures: work.failures,
        screened,
    })
}

fn in_time(task: &Task<'_>) -> bool {
    let ends = task.effort.deadline;
    ends.is_none_or(|ends| Instant::now() < ends)
}

/// Which of two errors is counted.
const RMS: usize = 0;
const LARGEST: usize = 1;

/// Surrogates that are being made.
struct Work<'a> {
    task: &'a Task<'a>,
    model: &'a dyn Simulate,
    runs: Vec<Run>,
    failures: Failures,
    surrogates: Surrogates,
}

impl Work<'_> {
    /// Runs the model with all cases at these places.
    fn asked(&mut self, places: Vec<Vec<f64>>) -> Result<Vec<Run>, NoPrediction> {
        let problem = self.task.problem;
        let queries = places.iter().flat_map(|places| {
            (0..problem.cases.len()).map(move |case| Query {
                case,
                free: problem.free_values(places),
                latents: problem.latent_values(case, places),
            })
        });
        let predictions = self.model.simulate(&queries.collect::<Vec<_>>())?;
        let mut runs = Vec::with_capacity(places.len());
        for (places, own) in places
            .into_iter()
            .zip(predictions.chunks(problem.cases.len()))
        {
            let finite = |values: &Vec<f64>| match values.iter().find(|value| !value.is_finite()) {
                Some(value) => Err(format!("a prediction is {value}")),
                None => Ok(values.clone()),
            };
            let own = own.iter().map(|own| own.as_ref().map_err(Clone::clone));
            let predicted: Result<Vec<_>, String> = own.map(|own| own.and_then(finite)).collect();
            let reason = predicted.as_ref().err().map(String::as_str);
            self.failures.note(problem, &places, reason);
            runs.push(Run { places, predicted });
        }
        Ok(runs)
    }

    fn run(&mut self, places: Vec<Vec<f64>>) -> Result<(), NoPrediction> {
        let runs = self.asked(places)?;
        self.runs.extend(runs);
        Ok(())
    }

    fn too_few(&self) -> SearchError {
        let ended = self.runs.iter().filter(|run| run.predicted.is_ok()).count();
        let last = self
            .runs
            .iter()
            .rev()
            .find_map(|run| run.predicted.as_ref().err());
        let last = last.map_or_else(String::new, |reason| {
            format!("; the last one failed with: {reason}")
        });
        SearchError::Surrogate(format!(
            "the first {} runs a case leave {ended} to fit a surrogate to, which is too few: give more with --surrogate{last}",
            self.runs.len()
        ))
    }

    /// Accuracies with one of the errors of the last surrogates.
    fn widened(&self, which: usize) -> Problem {
        let mut problem = self.task.problem.clone();
        let layer = self.surrogates.last();
        for (case, errors) in problem.cases.iter_mut().zip(layer.errors()) {
            for (measured, error) in case.measured.iter_mut().zip(errors) {
                measured.accuracy = measured
                    .accuracy
                    .hypot(layer.together.sqrt() * error[which]);
            }
        }
        problem
    }

    /// By which part the errors widen the accuracy of any value, at most.
    fn widening(&self, which: usize) -> f64 {
        let widened = self.widened(which);
        let pairs = self.task.problem.cases.iter().zip(&widened.cases);
        let pairs = pairs.flat_map(|(a, b)| a.measured.iter().zip(&b.measured));
        pairs
            .map(|(a, b)| b.accuracy / a.accuracy - 1.0)
            .fold(0.0, f64::max)
    }

    /// Particles of the posterior by the surrogates, with one of their errors.
    fn sample(&self, which: usize, round: u64) -> Result<Vec<Vec<f64>>, SearchError> {
        let task = self.task;
        let problem = self.widened(which);
        let search = rounds::Task {
            problem: &problem,
            unknown: task.unknown,
            difference: task.difference,
            starts: task.starts,
            effort: task.effort,
        };
        let found = searched(&search, &self.surrogates, &|_| ())?;
        let deviations = found.discrepancies.iter().map(|own| own.deviation);
        let discrepancies: Vec<(Unknown, f64)> =
            task.unknown.iter().copied().zip(deviations).collect();
        let unknowns = (problem.unknowns() + task.unknown.len()) as u64;
        let settings = Settings {
            particles: FEWEST.max(20 * unknowns),
            seed: task.seed.wrapping_add(round),
            deadline: task.effort.deadline,
            discrepancies: &discrepancies,
        };
        let objective = Objective::new(&problem, &self.surrogates, task.difference);
        let sample = sample(&objective, &found.optima, &settings, &|_, _| ());
        let sample = sample.map_err(|error| match error {
            SampleError::Prediction(error) => SearchError::from(error),
            error => SearchError::Sample(error.to_string()),
        })?;
        let particles = sample.particles.into_iter();
        let own = particles.map(|mut own| {
            own.places.truncate(problem.unknowns());
            own.places
        });
        Ok(own.collect())
    }

    /// The next places: half of them spread over the box, half at particles.
    fn next(
        &self,
        particles: &[Vec<f64>],
        region: &Bounds,
        count: usize,
        round: u64,
    ) -> Vec<Vec<f64>> {
        let spread = (self.task.spread)(count.div_ceil(2), round);
        let inside = |places: &Vec<f64>| -> Vec<f64> {
            let pairs = places.iter().zip(region);
            pairs
                .map(|(place, [low, high])| low + place * (high - low))
                .collect()
        };
        let mut places: Vec<Vec<f64>> = spread.iter().map(inside).collect();
        places.extend(evenly(particles, count / 2));
        places
    }

    /// The surrogates' errors at places that they have not seen: a row each, with the values case by case. Places at which
    /// the model's runs fail are left out.
    fn check(&mut self, places: &[Vec<f64>]) -> Result<Vec<Vec<f64>>, NoPrediction> {
        let runs = self.asked(places.to_vec())?;
        let objective = Objective::new(self.task.problem, &self.surrogates, self.task.difference);
        let ours = objective.misfits(places)?;
        let pairs = runs.iter().zip(ours);
        let errors = pairs.filter_map(|(run, ours)| {
            let theirs = run.predicted.as_ref().ok()?.iter().flatten();
            let ours = ours.ok()?;
            let ours = ours.predicted.iter().flatten();
            Some(
                ours.zip(theirs)
                    .map(|(ours, theirs)| ours - theirs)
                    .collect(),
            )
        });
        Ok(errors.collect())
    }
}

/// The box of a sample, and some room around it.
fn around(particles: &[Vec<f64>]) -> Bounds {
    let unknowns = particles.first().map_or(0, Vec::len);
    let side = |k: usize| {
        let places = particles.iter().map(|own| own[k]);
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
