//! The share of the event by draws and searches together, where the mixture follows a part of the event only.
//!
//! Draws tell the part that the mixture follows: there all weights are bounded. Searches that the mixture knows nothing of
//! tell which part of the event that is, by the points that they come to: a search's own share scatters far more.

use statrs::distribution::{ContinuousCDF, StudentsT};

use super::draws::{draw, weight};
use super::gather::{DRAWS, FEWEST, Gathered};
use super::runs::Runs;
use super::weigh::regions;
use super::{Answer, Method, Search, Share, Weighted};
use crate::random::Random;

const MOST: usize = 8;
/// Chance leaves a part of so much unseen.
const UNSEEN: f64 = 0.02;
/// The widest interval that tells anything: it ends at the share divided and multiplied by this.
const WIDEST: f64 = 3.0;

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
        parts.push((found.share, 1.0 - missed.len() as f64 / all));
        outside.extend(missed);
    }
    if parts.len() < FEWEST {
        return Ok(false);
    }
    let count = runs.left();
    let mut drawn = draw(&from, count, runs, random)?;
    let too_large = drawn.weights.iter_mut().filter(|weight| **weight > limit);
    too_large.for_each(|weight| *weight = 0.0);
    let count = count as f64;
    let inside = drawn.mean();
    let Some(share) = joined(&parts, inside, drawn.scatter() / count, search.confidence) else {
        return Ok(false);
    };
    let (mut points, mut weights) = drawn.hits();
    weights.iter_mut().for_each(|weight| *weight /= count);
    let each = (share.value - inside) / outside.len() as f64;
    weights.resize(points.len() + outside.len(), each);
    points.extend(outside);
    answer.regions = regions(&gathered.mixture, &points, &weights);
    let pairs = points.into_iter().zip(weights);
    let sample = pairs.map(|(scores, weight)| Weighted { scores, weight });
    answer.sample = sample.collect();
    answer.share = Some(share);
    Ok(true)
}

/// The share of which draws tell a part, with a relative variance, and each search, with its own share, which part that is.
/// A search counts by its share: one that came to little of the event knows little of its parts. None where the interval is
/// too wide.
fn joined(parts: &[(f64, f64)], inside: f64, variance: f64, confidence: f64) -> Option<Share> {
    let count = parts.len() as f64;
    let all: f64 = parts.iter().map(|(share, _)| share).sum();
    let part = parts.iter().map(|(share, p)| share * p).sum::<f64>() / all;
    let apart = parts.iter().map(|(share, p)| share / all * (p - part));
    let squares: f64 = apart.map(|apart| apart * apart).sum();
    let deviation = (squares * count / (count - 1.0)).sqrt().max(UNSEEN);
    let error = (variance + (deviation / part).powi(2)).sqrt();
    let student = StudentsT::new(0.0, 1.0, count - 1.0).ok()?;
    let half = student.inverse_cdf(0.5 + 0.5 * confidence) * error;
    let value = inside / part;
    // Nothing is less than what is no number: where no draw or no search met the event.
    (half < WIDEST.ln()).then(|| Share {
        value,
        interval: Some([value * (-half).exp(), (value * half.exp()).min(1.0)]),
        error,
        effective: error.powi(-2),
        method: Method::Bridged,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_part_that_draws_do_not_tell_is_added_with_its_scatter() {
        let share = joined(
            &[0.9, 0.7, 0.8, 0.8].map(|part| (2e-7, part)),
            8e-8,
            1e-4,
            0.95,
        )
        .unwrap();
        assert!((share.value - 1e-7).abs() < 1e-20);
        // The deviation of the mean of the parts is 0.0408; Student's quantile with 3 degrees of freedom is 3.182.
        let error = (1e-4_f64 + 0.040_824_829_f64.powi(2) / 0.64).sqrt();
        assert!((share.error - error).abs() < 1e-8);
        let [low, high] = share.interval.unwrap();
        let half = 3.182_446 * error;
        assert!(
            (low / 1e-7 - (-half).exp()).abs() < 1e-6 && (high / 1e-7 - half.exp()).abs() < 1e-6
        );
        // A search counts by its share.
        let parts = [(1e-7, 0.8), (1e-7, 0.8), (1e-7, 0.8), (0.0, 0.1)];
        assert!((joined(&parts, 8e-8, 0.0, 0.95).unwrap().value - 1e-7).abs() < 1e-20);
        // Searches that all see the same may lose the same.
        let error = joined(&[(1e-7, 1.0); 4], 1e-7, 0.0, 0.95).unwrap().error;
        assert_eq!(error, UNSEEN);
        assert_eq!(
            joined(
                &[1.0, 0.1, 0.2, 0.9].map(|part| (2e-7, part)),
                1e-7,
                1e-4,
                0.95
            ),
            None
        );
        assert_eq!(joined(&[(1e-7, 1.0); 4], 0.0, f64::NAN, 0.95), None);
        assert_eq!(joined(&[(1e-7, 0.0); 4], 0.0, 1e-4, 0.95), None);
    }
}
