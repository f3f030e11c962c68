//! The share of the event by importance sampling: points are drawn from a mixture that was fitted to the event, and each
//! counts by the ratio of its density under the standard normal distribution to that under the mixture (Kurtz and Song
//! 2013, "Cross-entropy-based adaptive importance sampling using Gaussian mixture").
//!
//! The last draws are independent of all that the mixture was fitted to, and their number is fixed before they are made.
//! So their mean is the share without bias, as far as the mixture reaches.

use statrs::distribution::{ContinuousCDF, Normal};

use super::draws::{Drawn, draw, weight};
use super::gather::Gathered;
use super::mixture::Mixture;
use super::runs::Runs;
use super::scatter::effective;
use super::{Answer, Method, RegionShare, Share, Weighted};
use crate::random::Random;

/// The relative standard error that is enough.
const ENOUGH: f64 = 0.05;
/// The estimated number of draws for that is rough, so more are made.
const RESERVE: f64 = 4.0;
const FEWEST_DRAWS: u64 = 6000;
/// A larger error of the draws says that the mixture does not follow the event.
const LARGE: f64 = 0.1;
/// A draw with so large a part of the share lies outside of what the mixture follows.
const HEAVY: f64 = 0.02;
/// No region has so small a part of the share.
const NEGLIGIBLE: f64 = 1e-4;
/// Mixtures that are tried: each is told of what the draws of the one before found outside of it.
const ROUNDS: usize = 4;
/// The scatter of the weights is itself known from the draws, and large weights are rare: the normal interval held in 89 %
/// of the trials (the example `rare`), so it is drawn out by this factor.
const DRAWN_OUT: f64 = 1.3;

/// The share by draws from a mixture for what was gathered; false where the mixture does not follow the event.
pub(super) fn weigh<E>(
    gathered: &mut Gathered,
    confidence: f64,
    runs: &mut Runs<'_, E>,
    random: &mut Random,
    answer: &mut Answer,
) -> Result<bool, E> {
    let mut heavy: Vec<Vec<f64>> = Vec::new();
    for _ in 0..ROUNDS {
        let Some(scatter) = gathered.scatter() else {
            return Ok(false);
        };
        if (scatter / runs.left().max(1) as f64).sqrt() > LARGE {
            return Ok(false);
        }
        let from = gathered.proposal();
        let wanted = (RESERVE * scatter / (ENOUGH * ENOUGH)).ceil() as u64;
        let count = wanted.max(FEWEST_DRAWS).min(runs.left());
        let drawn = draw(&from, count, runs, random)?;
        let limit = HEAVY * drawn.mean() * count as f64;
        // Draws that were heavy before must not be missed by mere chance now.
        if heavy.iter().any(|point| weight(point, &from) > limit) {
            return Ok(false);
        }
        let now = drawn.above(limit);
        if now.is_empty() {
            state(drawn, scatter, &gathered.mixture, confidence, answer);
            return Ok(true);
        }
        gathered.follow(&now, runs, random)?;
        gathered.improve(runs, random)?;
        heavy.extend(now);
    }
    Ok(false)
}

/// States the share and what it rests on. The draws' own scatter is too small where the largest weights are missing among
/// them, and with them a part of the share: `scatter` is what was known of it before.
fn state(drawn: Drawn, scatter: f64, mixture: &Mixture, confidence: f64, answer: &mut Answer) {
    let count = drawn.weights.len() as f64;
    let share = drawn.mean();
    let error = (drawn.scatter().max(scatter) / count).sqrt();
    let effective = effective(&drawn.weights);
    let (points, weights) = drawn.hits();
    let weights: Vec<f64> = weights.iter().map(|weight| weight / count).collect();
    answer.regions = regions(mixture, &points, &weights);
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
}

/// The regions of the points that meet the event, the largest first.
pub(super) fn regions(mixture: &Mixture, points: &[Vec<f64>], weights: &[f64]) -> Vec<RegionShare> {
    let of = mixture.regions(points, weights);
    let region = |number: usize| {
        let members = || (0..points.len()).filter(|&k| of[k] == number);
        let share: f64 = members().map(|k| weights[k]).sum();
        let mean = |axis: usize| members().map(|k| weights[k] * points[k][axis]).sum::<f64>() / share;
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
    let all: f64 = weights.iter().sum();
    let mut regions: Vec<RegionShare> = (0..mixture.len()).filter_map(region).collect();
    // A component may follow what is no part of its own but the edge of another one.
    regions.retain(|region| region.share > NEGLIGIBLE * all);
    regions.sort_by(|a, b| b.share.total_cmp(&a.share));
    regions
}
