//! The largest deviation.

use super::Pair;

/// `max |m - r|`.
pub fn max_error(pair: &Pair) -> f64 {
    pair.deviations().map(f64::abs).fold(0.0, f64::max)
}
