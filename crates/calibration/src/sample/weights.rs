//! How the weights of particles lead to the next distribution.

use sampling::random::Random;

use super::{Particle, mixture::chosen};

/// The next distribution is so far away that this part of the particles remains effective.
const EFFECTIVE: f64 = 0.5;

/// The product, with 0 times minus infinity left at minus infinity.
pub fn times(step: f64, log: f64) -> f64 {
    if log.is_finite() { step * log } else { log }
}

/// The next step of the exponent: the whole rest, or as far as half of the particles that can have descendants remain
/// effective.
pub fn next_step(ratios: &[f64], rest: f64) -> f64 {
    let alive: Vec<f64> = ratios.iter().copied().filter(|ratio| ratio.is_finite()).collect();
    let most = alive.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let effective = |step: f64| {
        let (sum, squares) = alive
            .iter()
            .map(|ratio| (step * (ratio - most)).exp())
            .fold((0.0, 0.0), |(sum, squares), w| (sum + w, squares + w * w));
        sum * sum / squares
    };
    let wanted = EFFECTIVE * alive.len() as f64;
    if effective(rest) >= wanted {
        return rest;
    }
    let (mut low, mut high) = (0.0, rest);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if effective(middle) >= wanted {
            low = middle;
        } else {
            high = middle;
        }
    }
    // The last halving leaves less than one could tell from 0 only where the ratios differ beyond all measure.
    if low > 0.0 { low } else { high }
}

/// Particles drawn in proportion to their weights, evenly spread over these (systematic resampling; Kitagawa 1996, Monte
/// Carlo filter and smoother, J. Computational and Graphical Statistics 5, 1-25).
pub fn resampled(particles: &[Particle], weights: &[f64], count: usize, random: &mut Random) -> Vec<Particle> {
    let all: f64 = weights.iter().sum();
    if all <= 0.0 {
        // A group without a living particle has no evidence: its particles wait until the groups are joined.
        return particles.to_vec();
    }
    let first = random.unit();
    let mut kept = Vec::with_capacity(count);
    let (mut index, mut sum) = (0, weights[0]);
    let last = chosen(weights.iter().copied(), f64::INFINITY);
    for k in 0..count {
        let level = (k as f64 + first) / count as f64 * all;
        while sum <= level && index < last {
            index += 1;
            sum += weights[index];
        }
        kept.push(particles[index].clone());
    }
    kept
}
