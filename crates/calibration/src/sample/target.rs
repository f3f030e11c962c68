//! The posterior that is sampled: the prior between the bounds, and the likelihood of the measured values.

use sampling::distribution::Distribution;
use sampling::random::Random;

use super::super::discrepancy::{Unknown, of_quantity};
use super::super::errors::Errors;
use super::super::local::Minimum;
use super::super::objective::{Misfit, Objective};
use super::super::problem::NoPrediction;

/// The posterior that is sampled.
pub(super) struct Target<'a> {
    pub(super) objective: &'a Objective<'a>,
    /// The prior of each unknown's place: uniform from 0 to 1, or normal and cut there.
    pub(super) before: Vec<Distribution>,
    /// Quantities with an unknown discrepancy, whose places stand behind all others.
    discrepancies: Vec<Unknown>,
}

/// How probable the measured values are at a place.
#[derive(Clone, Debug)]
pub(super) struct Likelihood {
    /// The logarithm of their density.
    pub(super) log: f64,
    /// Mean and standard deviation of each channel's shared error there.
    pub(super) shared: Vec<[f64; 2]>,
}

impl Likelihood {
    /// That of a place that is impossible, or at which nothing is known.
    fn none() -> Self {
        Self {
            log: f64::NEG_INFINITY,
            shared: Vec::new(),
        }
    }
}

impl<'a> Target<'a> {
    pub(super) fn new(objective: &'a Objective<'a>, discrepancies: Vec<Unknown>) -> Self {
        let problem = objective.problem;
        let free = problem.free.iter().map(|free| before(free.prior_place()));
        let others = problem.unknowns() - problem.free.len() + discrepancies.len();
        let before = free.chain(std::iter::repeat_n(before(None), others));
        Self {
            objective,
            before: before.collect(),
            discrepancies,
        }
    }

    /// A place from the prior.
    pub(super) fn draw(&self, random: &mut Random) -> Vec<f64> {
        let before = self.before.iter();
        before
            .map(|distribution| distribution.quantile(random.unit()))
            .collect()
    }

    /// The logarithm of the prior density: minus infinity outside of the bounds.
    pub(super) fn log_prior(&self, places: &[f64]) -> f64 {
        let pairs = self.before.iter().zip(places);
        pairs
            .map(|(distribution, &place)| distribution.ln_density(place))
            .sum()
    }

    /// The likelihoods, all in one batch of runs: none outside of the bounds, where nothing is run, and where a run failed.
    ///
    /// # Errors
    /// When there are no further predictions.
    pub(super) fn likelihoods(&self, sets: &[Vec<f64>]) -> Result<Vec<Likelihood>, NoPrediction> {
        let inside: Vec<usize> = (0..sets.len())
            .filter(|&index| self.log_prior(&sets[index]).is_finite())
            .collect();
        let asked: Vec<&[f64]> = inside.iter().map(|&index| &sets[index][..]).collect();
        let misfits = self.objective.misfits(&asked)?;
        let mut likelihoods = vec![Likelihood::none(); sets.len()];
        for (&index, misfit) in inside.iter().zip(misfits) {
            if let Ok(misfit) = misfit {
                likelihoods[index] = self.likelihood(&sets[index], &misfit);
            }
        }
        Ok(likelihoods)
    }

    /// The logarithm of prior and likelihood at a minimum.
    pub(super) fn log_density(&self, minimum: &Minimum) -> f64 {
        self.log_prior(&minimum.places) + self.likelihood(&minimum.places, &minimum.misfit).log
    }

    fn likelihood(&self, places: &[f64], misfit: &Misfit) -> Likelihood {
        let problem = self.objective.problem;
        let at = |errors: &Errors, squares: f64, sources: &[f64]| Likelihood {
            log: errors.log_density(squares),
            shared: errors.channels(problem, sources),
        };
        let likelihood = match self.discrepancies.is_empty() {
            true => {
                let errors = &self.objective.errors;
                at(errors, misfit.data_cost(problem), misfit.sources(problem))
            }
            false => {
                let places = places.iter().skip(problem.unknowns());
                let pairs = self.discrepancies.iter().zip(places);
                let deviations: Vec<f64> = pairs
                    .map(|(unknown, &place)| unknown.deviation(place))
                    .collect();
                let errors = Errors::with(problem, |_, quantity| {
                    of_quantity(&self.discrepancies, &deviations, quantity)
                });
                let residuals = errors.residuals(problem, &misfit.predicted);
                let sources = &residuals.as_slice()[problem.values()..];
                at(&errors, residuals.norm_squared(), sources)
            }
        };
        match likelihood.log.is_nan() {
            true => Likelihood::none(),
            false => likelihood,
        }
    }
}

/// The prior of a place, given its centre and deviation where there are any.
fn before(prior: Option<(f64, f64)>) -> Distribution {
    let [min, max] = [0.0, 1.0];
    match prior {
        None => Distribution::Uniform { min, max },
        Some((mean, deviation)) => Distribution::TruncatedNormal {
            mean,
            deviation,
            min: Some(min),
            max: Some(max),
        },
    }
}
