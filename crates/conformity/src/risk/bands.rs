//! The guard bands that may be the right one of a population, by a sample of its points.
//!
//! The right guard band is the least one with which no more of the accepted points of the whole population fail to
//! conform than may. A sample tells it with an error. The share of accepted points at the band that the sample finds
//! scatters with that band, too, so that an interval that takes the band as given is too narrow.

use super::{Acceptance, Guard};
use crate::{
    interval::{Moments, of_part},
    measured::Measured,
};

/// Both ends of the guard bands that may be the right one.
#[derive(Clone, Debug, PartialEq)]
pub struct Bands {
    /// The narrowest guard band and the widest one, in expanded uncertainties; the latter is infinite where the points do
    /// not show of any band that it is enough.
    pub factors: [f64; 2],
    /// The points of each sample that the widest of them accepts.
    pub accepted_at_least: Vec<u64>,
    /// The points of each sample that the narrowest of them accepts.
    pub accepted_at_most: Vec<u64>,
}

impl Bands {
    /// A single band, which accepts these points of each sample.
    pub(super) fn one(factor: f64, accepted: &[u64]) -> Self {
        Self { factors: [factor; 2], accepted_at_least: accepted.to_vec(), accepted_at_most: accepted.to_vec() }
    }
}

/// The points that a guard band accepts.
struct Accepted {
    /// The narrowest and the widest band that accept no others.
    steps: [usize; 2],
    /// The largest probabilities not to conform that any values can have that these bands accept.
    worst: [f64; 2],
    parts: Vec<Moments>,
}

impl Accepted {
    fn count(&self) -> u64 {
        self.parts.iter().map(|part| part.count).sum()
    }

    fn by_sample(&self) -> Vec<u64> {
        self.parts.iter().map(|part| part.count).collect()
    }

    /// The interval of the probability that a point does not conform that the narrowest band accepts.
    fn interval(&self, confidence: f64) -> [f64; 2] {
        let [worst, _] = self.worst;
        let unit: Vec<Moments> = self.parts.iter().map(|part| part.scaled(1.0 / worst)).collect();
        of_part(&unit, confidence).map(|end| end * worst)
    }
}

/// The guard bands that may be the right one: each end misses it with half of what the confidence lacks to certainty.
///
/// Given how many points a fixed band accepts, these are a sample of their own. So the hypothesis that the right band is
/// a certain one can be tested by the mean over the points that it accepts, and the bands are tried one after the other:
/// - from none at all upwards, until the first of which the points don't show that it is too little;
/// - from one downwards that is enough for any population, until the first of which the points don't show that it is
///   enough.
///
/// The right band is one of those that are tried, if the order gets so far, and only its own test decides whether the
/// order gets past it. So many tests are no more often wrong than one (fixed sequence: Maurer, Hothorn and Lehmacher
/// 1995, "Multiple comparisons in drug clinical trials and preclinical assays: a-priori ordered hypotheses").
///
/// A band that is enough for any population accepts no point where several criteria all lie near their limits. With
/// many points the order begins at the band that accepts the first few of them instead; how many is fixed beforehand,
/// and given the band, these are a sample, too.
///
/// Without a confidence the points are no sample: any band may be the right one then, but one that is enough for any
/// population.
pub fn allowed(all: &Acceptance, criteria: &[Measured], limit: f64, confidence: Option<f64>) -> Bands {
    let sets = sets(all, criteria);
    let factor = |step: usize| step as f64 * Guard::STEP;
    let too_little = |set: &&Accepted| confidence.is_some_and(|confidence| set.interval(confidence)[0] > limit);
    let first = sets.iter().rev().find(|set| !too_little(set));
    let enough = enough(&sets, limit, confidence);
    let none = || vec![0; all.samples];
    Bands {
        factors: [
            // Of a band that accepts no point the points tell nothing.
            factor(first.map_or(all.within.len(), |set| set.steps[0])),
            enough.map_or(f64::INFINITY, |(step, _)| factor(step)),
        ],
        accepted_at_least: enough.map_or_else(none, |(_, set)| set.by_sample()),
        accepted_at_most: first.map_or_else(none, Accepted::by_sample),
    }
}

/// The narrowest band of which the sample shows that it is enough, with the points that it accepts.
fn enough(sets: &[Accepted], limit: f64, confidence: Option<f64>) -> Option<(usize, &Accepted)> {
    // Of so many points those that a sample may have missed count little beside the limit.
    const FIRST: f64 = 10.0;
    let first = (FIRST / limit).ceil() as u64;
    let many = sets.last().is_some_and(|all| all.count() >= first);
    let mut narrowest = None;
    for set in sets {
        let certain = set.worst.map(|worst| worst <= limit);
        if certain[1] {
            narrowest = Some((set.steps[1], set));
        }
        if !certain[0] {
            if many && set.count() < first {
                continue;
            }
            if confidence.is_none_or(|confidence| set.interval(confidence)[1] > limit) {
                break;
            }
        }
        narrowest = Some((set.steps[0], set));
    }
    narrowest
}

/// The sets of points that guard bands accept, from the widest band to none.
fn sets(all: &Acceptance, criteria: &[Measured]) -> Vec<Accepted> {
    let steps: Vec<usize> =
        (0..all.within.len()).rev().filter(|step| all.within[*step].iter().any(|part| part.count > 0)).collect();
    let mut parts = vec![Moments::default(); all.samples];
    let mut sets = Vec::with_capacity(steps.len());
    for (k, &step) in steps.iter().enumerate() {
        parts.iter_mut().zip(&all.within[step]).for_each(|(sum, more)| sum.merge(*more));
        let steps = [steps.get(k + 1).map_or(0, |next| next + 1), step];
        sets.push(Accepted {
            steps,
            worst: steps.map(|step| worst(criteria, step as f64 * Guard::STEP)),
            parts: parts.clone(),
        });
    }
    sets
}

/// The largest probability not to conform of any values with at least this margin, by Boole's inequality.
fn worst(criteria: &[Measured], margin: f64) -> f64 {
    criteria.iter().map(|criterion| criterion.most_not_conforming(margin).unwrap_or(1.0)).sum::<f64>().min(1.0)
}
