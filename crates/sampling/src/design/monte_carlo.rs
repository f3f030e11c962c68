//! Independent random points.

use super::rule::{Inputs, Numbers, Registered, Rule};
use crate::random::{Purpose, uniform};

/// Independent points.
#[derive(Debug)]
pub struct Independent {
    seed: u64,
}

impl Registered for Independent {
    const EXTENSIBLE: bool = true;
    const INDEPENDENT_FROM: u64 = 0;

    fn new(numbers: &Numbers, _: &Inputs) -> Result<Self, String> {
        let seed = numbers.seed;
        Ok(Self { seed })
    }
}

impl Rule for Independent {
    fn uniform(&self, index: u64, dimension: u32) -> f64 {
        uniform(self.seed, Purpose::Point, index, dimension)
    }
}
