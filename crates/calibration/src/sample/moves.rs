//! The particles' moves: Metropolis-Hastings steps in the shape of the sample.
//!
//! Two kinds alternate at random. A walk goes a step in the shape of the mixture's part that the particle belongs to; a
//! leap goes to a place drawn from the mixture, and so from one mode to another. Both count the way back, so the
//! distribution that is sampled stays as it is (Hastings 1970, Monte Carlo sampling methods using Markov chains and their
//! applications, Biometrika 57, 97-109).

use sampling::random::Random;

use super::{Particle, mixture::Mixture};

/// Leaps go to places from a mixture that is so much wider than the sample.
pub const WIDER: f64 = 1.2;

/// The acceptance of walks that is aimed at (Roberts, Gelman & Gilks 1997, Annals of Applied Probability 7, 110-120).
const WANTED: f64 = 0.27;

/// Moves, adapted to what was accepted so far.
#[derive(Clone)]
pub struct Mover {
    /// The shape of the sample, which the moves follow.
    pub mixture: Option<Mixture>,
    /// The step of a walk in units of what is best for a normal distribution.
    scale: f64,
    /// The part of the moves that are leaps.
    leaps: f64,
    unknowns: usize,
}

/// A place to move to.
pub struct Proposal {
    pub places: Vec<f64>,
    leap: bool,
    /// The logarithm of the density of the way back over that of the way there.
    back: f64,
}

impl Mover {
    pub fn new(unknowns: usize) -> Self {
        Self { mixture: None, scale: 1.0, leaps: 0.5, unknowns }
    }

    /// A place to move to for each particle.
    pub fn propose(&self, particles: &[Particle], random: &mut Random) -> Vec<Proposal> {
        let proposals = particles.iter().map(|particle| match &self.mixture {
            Some(mixture) => self.proposal(mixture, &particle.places, random),
            // Nothing could be fitted: the particles stay.
            None => Proposal { places: particle.places.clone(), leap: false, back: 0.0 },
        });
        proposals.collect()
    }

    fn proposal(&self, mixture: &Mixture, from: &[f64], random: &mut Random) -> Proposal {
        let leap = random.unit() < self.leaps;
        if leap {
            let places = mixture.draw(random.unit(), WIDER, random);
            let back = mixture.log_density(from, WIDER) - mixture.log_density(&places, WIDER);
            return Proposal { places, leap, back };
        }
        let scale = self.scale * 2.38 / (self.unknowns as f64).sqrt() * shorter(random);
        let places = mixture.step(from, scale, random);
        let back = mixture.log_step(&places, from, scale) - mixture.log_step(from, &places, scale);
        Proposal { places, leap, back }
    }

    /// Moves the particles whose proposals are accepted, and tells which are; adapts the next moves.
    pub fn decide(
        &mut self,
        particles: &mut [Particle],
        there: &[Particle],
        proposals: &[Proposal],
        exponent: f64,
        random: &mut Random,
    ) -> Vec<bool> {
        // Accepted and all, of walks and of leaps.
        let mut counts = [[0.0_f64; 2]; 2];
        let mut taken = Vec::with_capacity(particles.len());
        for ((particle, there), proposal) in particles.iter_mut().zip(there).zip(proposals) {
            let level = random.unit();
            let log = log_density(there, exponent) - log_density(particle, exponent) + proposal.back;
            // A particle outside of the posterior waits to be resampled, and so does one that would go there.
            let accepted = there.log_ratio().is_finite() && level.ln() < log;
            let [yes, all] = &mut counts[usize::from(proposal.leap)];
            *all += 1.0;
            if accepted {
                *yes += 1.0;
                let ancestor = particle.ancestor;
                *particle = Particle { ancestor, ..there.clone() };
            }
            taken.push(accepted);
        }
        self.adapt(counts);
        taken
    }

    fn adapt(&mut self, counts: [[f64; 2]; 2]) {
        let [walks, leaps] = counts.map(|[yes, all]| yes / f64::max(all, 1.0));
        if counts[0][1] > 0.0 {
            self.scale = (self.scale * (walks - WANTED).exp()).clamp(0.1, 3.0);
        }
        if counts[0][1] > 0.0 && counts[1][1] > 0.0 {
            let wanted = (leaps / (leaps + walks + 1e-9)).clamp(0.1, 0.9);
            self.leaps = 0.5 * (self.leaps + wanted);
        }
    }
}

/// Some walks are much shorter: where a part of the mixture is wider than the mode that a particle is in, they still move.
fn shorter(random: &mut Random) -> f64 {
    let (some, by) = (random.unit(), random.unit());
    if some < 0.2 { 10.0_f64.powf(-2.0 * by) } else { 1.0 }
}

/// The logarithm of the density on the way from the start to the posterior.
fn log_density(particle: &Particle, exponent: f64) -> f64 {
    let ratio = particle.log_ratio();
    if ratio.is_finite() { particle.log_start + exponent * ratio } else { f64::NEG_INFINITY }
}
