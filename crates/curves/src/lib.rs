#![doc = include_str!("../README.md")]

mod curve;
mod metrics;
mod sampler;

pub use curve::{Curve, Fault};
pub use metrics::{Kind, Metric, Pair, iso18571};
pub use sampler::Sampler;
