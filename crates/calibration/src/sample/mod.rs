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
mod weights;

use nalgebra::DVector;
use sampling::{
    distribution::ln_sum,
    random::{Purpose, Random},
};

use super::{failures::Failures, objective::Objective, optima::Optimum, problem::NoPrediction};
use mixture::Mixture;
use moves::Mover;
use target::Target;
use weights::{next_step, resampled, times};

/// The groups that the particles form: pairs, of which each shapes the other's moves. Shaped by the particles that they move,
/// leaps would know where these stand in the tails, not where else they could stand: tails would be left more easily than
/// entered, and the sample too narrow. Were moves shaped by all, a mode that one pair has found would come to the others
/// through them, and all would agree although none is right.
pub const GROUPS: usize = 8;

/// The smallest number of particles: below it a group's moments say nothing.
pub const FEWEST: u64 = 200;

/// The prior's part of the particles, where the start is a mixture with the optima.
const DEFENCE: f64 = 0.5;

/// The optima's covariances are widened by these factors: a start should be wider than its target, and have its tails.
const WIDER: [f64; 2] = [1.5, 6.0];

/// Particles are moved until no more than this part of them stands where it stood: on the way, and at the end.
const UNMOVED: [f64; 2] = [0.1, 0.02];

/// The most moves at one distribution.
const MOST_MOVES: usize = 60;

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
    walk.join(observe)?;
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
        walk.join(&|_, _| ())?;
    }
    Ok(walk.particles.into_iter().map(|particle| target.places(particle.places)).collect())
}

/// A sample on its way.
struct Walk<'a> {
    target: &'a Target<'a>,
    /// The start's normal distributions, with their part of each group; the prior has the rest.
    seeds: Option<(Mixture, f64)>,
    random: Random,
    exponent: f64,
    /// Group by group.
    particles: Vec<Particle>,
    /// The logarithm of each group's evidence.
    evidences: Vec<f64>,
    /// The moves of each group; of each half, when groups are joined.
    movers: Vec<Mover>,
    stages: Vec<Stage>,
}

impl<'a> Walk<'a> {
    /// All groups are at the posterior.
    fn at_posterior(
        target: &'a Target<'a>,
        optima: &[Optimum],
        settings: &Settings,
        observe: &dyn Fn(f64, usize),
    ) -> Result<Self, SampleError> {
        // The search takes each case by itself, so its optima are no start for what has a common mean and spread.
        let alone = target.objective.problem.populations.is_empty();
        let mut walk = Self::begin(target, if alone { optima } else { &[] }, settings)?;
        while walk.exponent < 1.0 {
            if walk.stages.len() >= MOST_STAGES {
                return Err(SampleError::Stuck(walk.exponent));
            }
            walk.stage(observe)?;
        }
        Ok(walk)
    }

    fn begin(target: &'a Target<'a>, optima: &[Optimum], settings: &Settings) -> Result<Self, SampleError> {
        let mut random = Random::new(settings.seed, Purpose::Posterior, 0);
        let size = (settings.particles.max(FEWEST) as usize).div_ceil(GROUPS);
        let seeded = (size as f64 * (1.0 - DEFENCE)).round() as usize;
        let part = seeded as f64 / size as f64;
        let seeds = seeds(optima).map(|mixture| (mixture, part));
        let mut places = Vec::with_capacity(GROUPS * size);
        for _ in 0..GROUPS {
            let shift = random.unit();
            for index in 0..size {
                places.push(match &seeds {
                    Some((mixture, _)) if index < seeded => {
                        let level = (index as f64 + shift) / seeded as f64;
                        mixture.draw(level, 1.0, &mut random)
                    }
                    _ => target.draw(&mut random),
                });
            }
        }
        let mut walk = Self {
            target,
            seeds,
            random,
            exponent: 0.0,
            particles: Vec::new(),
            evidences: vec![0.0; GROUPS],
            movers: vec![Mover::new(target.before.len()); GROUPS],
            stages: Vec::new(),
        };
        walk.particles = walk.weighed(places)?;
        for (index, particle) in walk.particles.iter_mut().enumerate() {
            particle.ancestor = index;
        }
        if walk.particles.iter().any(|particle| particle.log_ratio().is_finite()) {
            Ok(walk)
        } else {
            Err(SampleError::NoStart(walk.particles.len()))
        }
    }

