//! Helpers for the tests of several methods.

use crate::method::{FirstOrder, Settled};
use sampling::statistics::estimate::Estimate;

/// A study of this size and seed.
pub(crate) fn settled(size: u64, seed: u64) -> Settled {
    Settled { size, estimator: FirstOrder::default(), seed }
}

/// Points of a lattice that any language can write down.
pub(crate) fn lattice(points: usize, dimensions: usize) -> Vec<Vec<f64>> {
    let primes = [2.0f64, 3.0, 5.0, 7.0, 11.0, 13.0, 17.0, 19.0];
    (1..=points).map(|k| primes[..dimensions].iter().map(|p| (k as f64 * p.sqrt()).fract()).collect()).collect()
}

/// Asserts that numbers are these, but for rounding.
#[track_caller]
pub(crate) fn near<const N: usize>(values: [f64; N], exact: [f64; N]) {
    let off = |(value, exact): (f64, f64)| (value - exact).abs();
    let most = values.into_iter().zip(exact).map(off);
    assert!(most.into_iter().all(|off| off < 1e-8), "{values:?} {exact:?}");
}

/// Asserts that an estimate and the ends of its interval are these, but for rounding.
#[track_caller]
pub(crate) fn holds(estimate: Estimate, exact: [f64; 3]) {
    near([estimate.value, estimate.low, estimate.high], exact);
}
