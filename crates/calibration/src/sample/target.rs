//! The posterior that is sampled: the prior between the bounds, and the likelihood of the measured values.

use sampling::{distribution::Distribution, random::Random};

use super::{
    super::{
        local::Minimum,
        objective::{Misfit, Objective},
        problem::NoPrediction,
        stated::Stated,
    },
    population::{PopulationPlaces, before},
};

/// The posterior that is sampled.
pub struct Target<'a> {
    pub objective: &'a Objective<'a>,
    /// The prior of each coordinate: uniform from 0 to 1, or normal and cut there. Those of populations depend on each other.
    pub before: Vec<Distribution>,
    /// Parameters that vary from case to case, each with the coordinates of its mean and spread behind all others.
    populations: Vec<PopulationPlaces>,
    /// What is beyond normal errors.
    stated: Stated,
}

/// How probable the measured values are at a place.
#[derive(Clone, Debug)]
pub struct Likelihood {
    /// The logarithm of their density.
    pub log: f64,
    /// Mean and standard deviation of each channel's shared error there.
    pub shared: Vec<[f64; 2]>,
}

impl Likelihood {
    /// That of a place that is impossible, or at which nothing is known.
    fn none() -> Self {
        Self { log: f64::NEG_INFINITY, shared: Vec::new() }
    }
}

impl<'a> Target<'a> {
    pub fn new(objective: &'a Objective<'a>) -> Self {
        let problem = objective.problem;
        let free = problem.free.iter().map(|free| before(free.prior_place()));
        let populations = problem.populations.iter().enumerate();
        let first = problem.unknowns();
        let populations: Vec<PopulationPlaces> =
            populations.map(|(number, each)| PopulationPlaces::new(problem, each, first + 2 * number)).collect();
        let others = first - problem.free.len() + 2 * populations.len();
        let before = free.chain(std::iter::repeat_n(before(None), others));
        Self { objective, before: before.collect(), populations, stated: Stated::new(problem, &objective.errors) }
    }

    /// The coordinates that have a prior of their own.
    fn alone(&self) -> impl Iterator<Item = (usize, &Distribution)> {
        let common = 2 * self.populations.len();
        self.before
            .iter()
            .enumerate()
            .take(self.before.len() - common)
            .filter(|(index, _)| !self.populations.iter().any(|each| each.has(*index)))
    }

    /// Coordinates from the prior.
    pub fn draw(&self, random: &mut Random) -> Vec<f64> {
        let mut coordinates = vec![0.0; self.before.len()];
        for (index, distribution) in self.alone() {
            coordinates[index] = distribution.quantile(random.unit());
        }
        for population in &self.populations {
            population.draw(&mut coordinates, random);
        }
        coordinates
    }

    /// The logarithm of the prior density: minus infinity outside of the bounds.
    pub fn log_prior(&self, coordinates: &[f64]) -> f64 {
        let alone: f64 = self.alone().map(|(index, distribution)| distribution.ln_density(coordinates[index])).sum();
        let common: f64 = self.populations.iter().map(|each| each.log_prior(coordinates)).sum();
        // Where the spread is not positive, one of the terms may be no number.
        let log = alone + common;
        if log.is_nan() { f64::NEG_INFINITY } else { log }
    }

    /// The places of the unknowns at given coordinates; of a population, its mean's place and its spread.
    pub fn places(&self, mut coordinates: Vec<f64>) -> Vec<f64> {
        for population in &self.populations {
            population.place(&mut coordinates);
        }
        coordinates
    }

    /// Moves means and spreads, which the likelihood does not depend on; tells whether there are any.
    pub fn refresh(&self, coordinates: &mut [f64], random: &mut Random) -> bool {
        for population in &self.populations {
            population.refresh(coordinates, random);
        }
        !self.populations.is_empty()
    }

    /// The likelihoods, all in one batch of runs: none outside of the bounds, where nothing is run, and where a run failed.
    ///
    /// # Errors
    /// When there are no further predictions.
    pub fn likelihoods(&self, sets: &[Vec<f64>]) -> Result<Vec<Likelihood>, NoPrediction> {
        let inside: Vec<usize> = (0..sets.len()).filter(|&index| self.log_prior(&sets[index]).is_finite()).collect();
        let asked: Vec<Vec<f64>> = inside.iter().map(|&index| self.places(sets[index].clone())).collect();
        let misfits = self.objective.misfits(&asked)?;
        let mut likelihoods = vec![Likelihood::none(); sets.len()];
        for (&index, misfit) in inside.iter().zip(misfits) {
            if let Ok(misfit) = misfit {
                likelihoods[index] = self.likelihood(&misfit);
            }
        }
        Ok(likelihoods)
    }

    /// The logarithm of prior and likelihood at a minimum.
    pub fn log_density(&self, minimum: &Minimum) -> f64 {
        self.log_prior(&minimum.places) + self.likelihood(&minimum.misfit).log
    }

    fn likelihood(&self, misfit: &Misfit) -> Likelihood {
        let Self { objective: Objective { problem, errors, .. }, stated, .. } = self;
        let sources = misfit.sources(problem);
        let beyond = stated.ln_beyond(problem, errors, &misfit.predicted, sources);
        let likelihood = Likelihood {
            log: errors.log_density(misfit.data_cost(problem)) + beyond,
            shared: stated.channels(problem, errors.channels(problem, sources), sources),
        };
        if likelihood.log.is_nan() { Likelihood::none() } else { likelihood }
    }
}
