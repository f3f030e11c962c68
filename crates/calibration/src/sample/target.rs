//! The posterior that is sampled: the prior between the bounds, and the likelihood of the measured values.

use sampling::distribution::Distribution;
use sampling::random::Random;

use super::super::discrepancy::Unknown;
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
    /// The logarithm of the likelihood where every prediction is what was measured.
    best: f64,
}

impl<'a> Target<'a> {
    pub(super) fn new(objective: &'a Objective<'a>, discrepancies: Vec<Unknown>) -> Self {
        let problem = objective.problem;
        let free = problem.free.iter().map(|free| before(free.prior_place()));
        let others = problem.unknowns() - problem.free.len() + discrepancies.len();
        let before = free.chain(std::iter::repeat_n(before(None), others));
        let measured = problem.cases.iter().flat_map(|case| &case.measured);
        let peak = |accuracy: f64| -accuracy.ln() - 0.5 * std::f64::consts::TAU.ln();
        Self {
            objective,
            before: before.collect(),
            discrepancies,
            best: measured.map(|measured| peak(measured.accuracy)).sum(),
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
            if let Ok(misfit) = misfit {
                likelihoods[index] = self.log_likelihood(&sets[index], &misfit);
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
            let predicted = &misfit.predicted;
            let at = |deviation| unknown.log_likelihood(problem, predicted, deviation, 1.0);
            log += at(unknown.deviation(place)) - at(0.0);
        }
        if log.is_nan() { f64::NEG_INFINITY } else { log }
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
