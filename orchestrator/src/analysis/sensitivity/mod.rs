//! Which parameter matters: one method a file.
//!
//! [`sobol`] and [`morris`] need runs of their own design; [`rank`], [`pawn`] and [`regional`]
//! work on any points that already exist. A failed run (a value that is not finite) is left out
//! together with what it is compared with, and counted; it never spoils an index without a word.

pub mod morris;
pub mod pawn;
pub mod rank;
pub mod regional;
pub mod sobol;
pub mod stats;
pub mod study;

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
pub(crate) mod functions {
    //! Test functions with known indices.
    use std::f64::consts::PI;

    /// Ishigami & Homma (1990), a = 7, b = 0.1; inputs in the unit cube.
    pub fn ishigami(u: &[f64]) -> f64 {
        let x: Vec<f64> = u.iter().map(|v| PI * (2.0 * v - 1.0)).collect();
        x[0].sin() + 7.0 * x[1].sin().powi(2) + 0.1 * x[2].powi(4) * x[0].sin()
    }

    /// Its first-order and total indices.
    pub fn ishigami_indices() -> ([f64; 3], [f64; 3]) {
        let (a, b) = (7.0f64, 0.1f64);
        let v1 = 0.5 * (1.0 + b * PI.powi(4) / 5.0).powi(2);
        let v2 = a * a / 8.0;
        let v13 = b * b * PI.powi(8) * (1.0 / 18.0 - 1.0 / 50.0);
        let v = v1 + v2 + v13;
        ([v1 / v, v2 / v, 0.0], [(v1 + v13) / v, v2 / v, v13 / v])
    }

    /// Sobol's g-function (Saltelli & Sobol 1995); inputs in the unit cube.
    pub fn sobol_g(u: &[f64], a: &[f64]) -> f64 {
        u.iter()
            .zip(a)
            .map(|(x, a)| ((4.0 * x - 2.0).abs() + a) / (1.0 + a))
            .product()
    }

    /// Its first-order and total indices.
    pub fn sobol_g_indices(a: &[f64]) -> (Vec<f64>, Vec<f64>) {
        let parts: Vec<f64> = a.iter().map(|a| 1.0 / (3.0 * (1.0 + a).powi(2))).collect();
        let all: f64 = parts.iter().map(|v| 1.0 + v).product();
        let v = all - 1.0;
        (
            parts.iter().map(|p| p / v).collect(),
            parts.iter().map(|p| p * (all / (1.0 + p)) / v).collect(),
        )
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
