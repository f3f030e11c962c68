//! What is asked of a run.

use crate::surrogate::Run;

/// A requirement: an output lies within both ends. Infinite ends are none.
#[derive(Clone, Copy, Debug)]
pub struct Limit {
    /// The number of the output.
    pub output: usize,
    /// The least and the largest value that are good.
    pub range: [f64; 2],
}

impl Limit {
    pub(crate) fn margin(&self, value: f64) -> f64 {
        (value - self.range[0]).min(self.range[1] - value)
    }

    /// Whether a run is good: it succeeded, and no margin is negative.
    pub fn are_kept(limits: &[Self], run: &Run) -> bool {
        run.finite().is_some_and(|values| limits.iter().all(|limit| limit.margin(values[limit.output]) >= 0.0))
    }
}

/// What may become of a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Event {
    /// It succeeds and keeps all limits.
    Kept,
    /// It succeeds and misses a limit.
    Missed,
    /// It fails.
    Failed,
}

impl Event {
    /// Whether a run is one.
    pub fn is(self, limits: &[Limit], run: &Run) -> bool {
        match self {
            Self::Kept => Limit::are_kept(limits, run),
            Self::Missed => run.finite().is_some() && !Limit::are_kept(limits, run),
            Self::Failed => run.finite().is_none(),
        }
    }
}
