//! The interface of a design: a rule that gives every point its place.

use std::fmt::Debug;

use super::{correlation::Correlation, joint::Joint, sampling::Sampling};
use crate::distribution::Distribution;

/// A rule that gives every point a place in the unit cube.
pub trait Rule: Debug + Send + Sync {
    /// The coordinate of a point in (0, 1).
    fn uniform(&self, index: u64, dimension: u32) -> f64;
}

/// A rule as it is registered.
pub trait Registered: Rule + Sized + 'static {
    /// Whether the first points stay the same when there are more: then fewer may be enough.
    const EXTENSIBLE: bool = false;

    /// Whether the points can belong in turn to independent randomisations.
    const REPLICATES: bool = false;

    /// The fewest points of which any count scatters no more than that of independent ones, so that their intervals hold.
    const INDEPENDENT_FROM: u64 = u64::MAX;

    /// The rule for the points of a study.
    ///
    /// # Errors
    /// When it cannot serve this number of inputs or points.
    fn new(sampling: &Sampling, inputs: &Inputs) -> Result<Self, String>;
}

/// The inputs of a design: distributions, correlations.
#[derive(Clone, Debug, Default)]
pub struct Inputs {
    /// Their distributions.
    pub distributions: Vec<Distribution>,
    /// How they are correlated, if they are.
    pub correlation: Option<Correlation>,
    /// Those that are drawn together from samples.
    pub joints: Vec<Joint>,
}

impl Inputs {
    /// How many of them vary.
    pub fn dimensions(&self) -> usize {
        self.distributions.iter().filter(|input| input.varies()).count()
    }
}

impl From<Vec<Distribution>> for Inputs {
    fn from(distributions: Vec<Distribution>) -> Self {
        Self { distributions, ..Self::default() }
    }
}
