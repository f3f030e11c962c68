//! Whether the share of the sampled space that meets all criteria is as large as required.

use serde::{Deserialize, Serialize};

use super::interval::{LEAST_SAMPLES, clopper_pearson, of_samples, wider};

/// The decision about a model.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Decision {
    /// The share is at least the required one.
    Verified,
    /// The share is less than the required one.
    #[serde(rename = "not verified")]
    NotVerified,
    /// The points do not tell.
    Inconclusive,
}

impl std::fmt::Display for Decision {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::Verified => "verified",
            Self::NotVerified => "not verified",
            Self::Inconclusive => "inconclusive",
        })
    }
}

/// How it is decided: the interval of the share must lie on one side of the required share.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Rule {
    /// The required share of the sampled space.
    pub share: f64,
    /// The probability with which the interval holds the true share.
    pub confidence: f64,
}

impl Rule {
    /// The decision by the share's interval. At most one of the two wrong decisions is possible at
    /// any true share, so that the probability of a wrong one is half of what the interval lacks to
    /// certainty.
    pub fn decide(&self, [low, high]: [f64; 2]) -> Decision {
        if low >= self.share {
            Decision::Verified
        } else if high < self.share {
            Decision::NotVerified
        } else {
            Decision::Inconclusive
        }
    }
}

/// The interval of a share of points that belong in turn to independent randomisations of a design, given the count of
/// each: the one [of their shares](of_samples). Where nearly all counts are equal, or the points are hardly more than the
/// randomisations, the scatter tells little, and the interval is no narrower than that of as many independent trials (see
/// [`clopper_pearson`]). Fewer than [`LEAST_SAMPLES`] counts are those of independent points.
pub fn randomised(counts: &[u64], points: u64, confidence: f64) -> [f64; 2] {
    const FEW: u64 = 4;
    let (n, total) = (counts.len() as u64, counts.iter().sum::<u64>());
    let independent = clopper_pearson(total as f64, points as f64, confidence);
    if counts.len() < LEAST_SAMPLES || points < n {
        return independent;
    }
    let size = |k: u64| points / n + u64::from(k < points % n);
    let shares = (0..).zip(counts).map(|(k, &count)| count as f64 / size(k) as f64);
    let shares: Vec<f64> = shares.collect();
    let ends = of_samples(total as f64 / points as f64, &shares, points, confidence);
    let tells_little = total.min(points - total) < n || unequal(counts) < FEW;
    if tells_little { wider(ends, independent) } else { ends }
}

/// The interval of the probability that another sample of as many independent points would come to the other verdict by
/// the one-point rule: without an accepted point where this one has some, with one where this one has none.
///
/// That probability follows from the share of accepted points, of which the sample tells an [interval](clopper_pearson),
/// whatever the share was held for before. A few accepted points tell next to nothing of it.
pub fn other_verdict(accepted: u64, points: u64, confidence: f64) -> [f64; 2] {
    let shares = clopper_pearson(accepted as f64, points as f64, confidence);
    let [some, none] = shares.map(|share| (1.0 - share).powf(points as f64));
    if accepted > 0 { [none, some] } else { [1.0 - some, 1.0 - none] }
}

/// How many counts differ from the most frequent one.
fn unequal(counts: &[u64]) -> u64 {
    let equal = |count: &u64| counts.iter().filter(|other| *other == count).count();
    (counts.len() - counts.iter().map(equal).max().unwrap_or(0)) as u64
}

#[cfg(test)]
mod nets_tests;

#[cfg(test)]
mod tests;
