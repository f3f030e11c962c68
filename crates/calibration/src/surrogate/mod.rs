//! Gaussian processes in place of a model whose runs are dear.
//!
//! The model is run at places that are spread evenly between the bounds, and a Gaussian process is fitted to each measured value
//! (`run-budget`). The posterior is sampled on the processes; the next runs are their optimum and places of that sample at which
//! they know least; new processes are fitted to the runs in its box, and so on, until their error matters little or the runs are
//! spent (Li & Marzouk 2014, Adaptive construction of surrogates for the Bayesian solution of inverse problems, SIAM J. Sci.
//! Comput. 36, A1163-A1186).
//!
//! The error of a process counts as one more uncertainty of the measured value: its deviation at places of the sample, larger
//! where fresh runs missed it by more than it said. Errors of several values go together where the processes miss the same bend;
//! independent ones that are as large in every direction are larger by the root of the largest eigenvalue of their correlations.
//! A region is left only where errors of this size cannot bring the posterior back to it.

mod components;
mod fitted;
pub mod outcome;
#[cfg(test)]
mod tests;
pub mod text;

use super::{
    failures::Failures,
    objective::{Misfit, Objective},
    problem::{NoPrediction, Problem, Simulate},
    rounds::{self, searched},
    sample::{FEWEST, Settings, places},
    search::SearchError,
};
pub use fitted::Surrogates;
use fitted::{Bounds, Run};
use outcome::SurrogateOutcome;
use run_budget::most_open;

/// Places of a batch.
const BATCH: usize = 8;

/// Errors that widen no accuracy by more than this part, and sums of squares that differ by no more than `ALIKE` at a batch of
/// fresh runs, are small enough.
const SMALL: f64 = 0.01;
const ALIKE: f64 = 0.2;

/// When this part of the places is spent and an error is still larger than `ROUGH` accuracies, the rest is better spent without
/// surrogates.
const PATIENCE: f64 = 0.6;
const ROUGH: f64 = 2.0;

/// How far the box of the next surrogates goes beyond the sample's, as a part of its width on both sides.
const BEYOND: f64 = 0.5;

/// Places of the sample among which the next ones are chosen.
const CANDIDATES: usize = 200;

/// Particles of a sample as the answer has it, or larger.
const LOOK: u64 = 2000;

/// The problem that surrogates are made for.
#[derive(Clone, Copy)]
pub struct Task<'a> {
    /// The search that they serve; its local searches begin at the same places.
    pub search: rounds::Task<'a>,
    /// Places at which the model was run before, and answers without a run.
    pub known: &'a [Vec<f64>],
    /// Further places at which it is run with all cases.
    pub places: usize,
    /// So many places that are spread evenly.
    pub spread: &'a dyn Fn(usize) -> Vec<Vec<f64>>,
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
    /// The unknowns of the run with the least sum of squares.
    pub best: Vec<f64>,
}

/// The fewest places from which surrogates can be made and tested, where so many are known; none where these are enough.
pub fn fewest(problem: &Problem, known: usize) -> usize {
    match first(problem).saturating_sub(known) {
        0 => 0,
        missing => missing + BATCH / 2,
    }
}

/// The first places.
fn first(problem: &Problem) -> usize {
    let inputs = problem.free.len() + problem.latents.len();
    (run_budget::LEAST + 2).max(4 * inputs)
}

