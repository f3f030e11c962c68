//! The largest deviation.

use super::{Compare, Kind, Pair};

/// `max |m - r|`.
pub(super) struct MaxError;

impl Compare for MaxError {
    const LABEL: &'static str = "largest deviation";
    const KIND: Kind = Kind::Error;

    fn compare(pair: &Pair<'_>) -> f64 {
        pair.deviations().map(f64::abs).fold(0.0, f64::max)
    }
}
