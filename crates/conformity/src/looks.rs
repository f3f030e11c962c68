//! How often a study looks at its points before it decides.
//!
//! An interval for a fixed number of points is right at that number only. Who looks again and again and stops when it
//! suits decides wrongly far more often than the confidence says. So each way of looking has its own interval.

use super::decision::{Decision, Rule, randomised};
use super::sequence::ConfidenceSequence;

/// When the share of accepted points is looked at.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Looks {
    /// Once, at a number of points that was fixed beforehand.
    #[default]
    Once,
    /// After every point; the points are independent.
    EveryPoint,
    /// Whenever the number of points has doubled; the points belong in turn to independent randomisations of a design.
    Doublings,
}

/// The points of each randomisation at the first look.
const FIRST: u64 = 16;

impl Looks {
    /// The fewest randomisations whose scatter is trusted at several looks.
    pub const LEAST_SAMPLES: u64 = 8;

    /// The interval of the share of accepted points, given their number in each sample.
    pub fn interval(self, accepted: &[u64], points: u64, confidence: f64) -> [f64; 2] {
        match self {
            Self::Once => randomised(accepted, points, confidence),
            Self::EveryPoint => {
                ConfidenceSequence { confidence }.interval(accepted.iter().sum(), points)
            }
            Self::Doublings => {
                let spent = spent(doublings(accepted.len() as u64, points));
                randomised(accepted, points, 1.0 - (1.0 - confidence) * spent)
            }
        }
    }

    /// The decision by that interval.
    pub fn decide(self, rule: Rule, accepted: &[u64], points: u64) -> Decision {
        if self != Self::EveryPoint {
            return rule.decide(self.interval(accepted, points, rule.confidence));
        }
        // The same as by the interval, whose ends take a search.
        let sequence = ConfidenceSequence {
            confidence: rule.confidence,
        };
        let hits: u64 = accepted.iter().sum();
        match (sequence.excludes(rule.share, hits, points), points) {
            (true, 1..) if hits as f64 / points as f64 > rule.share => Decision::Verified,
            (true, 1..) => Decision::NotVerified,
            _ => Decision::Inconclusive,
        }
    }

    /// Whether so many points of so many samples are a look.
    pub fn is_due(self, samples: usize, points: u64) -> bool {
        match self {
            Self::Once => false,
            Self::EveryPoint => true,
            Self::Doublings => {
                let first = FIRST * samples as u64;
                points.is_multiple_of(first) && (points / first).is_power_of_two()
            }
        }
    }
}

/// How many times the first number of points has doubled when there are so many, and this time is over.
fn doublings(samples: u64, points: u64) -> u32 {
    let times = points.div_ceil(FIRST * samples.max(1)).max(1);
    times.next_power_of_two().ilog2()
}

/// The part of the probability of a wrong decision that a look may use up: 1/2, 1/6, 1/12 ... add up to 1, so that all
/// looks together keep within the whole (Bonferroni's inequality).
fn spent(look: u32) -> f64 {
    let k = f64::from(look);
    1.0 / ((k + 1.0) * (k + 2.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn looks_spend_no_more_than_there_is() {
        let total: f64 = (0..1000).map(spent).sum();
        assert!(total < 1.0 && total > 0.998, "{total}");
    }

    #[test]
    fn looks_at_randomised_designs_are_doublings() {
        let due = (1..=5000).filter(|&points| Looks::Doublings.is_due(8, points));
        assert_eq!(due.collect::<Vec<_>>(), [128, 256, 512, 1024, 2048, 4096]);
        assert_eq!(
            [1, 128, 129, 256, 257].map(|n| doublings(8, n)),
            [0, 0, 1, 1, 2]
        );
        assert!(!Looks::Once.is_due(1, 100) && Looks::EveryPoint.is_due(1, 7));
    }

    #[test]
    fn intervals_of_several_looks_are_wider() {
        let accepted: Vec<u64> = (0..16).map(|k| 20 + k % 5).collect();
        let width = |looks: Looks| {
            let [low, high] = looks.interval(&accepted, 16 * 64, 0.95);
            high - low
        };
        assert!(width(Looks::Doublings) > 1.4 * width(Looks::Once));
        // The third look has a twelfth of 5 %.
        let alone = randomised(&accepted, 16 * 64, 1.0 - 0.05 / 12.0);
        assert_eq!(Looks::Doublings.interval(&accepted, 16 * 64, 0.95), alone);
    }

    #[test]
    fn decisions_are_those_of_the_interval() {
        let rule = Rule {
            share: 0.2,
            confidence: 0.95,
        };
        for points in [0, 1, 5, 40, 300] {
            for hits in 0..=points {
                let interval = Looks::EveryPoint.interval(&[hits], points, rule.confidence);
                let found = Looks::EveryPoint.decide(rule, &[hits], points);
                assert_eq!(found, rule.decide(interval), "{hits} of {points}");
            }
        }
    }
}
