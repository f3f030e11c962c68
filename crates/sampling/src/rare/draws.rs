//! Draws from a mixture, each with the weight that makes it one of the parameters' own distribution.

use super::mixture::{Mixture, ln_standard};
use super::runs::Runs;
use crate::random::Random;

/// Draws from a mixture.
pub(super) struct Drawn {
    pub(super) points: Vec<Vec<f64>>,
    /// Zero for those that do not meet the event.
    pub(super) weights: Vec<f64>,
}

impl Drawn {
    pub(super) fn mean(&self) -> f64 {
        self.weights.iter().sum::<f64>() / self.weights.len() as f64
    }

    /// The variance of the weights over the square of their mean.
    pub(super) fn scatter(&self) -> f64 {
        let (mean, count) = (self.mean(), self.weights.len() as f64);
        let squares: f64 = self.weights.iter().map(|w| (w - mean).powi(2)).sum();
        squares / (count - 1.0) / (mean * mean)
    }

    /// Those with a larger weight than this.
    pub(super) fn above(&self, limit: f64) -> Vec<Vec<f64>> {
        let pairs = self.points.iter().zip(&self.weights);
        let heavy = pairs.filter(|(_, weight)| **weight > limit);
        heavy.map(|(point, _)| point.clone()).collect()
    }

    pub(super) fn hits(self) -> (Vec<Vec<f64>>, Vec<f64>) {
        let pairs = self.points.into_iter().zip(self.weights);
        pairs.filter(|(_, weight)| *weight > 0.0).unzip()
    }
}

/// Draws so many points and weighs them.
pub(super) fn draw<E>(from: &Mixture, count: u64, runs: &mut Runs<'_, E>, random: &mut Random) -> Result<Drawn, E> {
    let points: Vec<Vec<f64>> = (0..count).map(|_| from.draw(random)).collect();
    let results = runs.of(&points)?;
    let weight = |(point, met): (&Vec<f64>, bool)| match met {
        true => weight(point, from),
        false => 0.0,
    };
    let met = results.iter().map(|result| result.met);
    let weights = points.iter().zip(met).map(weight).collect();
    Ok(Drawn { points, weights })
}

/// The ratio of the density of the standard normal distribution to that of a mixture.
pub(super) fn weight(point: &[f64], from: &Mixture) -> f64 {
    (ln_standard(point) - from.ln_density(point)).exp()
}
