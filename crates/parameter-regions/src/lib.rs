//! Where in the space of its parameters a model conforms.
//!
//! A [`table::PointTable`] holds what was sampled and what came out. From it, [`robustness`] finds the largest box and
//! ellipsoid in which the model conforms with a wanted probability, maps and margins; [`pareto`] the trade-off between
//! criteria; [`tolerances`] the widest tolerances of the parameters.
//!
//! Nothing here runs a model. Probabilities refer to the distributions that the points were drawn from.

pub mod pareto;
pub mod robustness;
pub mod table;
pub mod tolerances;

/// The README's example, as a test.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