/// Makes surrogates of a model.
///
/// # Errors
/// When so many runs failed that there is nothing to fit, or those of the search and of the sample.
pub fn replaced(task: &Task, model: &dyn Simulate, observe: &dyn Fn(String)) -> Result<Replaced, SearchError> {
    let rounds::Task { problem, difference, .. } = task.search;
    let mut work = Work {
        task,
        model: Objective::new(problem, model, difference),
        runs: Vec::new(),
        costs: Vec::new(),
        surrogates: Surrogates::new(problem),
        fresh: Fresh::default(),
    };
    let even = (task.spread)(task.places);
    work.run(task.known)?;
    let mut taken = first(problem).saturating_sub(task.known.len()).min(even.len());
    work.run(&even[..taken])?;
    let whole: Bounds = vec![[0.0, 1.0]; problem.unknowns()];
    // Where many runs fail, the first places leave too few.
    while work.surrogates.refine(&work.runs, whole.clone(), task.seed).is_err() {
        let next = (taken + BATCH).min(even.len());
        if next == taken {
            return Err(work.too_few());
        }
        work.run(&even[taken..next])?;
        taken = next;
    }
    let screened: Vec<bool> = work.runs.iter().map(|run| run.predicted.is_ok()).collect();
    let mut particles: Vec<Vec<f64>> = work.runs.iter().map(|run| run.places.clone()).collect();
    let most = task.known.len() + task.places;
    let mut rounds = 0;
    loop {
        rounds += 1;
        observe(format!("surrogate of round {rounds}, {} places", work.runs.len()));
        let (best, sampled) = work.sample(&work.errors(&particles), (rounds, FEWEST))?;
        particles = evenly(&sampled, CANDIDATES);
        let errors = work.errors(&particles);
        let widening = work.parts(&errors).fold(0.0, |most: f64, part| most.max(1.0_f64.hypot(part) - 1.0));
        let rough = work.parts(&errors).any(|part| part > ROUGH);
        // A direct search with fewer places would come nowhere.
        let fresh = work.runs.len() - task.known.len();
        let spent =
            fresh as f64 >= PATIENCE * task.places as f64 && fresh + 3 * (problem.unknowns() + 1) <= task.places;
        let is_enough = widening < SMALL && work.fresh.apart < ALIKE;
        if is_enough || rough && spent || work.runs.len() >= most {
            work.look_beyond(&errors, most)?;
            let counts = (rounds, [work.runs.len(), task.known.len()], work.model.failures().failed);
            let told =
                SurrogateOutcome::new(problem, &work.surrogates, counts, (&errors, &work.fresh), !(rough && spent));
            let least = (0..work.runs.len()).min_by(|a, b| work.costs[*a].total_cmp(&work.costs[*b]));
            return Ok(Replaced {
                problem: problem.widened(|case, quantity| errors[case][quantity]),
                failures: work.model.failures(),
                screened,
                best: least.map_or(best, |least| work.runs[least].places.clone()),
                model: work.surrogates,
                told,
            });
        }
        let places = work.next(best, &particles);
        work.test(&places)?;
        // Where nothing fits, the surrogates before it stay.
        let _ = work.surrogates.refine(&work.runs, around(&particles), task.seed);
    }
}

/// What a batch of runs said that no surrogate had seen.
pub(crate) struct Fresh {
    /// How many were compared.
    pub compared: usize,
    /// How many failed though they were expected to end.
    pub failed: usize,
    /// Errors over the deviations stated for them, root mean square.
    pub missed: f64,
    /// By how much the sums of squares of surrogates and model differ, in the middle.
    pub apart: f64,
}

impl Default for Fresh {
    fn default() -> Self {
        Self { compared: 0, failed: 0, missed: 1.0, apart: f64::INFINITY }
    }
}

/// Surrogates that are being made.
struct Work<'a> {
    task: &'a Task<'a>,
    model: Objective<'a>,
    runs: Vec<Run>,
    /// Their sums of squares; infinite where one failed.
    costs: Vec<f64>,
    surrogates: Surrogates,
    fresh: Fresh,
}

