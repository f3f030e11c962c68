//! Global sensitivity analysis: which parameter of a model matters, and how much, with intervals.
//!
//! One method a file. [`sobol`], [`morris`] and [`shapley`] need runs of their own design ([`method::FromRuns`]); [`rank`],
//! [`pawn`] and [`regional`] work on any points that already exist ([`method::FromPoints`]). A failed run (a value that is
//! not finite) is left out with the comparisons that need it. The result says how many there were, what the numbers then
//! mean, and between which bounds they would lie if the failed runs had values ([`lost`]).

pub mod functions;
pub mod lost;
pub mod method;
pub mod methods;
pub mod morris;
pub mod pairs;
pub mod pawn;
pub mod rank;
mod rare;
pub mod ratio;
pub mod regional;
pub mod shapley;
pub mod sobol;

/// The README's example, as a test.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;

use serde::{Deserialize, Serialize};

/// A number with its 95 % interval.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Estimate {
    /// The estimate.
    #[serde(deserialize_with = "or_not_a_number")]
    pub value: f64,
    /// Lower end of the interval.
    #[serde(deserialize_with = "or_not_a_number")]
    pub low: f64,
    /// Upper end of the interval.
    #[serde(deserialize_with = "or_not_a_number")]
    pub high: f64,
}

/// JSON has no word for a number that is none but `null`.
fn or_not_a_number<'de, D: serde::Deserializer<'de>>(from: D) -> Result<f64, D::Error> {
    Ok(Option::deserialize(from)?.unwrap_or(f64::NAN))
}

impl Estimate {
    /// An estimate with a symmetric interval.
    pub fn around(value: f64, half: f64) -> Self {
        Self {
            value,
            low: value - half,
            high: value + half,
        }
    }

    /// Whether the interval holds a value.
    pub fn contains(&self, value: f64) -> bool {
        self.low <= value && value <= self.high
    }
}

/// Whether an order of importance can be told: `None` where the interval of the largest estimate
/// overlaps the next one's, else the index of the largest.
pub fn dominant(estimates: &[Estimate]) -> Option<usize> {
    let mut order: Vec<usize> = (0..estimates.len())
        .filter(|&i| estimates[i].value.is_finite())
        .collect();
    order.sort_by(|&a, &b| estimates[b].value.total_cmp(&estimates[a].value));
    match order.as_slice() {
        [first, second, ..] => (estimates[*first].low > estimates[*second].high).then_some(*first),
        [only] => Some(*only),
        [] => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_verdict_on_overlapping_intervals() {
        let sure = [Estimate::around(0.8, 0.1), Estimate::around(0.3, 0.1)];
        let unsure = [Estimate::around(0.8, 0.3), Estimate::around(0.5, 0.2)];
        assert_eq!(dominant(&sure), Some(0));
        assert_eq!(dominant(&unsure), None);
        assert_eq!(dominant(&[]), None);
    }
}
