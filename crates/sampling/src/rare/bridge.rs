//! The share of the event by draws and searches together, where the mixture follows a part of the event only.
//!
//! Draws tell the part that the mixture follows: there all weights are bounded. Searches that the mixture knows nothing of
//! tell which part of the event that is, by the points that they come to: a search's own share scatters far more.

use statrs::distribution::{ContinuousCDF, StudentsT};

use super::draws::{draw, weight};
use super::gather::Gathered;
use super::runs::Runs;
use super::weigh::regions;
use super::{Answer, Method, Search, Share, Weighted};
use crate::random::Random;

/// Fewer searches do not tell how they scatter.
const FEWEST: usize = 4;
const MOST: usize = 8;
/// This part of all runs is left for the draws.
const DRAWS: u64 = 12;
/// Chance leaves a part of so much unseen.
const UNSEEN: f64 = 0.02;
/// The widest interval that tells anything: it ends at the share divided and multiplied by this.
const WIDEST: f64 = 3.0;

/// The runs that must be left for this before another search is gathered, where one takes so many: with all that follows it,
/// that takes as many as two or three.
pub(super) fn needed(search: &Search, of_search: u64) -> u64 {
    (FEWEST as u64 + 3) * of_search + search.runs / DRAWS
}

/// States the share with the runs that are left; false where they do not tell it.
pub(super) fn tell<E>(
    gathered: &mut Gathered,
    search: &Search,
    size: usize,
    runs: &mut Runs<'_, E>,
    random: &mut Random,
    answer: &mut Answer,
) -> Result<bool, E> {
    let from = gathered.proposal();
    let limit = gathered.limit();
    let mut parts = Vec::new();
    let mut outside = Vec::new();
    while parts.len() < MOST && runs.left() > gathered.dearest + search.runs / DRAWS {
        let Some(found) = gathered.reach(None, search, size, runs, random, answer)? else {
            break;
        };
        let all = found.points.len() as f64;
        let points = found.points.into_iter();
        let missed: Vec<Vec<f64>> = points.filter(|p| weight(p, &from) > limit).collect();
        parts.push(1.0 - missed.len() as f64 / all);
        outside.extend(missed);
    }
    if parts.len() < FEWEST {
        return Ok(false);
    }
    let mut drawn = draw(&from, runs.left(), runs, random)?;
    for weight in &mut drawn.weights {
        if *weight > limit {
            *weight = 0.0;
        }
    }
    let (draws, inside, scatter) = (drawn.weights.len() as f64, drawn.mean(), drawn.scatter());
    let count = parts.len() as f64;
    let part = parts.iter().sum::<f64>() / count;
    let squares: f64 = parts.iter().map(|p| (p - part).powi(2)).sum();
    let deviation = (squares / (count - 1.0) / count).sqrt().max(UNSEEN);
    let error = (scatter / draws + (deviation / part).powi(2)).sqrt();
    let half = StudentsT::new(0.0, 1.0, count - 1.0).map_or(f64::INFINITY, |t| {
        t.inverse_cdf(0.5 + 0.5 * search.confidence) * error
    });
    // No comparison holds where no draw or no search met the event.
    if !(half < WIDEST.ln()) {
        return Ok(false);
    }
    let value = inside / part;
    let (mut points, weights) = drawn.hits();
    let mut weights: Vec<f64> = weights.iter().map(|weight| weight / draws).collect();
    weights.resize(
        points.len() + outside.len(),
        (value - inside) / outside.len() as f64,
    );
    points.append(&mut outside);
    answer.regions = regions(&gathered.mixture, &points, &weights);
    let pairs = points.into_iter().zip(weights);
    let sample = pairs.map(|(scores, weight)| Weighted { scores, weight });
    answer.sample = sample.collect();
    answer.share = Some(Share {
        value,
        interval: Some([value * (-half).exp(), (value * half.exp()).min(1.0)]),
        error,
        effective: error.powi(-2),
        method: Method::Bridged,
    });
    Ok(true)
}
