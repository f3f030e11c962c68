//! The particles' way from the start to the posterior.

use nalgebra::DVector;
use sampling::{
    distribution::ln_sum,
    random::{Purpose, Random},
};

use super::{
    FEWEST, GROUPS, MOST_STAGES, Particle, SampleError, Settings, Stage, evidence,
    mixture::Mixture,
    moves::{self, Mover},
    target::Target,
    weights::{next_step, resampled, times},
};
use crate::optima::Optimum;

/// The prior's part of the particles, where the start is a mixture with the optima.
const DEFENCE: f64 = 0.5;

/// The optima's covariances are widened by these factors: a start should be wider than its target, and have its tails.
const WIDER: [f64; 2] = [1.5, 6.0];

/// Particles are moved until no more than this part of them stands where it stood: on the way, and at the end.
const UNMOVED: [f64; 2] = [0.1, 0.02];

/// The most moves at one distribution.
const MOST_MOVES: usize = 60;

/// A sample on its way.
pub struct Walk<'a> {
    target: &'a Target<'a>,
    /// The start's normal distributions, with their part of each group; the prior has the rest.
    seeds: Option<(Mixture, f64)>,
    random: Random,
    exponent: f64,
    /// Group by group.
    pub particles: Vec<Particle>,
    /// The logarithm of each group's evidence.
    pub evidences: Vec<f64>,
    /// The moves of each group; of each half, when groups are joined.
    movers: Vec<Mover>,
    pub stages: Vec<Stage>,
    /// Hears the exponent, and the number of the step.
    observe: &'a dyn Fn(f64, usize),
}

impl<'a> Walk<'a> {
    /// All groups are at the posterior.
    pub fn at_posterior(
        target: &'a Target<'a>,
        optima: &[Optimum],
        settings: &Settings,
        observe: &'a dyn Fn(f64, usize),
    ) -> Result<Self, SampleError> {
        // The search takes each case by itself, so its optima are no start for what has a common mean and spread.
        let alone = target.objective.problem.populations.is_empty();
        let mut walk = Self::begin(target, if alone { optima } else { &[] }, settings, observe)?;
        while walk.exponent < 1.0 {
            if walk.stages.len() >= MOST_STAGES {
                return Err(SampleError::Stuck(walk.exponent));
            }
            walk.stage()?;
        }
        Ok(walk)
    }

    fn begin(
        target: &'a Target<'a>,
        optima: &[Optimum],
        settings: &Settings,
        observe: &'a dyn Fn(f64, usize),
    ) -> Result<Self, SampleError> {
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
            observe,
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

    pub fn groups(&self) -> Vec<Vec<Particle>> {
        self.particles.chunks(self.size()).map(<[Particle]>::to_vec).collect()
    }

    /// Goes on to the next distribution.
    fn stage(&mut self) -> Result<(), SampleError> {
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
        self.settle(UNMOVED[usize::from(last)])
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
    pub fn join(&mut self) -> Result<(), SampleError> {
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
        self.settle(UNMOVED[1])
    }

    /// Fresh draws from the final sample's shape, and some from the prior: the logarithms of prior and likelihood over the
    /// density of the draw. The mean of these weights is the evidence. It has no bias, and its scatter is that of independent
    /// numbers; the product of the stages' ratios has neither quality, as the particles remember those before them. As many
    /// draws as particles, and again until they tell enough.
    pub fn weights(&mut self) -> Result<Vec<f64>, SampleError> {
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
    fn settle(&mut self, unmoved: f64) -> Result<(), SampleError> {
        let count = self.particles.len();
        let mut moved = vec![false; count];
        let (mut moves, mut accepted) = (0, 0);
        let before = self.target.objective.failures();
        let still = |moved: &[bool]| moved.iter().filter(|moved| !**moved).count() as f64 / count as f64;
        while moves < MOST_MOVES && (moves < 2 || still(&moved) > unmoved) {
            (self.observe)(self.exponent, moves + 1);
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
