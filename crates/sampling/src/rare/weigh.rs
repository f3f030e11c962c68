//! The share of the event by importance sampling: points are drawn from a mixture that was fitted to the event, and each
//! counts by the ratio of its density under the standard normal distribution to that under the mixture (Kurtz and Song
//! 2013, "Cross-entropy-based adaptive importance sampling using Gaussian mixture").
//!
//! The last draws are independent of all that the mixture was fitted to, and their number is fixed before they are made.
//! So their mean is the share without bias, as far as the mixture reaches.

use statrs::distribution::{ContinuousCDF, Normal};

use super::explore::Population;
use super::mixture::{Mixture, ln_standard};
use super::runs::Runs;
use super::scatter::effective;
use super::{Answer, Method, RegionShare, Share, Weighted, rough};
use crate::random::Random;

/// Components for one region.
const MOST_PARTS: usize = 6;
/// The number of trials after which the mixture is fitted anew, and one more.
const TRIALS: usize = 3;
/// The mixture cannot be trusted when fewer draws of a trial meet the event.
const FEWEST_HITS: usize = 30;
/// The relative standard error that is enough.
const ENOUGH: f64 = 0.05;
/// The estimated number of draws for that is rough, so more are made.
const RESERVE: f64 = 4.0;
const FEWEST_DRAWS: u64 = 4000;
/// The scatter of the weights is itself known from the draws, and large weights are rare: the normal interval held in 89 %
/// of the trials (the example `rare`), so it is drawn out by this factor.
const DRAWN_OUT: f64 = 1.3;

/// A mixture that is ready for the last draws.
#[derive(Debug)]
pub(super) struct Proposal {
    mixture: Mixture,
    regions: usize,
    /// The variance of the weights over the square of their mean, as the last trial has it.
    scatter: f64,
    /// The share as the last trial has it.
    pub(super) share: f64,
}

/// Draws from a mixture.
struct Drawn {
    points: Vec<Vec<f64>>,
    /// Zero for those that do not meet the event.
    weights: Vec<f64>,
}

impl Drawn {
    fn mean(&self) -> f64 {
        self.weights.iter().sum::<f64>() / self.weights.len() as f64
    }

    /// The variance of the weights over the square of their mean.
    fn scatter(&self) -> f64 {
        let (mean, count) = (self.mean(), self.weights.len() as f64);
        let squares: f64 = self.weights.iter().map(|w| (w - mean).powi(2)).sum();
        squares / (count - 1.0) / (mean * mean)
    }

    fn hits(self) -> (Vec<Vec<f64>>, Vec<f64>) {
        let pairs = self.points.into_iter().zip(self.weights);
        pairs.filter(|(_, weight)| *weight > 0.0).unzip()
    }
}

fn draw<E>(
    mixture: &Mixture,
    count: u64,
    runs: &mut Runs<'_, E>,
    random: &mut Random,
) -> Result<Drawn, E> {
    let from = mixture.defended();
    let points: Vec<Vec<f64>> = (0..count).map(|_| from.draw(random)).collect();
    let results = runs.of(&points)?;
    let weight = |(point, met): (&Vec<f64>, bool)| {
        if met {
            (ln_standard(point) - from.ln_density(point)).exp()
        } else {
            0.0
        }
    };
    let met = results.iter().map(|result| result.met);
    let weights = points.iter().zip(met).map(weight).collect();
    Ok(Drawn { points, weights })
}

