//! The root of the mean square of the deviations.

use super::Pair;

/// `sqrt(mean((m - r)^2))`; every time of the reference counts the same, however far apart they are.
pub fn rmse(pair: &Pair) -> f64 {
    let squares: f64 = pair.deviations().map(|off| off * off).sum();
    (squares / pair.reference.len() as f64).sqrt()
}
