//! Whether the share of the sampled space that meets all criteria is as large as required.

use serde::{Deserialize, Serialize};

use super::interval::{Moments, of_mean};

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
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
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

/// The interval of a share of points that belong in turn to independent nets, given the count of each, or of independent
/// points, given one count (see [`of_mean`]).
pub fn randomised(counts: &[u64], points: u64, confidence: f64) -> [f64; 2] {
    let nets = counts.len().max(1) as u64;
    let size = |k: u64| points / nets + u64::from(k < points % nets);
    of_mean(
        &(0..)
            .zip(counts)
            .map(|(k, &hits)| Moments { count: size(k), sum: hits as f64, squares: hits as f64 })
            .collect::<Vec<Moments>>(),
        confidence,
    )
}

#[cfg(test)]
mod nets_tests;

#[cfg(test)]
mod tests;