/// Fits a mixture to the populations of the regions, and improves it by trials of so many draws. None where the event is
/// met too seldom.
pub(super) fn propose<E>(
    regions: &[Population],
    trial: u64,
    runs: &mut Runs<'_, E>,
    random: &mut Random,
) -> Result<Option<Proposal>, E> {
    let all = rough(regions);
    // What a population's size says of its region is rough: no region begins with less than half of its turn.
    let least = 0.5 / regions.len() as f64;
    let mut mixture = Mixture::default();
    for (number, region) in regions.iter().enumerate() {
        let ones = vec![1.0; region.points.len()];
        let of_region = Mixture::fit(&region.points, &ones, MOST_PARTS, random);
        mixture.add(of_region, (region.share / all).max(least), number);
    }
    mixture.normalise();
    for number in 1..=TRIALS {
        if runs.left() < trial {
            return Ok(None);
        }
        let drawn = draw(&mixture, trial, runs, random)?;
        let (share, scatter) = (drawn.mean(), drawn.scatter());
        let (points, mut weights) = drawn.hits();
        if points.len() < FEWEST_HITS {
            return Ok(None);
        }
        if number == TRIALS {
            return Ok(Some(Proposal {
                mixture,
                regions: regions.len(),
                scatter,
                share,
            }));
        }
        cap(&mut weights);
        if regions.len() == 1 {
            mixture = Mixture::fit(&points, &weights, MOST_PARTS, random);
        } else {
            mixture.refit(&points, &weights);
        }
    }
    Ok(None)
}

/// Lowers the few largest weights to the largest of the others, so that no fit follows a few points.
fn cap(weights: &mut [f64]) {
    let mut sorted = weights.to_vec();
    sorted.sort_by(|a, b| b.total_cmp(a));
    let few = ((weights.len() as f64).sqrt() / 3.0) as usize;
    let Some(&most) = sorted.get(few.max(1)) else {
        return;
    };
    weights.iter_mut().for_each(|w| *w = w.min(most));
}

impl Proposal {
    /// The relative standard error that so many draws would leave.
    pub(super) fn expected_error(&self, draws: u64) -> f64 {
        (self.scatter / draws.max(1) as f64).sqrt()
    }

    /// Makes the last draws, as many as are left at most, and answers with the share and what it rests on.
    pub(super) fn measure<E>(
        &self,
        confidence: f64,
        runs: &mut Runs<'_, E>,
        random: &mut Random,
        answer: &mut Answer,
    ) -> Result<(), E> {
        let wanted = (RESERVE * self.scatter / (ENOUGH * ENOUGH)).ceil() as u64;
        let count = wanted.max(FEWEST_DRAWS).min(runs.left());
        let drawn = draw(&self.mixture, count, runs, random)?;
        let share = drawn.mean();
        let error = (drawn.scatter() / count as f64).sqrt();
        let effective = effective(&drawn.weights);
        let (points, weights) = drawn.hits();
        let weights: Vec<f64> = weights.iter().map(|weight| weight / count as f64).collect();
        answer.regions = self.regions(&points, &weights);
        let pairs = points.into_iter().zip(weights);
        let sample = pairs.map(|(scores, weight)| Weighted { scores, weight });
        answer.sample = sample.collect();
        let normal = Normal::standard().inverse_cdf(0.5 + 0.5 * confidence);
        let half = DRAWN_OUT * normal * error;
        answer.share = Some(Share {
            value: share,
            interval: Some([share * (-half).exp(), (share * half.exp()).min(1.0)]),
            error,
            effective,
            method: Method::Weighted,
        });
        Ok(())
    }

    /// The regions that have any of the points that meet the event, the largest first.
    fn regions(&self, points: &[Vec<f64>], weights: &[f64]) -> Vec<RegionShare> {
        let of: Vec<usize> = points.iter().map(|p| self.mixture.region(p)).collect();
        let region = |number: usize| {
            let members = || (0..points.len()).filter(|&k| of[k] == number);
            let share: f64 = members().map(|k| weights[k]).sum();
            let mean =
                |axis: usize| members().map(|k| weights[k] * points[k][axis]).sum::<f64>() / share;
            let mean: Vec<f64> = (0..points.first()?.len()).map(mean).collect();
            // The mean of a curved region may lie outside of it.
            let apart = |&k: &usize| -> f64 {
                let pairs = points[k].iter().zip(&mean);
                pairs.map(|(x, m)| (x - m).powi(2)).sum()
            };
            let middle = members().min_by(|a, b| apart(a).total_cmp(&apart(b)))?;
            let centre = points[middle].clone();
            Some(RegionShare { share, centre })
        };
        let mut regions: Vec<RegionShare> = (0..self.regions).filter_map(region).collect();
        regions.sort_by(|a, b| b.share.total_cmp(&a.share));
        regions
    }
}
