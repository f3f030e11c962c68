//! A sample of the posterior: particles that go from a known distribution to the posterior in steps.
//!
//! Sequential Monte Carlo (Del Moral, Doucet & Jasra 2006, Sequential Monte Carlo samplers, J. Royal Statistical Society
//! B 68, 411-436). Particles start in a distribution that can be drawn from. They pass distributions whose logarithm lies
//! between it and the posterior; each next one is as far away as the effective number of particles allows. At each of
//! them particles are resampled and then moved by Metropolis steps. The steps are shaped by the particles themselves
//! (`mixture`), so they fit several modes and curved valleys.
//!
//! The start is the prior, or a mixture of the prior and of the normal approximations at the optima that were found. The
//! mixture saves runs and changes nothing about the target: each particle is weighted against the density that it was
//! drawn from, and the prior's part bounds the weights (defensive importance sampling; Hesterberg 1995, Weighted average
//! importance sampling and defensive mixture distributions, Technometrics 37, 185-194).
//!
//! The particles form groups. Resampling never crosses groups, so each gives an estimate of everything by itself, and the
//! estimates' scatter says how far the sample can be trusted. Each step of all particles is one batch of runs.

#[cfg(test)]
mod coverage_tests;
pub mod evidence;
#[cfg(test)]
mod evidence_tests;
pub mod marginals;
mod mixture;
mod moves;
pub mod outcome;
mod population;
#[cfg(test)]
mod population_tests;
mod region;
mod target;
#[cfg(test)]
mod tests;
pub mod text;
mod walk;
mod weights;

use super::{failures::Failures, objective::Objective, optima::Optimum, problem::NoPrediction};
use target::Target;
use walk::Walk;

/// The groups that the particles form: pairs, of which each shapes the other's moves. Shaped by the particles that they move,
/// leaps would know where these stand in the tails, not where else they could stand: tails would be left more easily than
/// entered, and the sample too narrow. Were moves shaped by all, a mode that one pair has found would come to the others
/// through them, and all would agree although none is right.
pub const GROUPS: usize = 8;

/// The smallest number of particles: below it a group's moments say nothing.
pub const FEWEST: u64 = 200;

/// The most distributions: a model that needs more is not sampled by this method.
const MOST_STAGES: usize = 300;

/// How a sample is made.
#[derive(Clone, Copy, Debug)]
pub struct Settings {
    /// How many particles there are, about.
    pub particles: u64,
    /// Seed of all random numbers.
    pub seed: u64,
}

/// Why there is no sample.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SampleError {
    /// No particle could be simulated.
    #[error("a run failed at each of the {0} places where the posterior's sample starts")]
    NoStart(usize),
    /// The method does not get on.
    #[error("the posterior's sample came no further than an exponent of {0:.2e} in {MOST_STAGES} stages")]
    Stuck(f64),
    /// There are no further predictions.
    #[error(transparent)]
    Prediction(#[from] NoPrediction),
}

/// A place in the space of all unknowns.
#[derive(Clone, Debug)]
pub struct Particle {
    /// The unknowns, as places between their bounds.
    pub places: Vec<f64>,
    /// The logarithm of the prior density.
    pub log_prior: f64,
    /// The logarithm of the likelihood.
    pub log_likelihood: f64,
    /// Mean and standard deviation of each channel's shared error, if the unknowns were these.
    pub shared: Vec<[f64; 2]>,
    /// The logarithm of the density of the start.
    log_start: f64,
    /// The number of the particle at the start that this one comes from.
    ancestor: usize,
}

impl Particle {
    /// The logarithm of the posterior over the start's density; minus infinity where the posterior is 0.
    fn log_ratio(&self) -> f64 {
        if self.log_prior.is_finite() && self.log_likelihood.is_finite() {
            self.log_prior + self.log_likelihood - self.log_start
        } else {
            f64::NEG_INFINITY
        }
    }
}

/// One of the distributions on the way.
#[derive(Clone, Copy, Debug, serde::Serialize)]
pub struct Stage {
    /// The posterior's exponent: 0 at the start, 1 at the posterior.
    pub exponent: f64,
    /// Steps of all particles.
    pub moves: usize,
    /// The part of the steps that were accepted.
    pub acceptance: f64,
    /// The part of the particles that no step has moved.
    pub unmoved: f64,
    /// How many particles of the start have descendants.
    pub ancestors: usize,
    /// Places that the steps asked for.
    pub asked: u64,
    /// Those at which a run failed.
    pub failed: u64,
}

/// A sample of the posterior.
#[derive(Clone, Debug)]
pub struct Sample {
    /// The particles, all of equal weight.
    pub particles: Vec<Particle>,
    /// The groups before they were joined, all of the same size, with the logarithm of each one's evidence.
    pub groups: Vec<(f64, Vec<Particle>)>,
    /// The distributions on the way.
    pub stages: Vec<Stage>,
    /// The logarithms of the weights of fresh draws, whose mean is the evidence (see `Walk::weights`).
    pub weights: Vec<f64>,
    /// At how many places the model was asked.
    pub evaluated: u64,
    /// At how many of them a run failed: their likelihood counts as 0.
    pub failed: u64,
    /// Those places.
    pub failures: Failures,
}

impl Sample {
    /// How many unknowns a particle has, those that lie behind the problem's own among them.
    pub fn unknowns(&self) -> usize {
        self.particles.first().map_or(0, |particle| particle.places.len())
    }

    /// The places of the particles in one of their unknowns.
    pub fn places(&self, unknown: usize) -> impl Iterator<Item = f64> {
        self.particles.iter().map(move |particle| particle.places[unknown])
    }
}

/// Samples the posterior; with `optima` the start is a mixture of their normal approximations and the prior. `observe`
/// hears how far it is.
///
/// # Errors
/// When nothing can be simulated, or when there are no further predictions.
pub fn sample(
    objective: &Objective,
    optima: &[Optimum],
    settings: &Settings,
    observe: &dyn Fn(f64, usize),
) -> Result<Sample, SampleError> {
    let target = Target::new(objective);
    let before = objective.failures();
    let mut walk = Walk::at_posterior(&target, optima, settings, observe)?;
    let groups: Vec<(f64, Vec<Particle>)> = walk.evidences.clone().into_iter().zip(walk.groups()).collect();
    walk.join()?;
    let weights = walk.weights()?;
    let failures = objective.failures();
    let placed = |particles: Vec<Particle>| {
        particles
            .into_iter()
            .map(|particle| Particle { places: target.places(particle.places), ..particle })
            .collect::<Vec<Particle>>()
    };
    let groups = groups.into_iter().map(|(log, group)| (log, placed(group)));
    Ok(Sample {
        particles: placed(walk.particles),
        groups: groups.collect(),
        stages: walk.stages,
        weights,
        evaluated: failures.asked - before.asked,
        failed: failures.failed - before.failed,
        failures,
    })
}

/// Places of the posterior alone. Groups that are not joined are there, too, in half of the time, but not each by its evidence.
///
/// # Errors
/// Those of [`sample`].
pub(crate) fn places(
    objective: &Objective,
    optima: &[Optimum],
    settings: &Settings,
    joined: bool,
) -> Result<Vec<Vec<f64>>, SampleError> {
    let target = Target::new(objective);
    let mut walk = Walk::at_posterior(&target, optima, settings, &|_, _| ())?;
    if joined {
        walk.join()?;
    }
    Ok(walk.particles.into_iter().map(|particle| target.places(particle.places)).collect())
}
