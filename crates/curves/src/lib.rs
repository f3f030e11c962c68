#![doc = include_str!("../README.md")]

mod curve;
pub mod delay;
mod metrics;
mod sampler;

pub use curve::{Curve, Fault};
pub use metrics::iso18571;
pub use metrics::{Kind, Metric, Pair};
pub use sampler::Sampler;
