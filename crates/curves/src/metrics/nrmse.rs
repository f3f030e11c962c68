//! The root of the mean square of the deviations, divided by the reference's range or mean, or by a given value.

use super::{Pair, rmse::rmse};

/// The rmse divided by [`Pair::normaliser`].
pub fn nrmse(pair: &Pair) -> f64 {
    rmse(pair) / pair.normaliser
}