impl Work<'_> {
    /// Runs the model with all cases at these places.
    fn run(&mut self, places: &[Vec<f64>]) -> Result<(), NoPrediction> {
        for (places, misfit) in places.iter().zip(self.model.misfits(places)?) {
            // Values that overflow when they are squared would leave nothing of a fit.
            let misfit = misfit.and_then(|misfit| match misfit.cost() {
                cost if cost.is_finite() => Ok(misfit),
                cost => Err(format!("the sum of squares is {cost}")),
            });
            self.costs.push(misfit.as_ref().map_or(f64::INFINITY, Misfit::cost));
            self.runs.push(Run { places: places.clone(), predicted: misfit.map(|misfit| misfit.predicted) });
        }
        Ok(())
    }

    /// Runs places, and compares them with what the surrogates say before they know them.
    fn test(&mut self, places: &[Vec<f64>]) -> Result<(), NoPrediction> {
        let problem = self.model.problem;
        let before = self.runs.len();
        self.run(places)?;
        let ours = Objective::new(problem, &self.surrogates, f64::NAN).misfits(places)?;
        let cases = 0..problem.cases.len();
        let variances: Vec<_> = cases.map(|case| self.surrogates.variances(case, places)).collect();
        let (mut scores, mut apart) = (Vec::new(), Vec::new());
        let mut fresh = Fresh::default();
        for (i, ours) in ours.iter().enumerate() {
            let (Ok(ours), theirs) = (ours, &self.runs[before + i]) else { continue };
            let Ok(theirs) = &theirs.predicted else {
                fresh.failed += 1;
                continue;
            };
            fresh.compared += 1;
            apart.push((ours.cost() - self.costs[before + i]).abs());
            for (case, measured) in problem.cases.iter().map(|case| &case.measured).enumerate() {
                for (q, measured) in measured.iter().enumerate() {
                    let error = (ours.predicted[case][q] - theirs[case][q]) / measured.accuracy;
                    // An error that is nothing beside the accuracy says nothing about its statement.
                    scores.push(error * error / variances[case][(i, q)].max(1e-6));
                }
            }
        }
        apart.sort_by(f64::total_cmp);
        if let Some(middle) = apart.get(apart.len() / 2) {
            fresh.apart = *middle;
            fresh.missed = (scores.iter().sum::<f64>() / scores.len() as f64).sqrt();
        }
        self.fresh = fresh;
        Ok(())
    }

    fn too_few(&self) -> SearchError {
        let ended = self.runs.iter().filter(|run| run.predicted.is_ok()).count();
        let mut failed = self.runs.iter().filter_map(|run| run.predicted.as_ref().err());
        let last =
            failed.next_back().map_or_else(String::new, |reason| format!("; the last one failed with: {reason}"));
        SearchError::Surrogate(format!(
            "the first {} places leave {ended} to fit a surrogate to, which is too few{last}",
            self.runs.len()
        ))
    }

    /// The errors that are counted, by case and quantity, where the posterior has these places.
    fn errors(&self, particles: &[Vec<f64>]) -> Vec<Vec<f64>> {
        let problem = self.model.problem;
        let factor = self.surrogates.last().error_correlation.sqrt() * self.fresh.missed.max(1.0);
        let case = |case: usize| {
            let variances = self.surrogates.variances(case, particles).row_mean();
            let measured = problem.cases[case].measured.iter();
            measured.zip(&variances).map(|(measured, variance)| factor * variance.sqrt() * measured.accuracy).collect()
        };
        (0..problem.cases.len()).map(case).collect()
    }

    /// Errors over accuracies.
    fn parts<'b>(&'b self, errors: &'b [Vec<f64>]) -> impl Iterator<Item = f64> + 'b {
        let measured = self.model.problem.cases.iter().flat_map(|case| &case.measured);
        errors.iter().flatten().zip(measured).map(|(error, measured)| error / measured.accuracy)
    }

    /// The optimum by the surrogates, and places of the posterior, with these errors. Round 0 only looks where it has something.
    fn sample(
        &self,
        errors: &[Vec<f64>],
        (round, least): (usize, u64),
    ) -> Result<(Vec<f64>, Vec<Vec<f64>>), SearchError> {
        let problem = self.model.problem.widened(|case, quantity| errors[case][quantity]);
        let search = rounds::Task { problem: &problem, ..self.task.search };
        let searched = searched(&search, &self.surrogates, &|_| ())?;
        let unknowns = problem.unknowns() as u64;
        let settings =
            Settings { particles: least.max(20 * unknowns), seed: self.task.seed.wrapping_add(round as u64) };
        let objective = Objective::new(&problem, &self.surrogates, search.difference);
        let mut places = places(&objective, &searched.optima, &settings, round > 0)?;
        places.iter_mut().for_each(|places| places.truncate(problem.unknowns()));
        Ok((searched.optima[0].minimum.places.clone(), places))
    }

    /// Runs those places of a large sample that lie beyond the last box, as long as there are some and runs are left:
    /// only the rough surrogates around it know of them, and a hundredth of the sample that is wrong far off doubles its deviation.
    fn look_beyond(&mut self, errors: &[Vec<f64>], most: usize) -> Result<(), SearchError> {
        while self.runs.len() < most {
            let (_, mut places) = self.sample(errors, (0, LOOK))?;
            places.retain(|places| !self.surrogates.last().holds(places));
            if places.is_empty() {
                break;
            }
            self.run(&evenly(&places, BATCH.min(most - self.runs.len())))?;
            self.surrogates.refit(&self.runs, self.task.seed);
        }
        Ok(())
    }

    /// The next places: the best one, and those of the sample that tell most.
    fn next(&self, best: Vec<f64>, particles: &[Vec<f64>]) -> Vec<Vec<f64>> {
        let count = BATCH.min(self.task.known.len() + self.task.places - self.runs.len());
        let cases = self.surrogates.last().cases.iter().enumerate();
        let of: Vec<_> =
            cases.map(|(number, case)| (&case.surrogate, self.surrogates.points(number, particles))).collect();
        let chosen = most_open(&of, count).into_iter().map(|index| particles[index].clone());
        let fresh = |places: &Vec<f64>| self.runs.iter().all(|run| run.places != *places);
        std::iter::once(best).chain(chosen).filter(fresh).take(count).collect()
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
