//! The share of the event by draws and searches together, where the mixture follows a part of the event only.
//!
//! Draws tell the part that the mixture follows: there all weights are bounded. Searches that the mixture knows nothing of
//! tell which part of the event that is, by the points that they come to: a search's own share scatters far more.

use statrs::distribution::{ContinuousCDF, StudentsT};

use super::draws::{draw, weight};
use super::gather::{DRAWS, FEWEST, Gathered};
use super::mixture::Mixture;
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
        let modes = Mixture::of_chains(&found.points).effective();
        let points = found.points.into_iter();
        let missed: Vec<Vec<f64>> = points.filter(|p| weight(p, &from) > limit).collect();
        let part = 1.0 - missed.len() as f64 / all;
        parts.push(Part { share: found.share, part, modes });
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

/// What a search tells of the event's parts.
#[derive(Clone, Copy)]
struct Part {
    /// The share of the event, as the search has it.
    share: f64,
    /// The part of its points that the mixture follows.
    part: f64,
    /// In how many equal places its points lie.
    modes: f64,
}

/// The share of which draws tell a part, with a relative variance, and each search, with its own share, which part that is.
/// A search counts by its share: one that came to little of the event knows little of its parts. None where the interval is
/// too wide.
///
/// Searches that each came to a few of many places may agree by chance. So their part is known no better than from as many
/// draws as they have places (Agresti and Coull 1998: two more of either kind at 95 %, here one, as Student's quantile follows).
fn joined(parts: &[Part], inside: f64, variance: f64, confidence: f64) -> Option<Share> {
    let count = parts.len() as f64;
    let all: f64 = parts.iter().map(|p| p.share).sum();
    let part = parts.iter().map(|p| p.share * p.part).sum::<f64>() / all;
    let apart = parts.iter().map(|p| p.share / all * (p.part - part));
    let squares: f64 = apart.map(|apart| apart * apart).sum();
    let observed = (squares * count / (count - 1.0)).sqrt();
    let places = parts.iter().map(|p| (p.share / all).powi(2) / p.modes);
    let places = places.sum::<f64>().recip();
    let likely = (places * part + 1.0) / (places + 2.0);
    let by_chance = (likely * (1.0 - likely) / (places + 2.0)).sqrt();
    let deviation = observed.max(by_chance).max(UNSEEN);
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

    fn parts(all: &[f64], modes: f64) -> Vec<Part> {
        let part = |&part: &f64| Part { share: 2e-7, part, modes };
        all.iter().map(part).collect()
    }

    #[test]
    fn the_part_that_draws_do_not_tell_is_added_with_its_scatter() {
        let share = joined(&parts(&[0.9, 0.7, 0.8, 0.8], 1e3), 8e-8, 1e-4, 0.95).unwrap();
        assert!((share.value - 1e-7).abs() < 1e-20);
        // The deviation of the mean of the parts is 0.0408; Student's quantile with 3 degrees of freedom is 3.182.
        let error = (1e-4_f64 + 0.040_824_829_f64.powi(2) / 0.64).sqrt();
        assert!((share.error - error).abs() < 1e-8);
        let [low, high] = share.interval.unwrap();
        let half = 3.182_446 * error;
        assert!((low / 1e-7 - (-half).exp()).abs() < 1e-6 && (high / 1e-7 - half.exp()).abs() < 1e-6);
        // A search counts by its share.
        let mut uneven = parts(&[0.8, 0.8, 0.8, 0.1], 1e3);
        uneven[3].share = 0.0;
        assert!((joined(&uneven, 8e-8, 0.0, 0.95).unwrap().value - 1e-7).abs() < 1e-20);
        // Searches that all see the same may lose the same.
        let error = joined(&parts(&[1.0; 4], 1e6), 1e-7, 0.0, 0.95).unwrap().error;
        assert_eq!(error, UNSEEN);
        let few = parts(&[1.0, 0.1, 0.2, 0.9], 1e3);
        assert_eq!(joined(&few, 1e-7, 1e-4, 0.95), None);
        assert_eq!(joined(&parts(&[1.0; 4], 1e3), 0.0, f64::NAN, 0.95), None);
        assert_eq!(joined(&parts(&[0.0; 4], 1e3), 0.0, 1e-4, 0.95), None);
    }

    /// Four searches of two equal places each are as eight draws, of which 7.2 met: (7.2 + 1) / (8 + 2), with the deviation of
    /// ten draws.
    #[test]
    fn searches_of_few_places_may_agree_by_chance() {
        let share = joined(&parts(&[0.9; 4], 2.0), 9e-8, 0.0, 0.95).unwrap();
        let error = (0.82_f64 * 0.18 / 10.0).sqrt() / 0.9;
        assert!((share.error - error).abs() < 1e-12, "{share:?}");
    }
}
