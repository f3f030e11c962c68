//! The posterior that is sampled: the prior between the bounds, and the likelihood of the measured values.

use std::cell::Cell;

use sampling::random::Random;
use statrs::distribution::{ContinuousCDF, Normal};

use super::super::discrepancy::Unknown;
use super::super::local::Minimum;
use super::super::objective::{Misfit, Objective};
use super::super::problem::NoPrediction;

/// The prior of one unknown's place: uniform from 0 to 1, or normal and cut there.
#[derive(Clone, Copy, Debug)]
enum Before {
    Uniform,
    /// Mean, deviation, and the parts of the distribution below the lower and the upper bound.
    Normal {
        mean: f64,
        deviation: f64,
        below: f64,
        above: f64,
    },
}

impl Before {
    fn new(prior: Option<(f64, f64)>) -> Self {
        let Some((mean, deviation)) = prior else {
            return Self::Uniform;
        };
        let part = |bound: f64| Normal::standard().cdf((bound - mean) / deviation);
        Self::Normal {
            mean,
            deviation,
            below: part(0.0),
            above: part(1.0),
        }
    }

    fn log_density(self, place: f64) -> f64 {
        match self {
            _ if !(0.0..=1.0).contains(&place) => f64::NEG_INFINITY,
            Self::Uniform => 0.0,
            Self::Normal {
                mean,
                deviation,
                below,
                above,
            } => {
                let squares = ((place - mean) / deviation).powi(2);
                -0.5 * (squares + std::f64::consts::TAU.ln()) - (deviation * (above - below)).ln()
            }
        }
    }

    fn quantile(self, level: f64) -> f64 {
        match self {
            Self::Uniform => level,
            Self::Normal {
                mean,
                deviation,
                below,
                above,
            } => {
                let level = below + level * (above - below);
                (mean + deviation * Normal::standard().inverse_cdf(level)).clamp(0.0, 1.0)
            }
        }
    }
}

/// The posterior that is sampled.
pub(super) struct Target<'a> {
    objective: &'a Objective<'a>,
    before: Vec<Before>,
    /// Quantities with an unknown discrepancy, whose places stand behind all others.
    discrepancies: Vec<Unknown>,
    /// The logarithm of the likelihood where every prediction is what was measured.
    best: f64,
    /// Places of which the likelihood was asked.
    evaluated: Cell<u64>,
    /// Those of which a run failed.
    failed: Cell<u64>,
}

impl<'a> Target<'a> {
    pub(super) fn new(objective: &'a Objective<'a>, discrepancies: Vec<Unknown>) -> Self {
        let problem = objective.problem;
        let free = problem.free.iter().map(|free| free.prior_place());
        let latents = problem.cases.len() * problem.latents.len();
        let others = std::iter::repeat_n(None, latents + discrepancies.len());
        let before = free.chain(others);
        let measured = problem.cases.iter().flat_map(|case| &case.measured);
        let peak = |accuracy: f64| -accuracy.ln() - 0.5 * std::f64::consts::TAU.ln();
        Self {
            objective,
            before: before.map(Before::new).collect(),
            discrepancies,
            best: measured.map(|measured| peak(measured.accuracy)).sum(),
            evaluated: Cell::new(0),
            failed: Cell::new(0),
        }
    }

    /// How many unknowns there are.
    pub(super) fn unknowns(&self) -> usize {
        self.before.len()
    }

    /// Places of which the likelihood was asked, and those of which a run failed.
    pub(super) fn counts(&self) -> (u64, u64) {
        (self.evaluated.get(), self.failed.get())
    }

    /// A place from the prior.
    pub(super) fn draw(&self, random: &mut Random) -> Vec<f64> {
        let before = self.before.iter();
        before
            .map(|before| before.quantile(random.unit()))
            .collect()
    }

    /// The logarithm of the prior density: minus infinity outside of the bounds.
    pub(super) fn log_prior(&self, places: &[f64]) -> f64 {
        let pairs = self.before.iter().zip(places);
        pairs
            .map(|(before, &place)| before.log_density(place))
            .sum()
    }

    /// The logarithms of the likelihood, all in one batch of runs: minus infinity outside of the bounds, where nothing
    /// is run, and where a run failed.
    ///
    /// # Errors
    /// When there are no further predictions.
    pub(super) fn log_likelihoods(&self, sets: &[Vec<f64>]) -> Result<Vec<f64>, NoPrediction> {
        let inside: Vec<usize> = (0..sets.len())
            .filter(|&index| self.log_prior(&sets[index]).is_finite())
            .collect();
        let asked: Vec<&[f64]> = inside.iter().map(|&index| &sets[index][..]).collect();
        let misfits = self.objective.misfits(&asked)?;
        let mut likelihoods = vec![f64::NEG_INFINITY; sets.len()];
        for (&index, misfit) in inside.iter().zip(misfits) {
            self.evaluated.set(self.evaluated.get() + 1);
            match misfit {
                Ok(misfit) => {
                    likelihoods[index] = self.log_likelihood(&sets[index], &misfit);
                }
                Err(_) => self.failed.set(self.failed.get() + 1),
            }
        }
        Ok(likelihoods)
    }

    /// The logarithm of prior and likelihood at a minimum.
    pub(super) fn log_density(&self, minimum: &Minimum) -> f64 {
        self.log_prior(&minimum.places) + self.log_likelihood(&minimum.places, &minimum.misfit)
    }

    fn log_likelihood(&self, places: &[f64], misfit: &Misfit) -> f64 {
        let values = self.objective.problem.values();
        let mut log = self.best - 0.5 * misfit.residuals.rows(0, values).norm_squared();
        let problem = self.objective.problem;
        let places = places.iter().skip(problem.unknowns());
        for (unknown, &place) in self.discrepancies.iter().zip(places) {
            let at = |deviation| unknown.log_likelihood(problem, &misfit.predicted, deviation);
            log += at(unknown.deviation(place)) - at(0.0);
        }
        if log.is_nan() { f64::NEG_INFINITY } else { log }
    }
}
