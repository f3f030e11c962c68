//! Independent random points.

use super::{
    rule::{Inputs, Registered, Rule},
    sampling::Sampling,
};
use crate::random::{Purpose, uniform};

/// Independent points.
#[derive(Debug)]
pub struct Independent {
    seed: u64,
}

impl Registered for Independent {
    const EXTENSIBLE: bool = true;
    const INDEPENDENT_FROM: u64 = 0;

    fn new(sampling: &Sampling, _: &Inputs) -> Result<Self, String> {
        Ok(Self { seed: sampling.seed })
    }
}

impl Rule for Independent {
    fn uniform(&self, index: u64, dimension: u32) -> f64 {
        uniform(self.seed, Purpose::Point, index, dimension)
    }
}