    /// Particles at these places: one batch of runs.
    fn weighed(&self, places: Vec<Vec<f64>>) -> Result<Vec<Particle>, SampleError> {
        let likelihoods = self.target.likelihoods(&places)?;
        Ok(places
            .into_iter()
            .zip(likelihoods)
            .map(|(places, likelihood)| {
                let log_prior = self.target.log_prior(&places);
                Particle {
                    log_start: self.log_start(log_prior, &places),
                    log_prior,
                    log_likelihood: likelihood.log,
                    shared: likelihood.shared,
                    ancestor: 0,
                    places,
                }
            })
            .collect())
    }

    /// The logarithm of the density of the start.
    fn log_start(&self, log_prior: f64, places: &[f64]) -> f64 {
        match &self.seeds {
            None => log_prior,
            Some((mixture, part)) => {
                let prior = log_prior + (1.0 - part).ln();
                let seeds = mixture.log_density(places, 1.0) + part.ln();
                ln_sum(&[prior, seeds])
            }
        }
    }

    fn size(&self) -> usize {
        self.particles.len() / GROUPS
    }

    fn groups(&self) -> Vec<Vec<Particle>> {
        self.particles.chunks(self.size()).map(<[Particle]>::to_vec).collect()
    }

    /// Goes on to the next distribution.
    fn stage(&mut self, observe: &dyn Fn(f64, usize)) -> Result<(), SampleError> {
        let ratios: Vec<f64> = self.particles.iter().map(Particle::log_ratio).collect();
        let step = next_step(&ratios, 1.0 - self.exponent);
        let last = step >= 1.0 - self.exponent;
        self.exponent = if last { 1.0 } else { self.exponent + step };
        let logs: Vec<f64> = ratios.iter().map(|ratio| times(step, *ratio)).collect();
        let size = self.size();
        for (evidence, logs) in self.evidences.iter_mut().zip(logs.chunks(size)) {
            *evidence += ln_sum(logs) - (size as f64).ln();
        }
        let all = ln_sum(&logs);
        let weights: Vec<f64> = logs.iter().map(|log| (log - all).exp()).collect();
        self.shape(&weights);
        let mut kept = Vec::with_capacity(self.particles.len());
        for (particles, weights) in self.particles.chunks(size).zip(weights.chunks(size)) {
            kept.extend(resampled(particles, weights, size, &mut self.random));
        }
        self.particles = kept;
        self.settle(UNMOVED[usize::from(last)], observe)
    }

    /// Shapes moves after the weighted particles of the other of a pair; after both, where those are too few.
    fn shape(&mut self, weights: &[f64]) {
        let size = self.particles.len() / self.movers.len();
        for (number, mover) in self.movers.iter_mut().enumerate() {
            let (other, first) = ((number ^ 1) * size, (number & !1) * size);
            let shape = |range: std::ops::Range<usize>, few: bool, random: &mut Random| {
                let all: f64 = weights[range.clone()].iter().sum();
                let weights: Vec<f64> = weights[range.clone()].iter().map(|weight| weight / all).collect();
                let places: Vec<&[f64]> = self.particles[range].iter().map(|each| &each.places[..]).collect();
                (all > 0.0 && (few || Mixture::enough(&places, &weights)))
                    .then(|| Mixture::fitted(&places, &weights, random))?
            };
            let fitted = shape(other..other + size, false, &mut self.random)
                .or_else(|| shape(first..first + 2 * size, true, &mut self.random));
            mover.mixture = fitted.or(mover.mixture.take());
        }
    }

    /// Joins the groups: each has the part of the sample that its evidence has of all evidence.
    fn join(&mut self, observe: &dyn Fn(f64, usize)) -> Result<(), SampleError> {
        let size = self.size();
        let all = ln_sum(&self.evidences);
        let weights: Vec<f64> = self
            .evidences
            .iter()
            .map(|log| (log - all).exp())
            .flat_map(|part| std::iter::repeat_n(part / size as f64, size))
            .collect();
        self.movers.truncate(2);
        let count = self.particles.len();
        self.particles = resampled(&self.particles, &weights, count, &mut self.random);
        // Neither half has ancestors of the other, but for one group.
        self.shape(&vec![(count as f64).recip(); count]);
        self.settle(UNMOVED[1], observe)
    }

