//! The root of the mean square of the deviations.

use super::{Compare, Kind, Pair};

/// `sqrt(mean((m - r)^2))`; every time of the reference counts the same, however far apart they are.
pub(super) struct Rmse;

impl Compare for Rmse {
    const LABEL: &'static str = "rmse";
    const KIND: Kind = Kind::Error;

    fn compare(pair: &Pair<'_>) -> f64 {
        let squares: f64 = pair
            .deviations()
            .map(|deviation| deviation * deviation)
            .sum();
        (squares / pair.reference.len() as f64).sqrt()
    }
}
