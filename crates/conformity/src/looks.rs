//! How often a study looks at its points before it decides.
//!
//! An interval for a fixed number of points is right at that number only. Who looks again and again and stops when it
//! suits decides wrongly far more often than the confidence says. So each way of looking has its own interval, and a
//! study that was looked at before remembers it.

use serde::{Deserialize, Serialize};

use super::{
    decision::{Decision, Rule, randomised},
    interval::LEAST_SAMPLES,
    risk::Bands,
    sequence::ConfidenceSequence,
};

/// When the share of accepted points is looked at.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Way {
    /// Once, at a number of points that was fixed beforehand.
    #[default]
    Once,
    /// After every point; the points are independent.
    EveryPoint,
    /// Whenever the number of points has doubled; the points belong in turn to independent randomisations of a design.
    Doublings,
}

/// A verdict that was drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Look {
    /// How many points there were.
    pub points: u64,
    /// How they were looked at.
    pub way: Way,
    /// Whether the study waited for the verdict, so that it was looked at before this number of points, too.
    pub awaited: bool,
}

/// All verdicts that were drawn from the points of a study, in their order.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct History {
    /// The verdicts.
    pub looks: Vec<Look>,
}

/// A way of looking, with what earlier looks have used up of the probability of a wrong verdict.
///
/// The first look at a fixed number of points is wrong with half of what the confidence lacks to certainty, since only
/// one of the two verdicts can be wrong. All later looks together have the other half, so that the sum keeps within the
/// whole (Bonferroni's inequality).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Looks {
    /// When the share is looked at.
    pub way: Way,
    /// Whether there was a look at a fixed number of points before.
    after_fixed: bool,
    /// Earlier looks for which the study did not wait.
    unawaited: u32,
}

/// The points of each randomisation at the first look.
const FIRST: u64 = 16;

impl History {
    /// How the study may be looked at while its points come in, in a way that stays right at all numbers of points.
    pub fn awaiting(&self, way: Way) -> Looks {
        Looks::after(&self.looks, way)
    }

    /// The interval for the next verdict of a study without `--until`. The first verdict takes the interval for a fixed
    /// number of points, later ones take an interval that is right however often one looks. The same points once more are
    /// no further look.
    pub fn at(&self, points: u64, samples: usize) -> Looks {
        let same = self.looks.iter().rposition(|look| look.points == points);
        if let Some(place) = same {
            return Looks::after(&self.looks[..place], self.looks[place].way);
        }
        let way = match self.looks.len() {
            0 => Way::Once,
            _ if samples >= LEAST_SAMPLES => Way::Doublings,
            _ => Way::EveryPoint,
        };
        Looks::after(&self.looks, way)
    }

    /// Notes a verdict. Returns how many there are now.
    pub fn note(&mut self, look: Look) -> u64 {
        let known = |then: &&Look| {
            let same_way = then.way == look.way && then.awaited == look.awaited;
            then.points == look.points && (!look.awaited || same_way)
        };
        let place = self.looks.iter().rposition(|then| known(&then)).unwrap_or_else(|| {
            self.looks.push(look);
            self.looks.len() - 1
        });
        place as u64 + 1
    }
}

impl Looks {
    fn after(earlier: &[Look], way: Way) -> Self {
        let unawaited = earlier.iter().filter(|look| !look.awaited);
        Self {
            way,
            after_fixed: earlier.iter().any(|look| look.way == Way::Once),
            unawaited: u32::try_from(unawaited.count()).unwrap_or(u32::MAX),
        }
    }

    /// The confidence that is left.
    fn left(self, confidence: f64) -> f64 {
        if self.after_fixed { 0.5 + 0.5 * confidence } else { confidence }
    }

    /// A rule with the confidence that is left for going on after this look, however often one looks then.
    pub fn going_on(self, rule: Rule) -> Rule {
        let after_fixed = self.after_fixed || self.way == Way::Once;
        let next = Self { after_fixed, ..self };
        Rule { confidence: next.left(rule.confidence), ..rule }
    }

    /// The confidence for a guard band that is found from the same points. Each look has a part of its own of the
    /// probability to miss it: the first one all that it has, all later ones together as much again at the most.
    pub fn band_confidence(self, confidence: f64) -> f64 {
        match self.unawaited {
            0 => confidence,
            earlier => 1.0 - (1.0 - confidence) * spent(earlier),
        }
    }

    /// The interval of the share of accepted points, given their number in each sample.
    pub fn interval(self, accepted: &[u64], points: u64, confidence: f64) -> [f64; 2] {
        match self.way {
            Way::Once => randomised(accepted, points, confidence),
            Way::EveryPoint => {
                let confidence = self.left(confidence);
                ConfidenceSequence { confidence }.interval(accepted.iter().sum(), points)
            }
            Way::Doublings => {
                let look = doublings(accepted.len() as u64, points).saturating_add(self.unawaited);
                randomised(accepted, points, 1.0 - (1.0 - confidence) * spent(look))
            }
        }
    }

    /// The interval of the share that the right one of several guard bands accepts: from the least share that the widest
    /// of them may accept to the greatest that the narrowest may.
    pub fn interval_of_bands(self, bands: &Bands, points: u64, confidence: f64) -> [f64; 2] {
        let [low, _] = self.interval(&bands.accepted_at_least, points, confidence);
        let [_, high] = self.interval(&bands.accepted_at_most, points, confidence);
        [low, high]
    }

    /// The decision by that interval: at most one of both verdicts is drawn, since no band accepts more than a narrower
    /// one.
    pub fn decide_by_bands(self, rule: Rule, bands: &Bands, points: u64) -> Decision {
        let least = self.decide(rule, &bands.accepted_at_least, points);
        let most = self.decide(rule, &bands.accepted_at_most, points);
        match (least, most) {
            (Decision::Verified, _) => Decision::Verified,
            (_, Decision::NotVerified) => Decision::NotVerified,
            _ => Decision::Inconclusive,
        }
    }

    /// The decision by the interval for one guard band.
    pub fn decide(self, rule: Rule, accepted: &[u64], points: u64) -> Decision {
        if self.way != Way::EveryPoint {
            return rule.decide(self.interval(accepted, points, rule.confidence));
        }
        // The same as by the interval, whose ends take a search.
        let sequence = ConfidenceSequence { confidence: self.left(rule.confidence) };
        let hits: u64 = accepted.iter().sum();
        match (sequence.excludes(rule.share, hits, points), points) {
            (true, 1..) if hits as f64 / points as f64 > rule.share => Decision::Verified,
            (true, 1..) => Decision::NotVerified,
            _ => Decision::Inconclusive,
        }
    }

    /// Whether so many points of so many samples are a look.
    #[cfg(test)]
    pub fn is_due(self, samples: usize, points: u64) -> bool {
        match self.way {
            Way::Once => false,
            Way::EveryPoint => true,
            Way::Doublings => {
                let first = FIRST * samples as u64;
                points.is_multiple_of(first) && (points / first).is_power_of_two()
            }
        }
    }
}

/// How many times the first number of points has doubled when there are so many, and this time is over.
fn doublings(samples: u64, points: u64) -> u32 {
    points.div_ceil(FIRST * samples.max(1)).max(1).next_power_of_two().ilog2()
}

/// The part of the probability of a wrong decision that a look may use up: 1/2, 1/6, 1/12 ... add up to 1, so that all
/// looks together keep within the whole (Bonferroni's inequality).
pub fn spent(look: u32) -> f64 {
    let k = f64::from(look);
    1.0 / ((k + 1.0) * (k + 2.0))
}

#[cfg(test)]
mod tests;
