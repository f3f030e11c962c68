//! The root of the mean square of the deviations, divided by the reference's range or mean, or by a given value.

use super::rmse::Rmse;
use super::{Compare, Kind, Pair};

/// The rmse divided by [`Pair::normaliser`].
pub(super) struct Nrmse;

impl Compare for Nrmse {
    const LABEL: &'static str = "normalised rmse";
    const KIND: Kind = Kind::Relative;

    fn compare(pair: &Pair<'_>) -> f64 {
        Rmse::compare(pair) / pair.normaliser
    }
}
