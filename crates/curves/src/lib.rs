//! Measured curves against simulated ones.
//!
//! A [`Curve`] is a measured signal, a [`Sampler`] takes the model's values at its times, and a [`Metric`] turns the
//! [`Pair`] into one number. [`delay`] finds how far one curve is behind the other.

mod curve;
pub mod delay;
mod metrics;
mod sampler;

pub use curve::{Curve, Fault};
pub use metrics::iso18571;
pub use metrics::{Kind, Metric, Pair};
pub use sampler::Sampler;

/// The README's example, as a test.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