    /// Fresh draws from the final sample's shape, and some from the prior: the logarithms of prior and likelihood over the
    /// density of the draw. The mean of these weights is the evidence. It has no bias, and its scatter is that of independent
    /// numbers; the product of the stages' ratios has neither quality, as the particles remember those before them. As many
    /// draws as particles, and again until they tell enough.
    fn weights(&mut self) -> Result<Vec<f64>, SampleError> {
        const FROM_PRIOR: f64 = 0.1;
        const MOST_ROUNDS: usize = 5;
        let points: Vec<&[f64]> = self.particles.iter().map(|particle| &particle.places[..]).collect();
        let Some(mixture) = Mixture::covering(&points, &mut self.random) else { return Ok(Vec::new()) };
        let count = self.particles.len();
        let of_prior = (FROM_PRIOR * count as f64) as usize;
        let part = of_prior as f64 / count as f64;
        let mut weights = Vec::new();
        for round in 0..MOST_ROUNDS {
            if round > 0 && evidence::effective_draws(&weights) >= evidence::ENOUGH {
                break;
            }
            let shift = self.random.unit();
            let places = (0..count)
                .map(|index| {
                    if index < of_prior {
                        self.target.draw(&mut self.random)
                    } else {
                        let level = ((index - of_prior) as f64 + shift) / (count - of_prior) as f64;
                        mixture.draw(level, moves::WIDER, &mut self.random)
                    }
                })
                .collect();
            let drawn = self.weighed(places)?;
            weights.extend(drawn.iter().map(|particle| {
                let shaped = mixture.log_density(&particle.places, moves::WIDER);
                let density = [shaped + (1.0 - part).ln(), particle.log_prior + part.ln()];
                particle.log_prior + particle.log_likelihood - ln_sum(&density)
            }));
        }
        Ok(weights)
    }

    /// One step of all particles, in one batch of runs; tells which have moved.
    fn step(&mut self) -> Result<Vec<bool>, SampleError> {
        let size = self.particles.len() / self.movers.len();
        let parts = self.particles.chunks(size).zip(&self.movers);
        let mut proposals = Vec::with_capacity(self.particles.len());
        for (particles, mover) in parts {
            proposals.extend(mover.propose(particles, &mut self.random));
        }
        let places = proposals.iter().map(|proposal| proposal.places.clone()).collect();
        let there = self.weighed(places)?;
        let mut taken = Vec::with_capacity(there.len());
        let parts = self.particles.chunks_mut(size).zip(&mut self.movers);
        let proposed = there.chunks(size).zip(proposals.chunks(size));
        for ((particles, mover), (there, proposals)) in parts.zip(proposed) {
            let random = &mut self.random;
            taken.extend(mover.decide(particles, there, proposals, self.exponent, random));
        }
        for particle in &mut self.particles {
            if self.target.refresh(&mut particle.places, &mut self.random) {
                particle.log_prior = self.target.log_prior(&particle.places);
                particle.log_start = particle.log_prior;
            }
        }
        Ok(taken)
    }

    /// Moves the particles until few of them stand where they stood.
    fn settle(&mut self, unmoved: f64, observe: &dyn Fn(f64, usize)) -> Result<(), SampleError> {
        let count = self.particles.len();
        let mut moved = vec![false; count];
        let (mut moves, mut accepted) = (0, 0);
        let before = self.target.objective.failures();
        let still = |moved: &[bool]| moved.iter().filter(|moved| !**moved).count() as f64 / count as f64;
        while moves < MOST_MOVES && (moves < 2 || still(&moved) > unmoved) {
            observe(self.exponent, moves + 1);
            let taken = self.step()?;
            for (moved, taken) in moved.iter_mut().zip(taken) {
                *moved |= taken;
                accepted += usize::from(taken);
            }
            moves += 1;
        }
        let mut ancestors: Vec<usize> = self.particles.iter().map(|particle| particle.ancestor).collect();
        ancestors.sort_unstable();
        ancestors.dedup();
        let after = self.target.objective.failures();
        self.stages.push(Stage {
            exponent: self.exponent,
            moves,
            acceptance: accepted as f64 / (count * moves) as f64,
            unmoved: still(&moved),
            ancestors: ancestors.len(),
            asked: after.asked - before.asked,
            failed: after.failed - before.failed,
        });
        Ok(())
    }
}

/// The normal approximations at the optima.
fn seeds(optima: &[Optimum]) -> Option<Mixture> {
    // Their weights are estimates: none should start with next to nothing.
    const LEAST: f64 = 0.05;
    let parts = optima.iter().flat_map(|optimum| {
        let mean = DVector::from_vec(optimum.minimum.places.clone());
        WIDER.map(|wider| (optimum.weight.max(LEAST), mean.clone(), &optimum.posterior.covariance * wider))
    });
    Mixture::new(parts.collect())
}
