//! Even steps that are handed over together.

use std::ops::Range;

use crate::task::CommunicationPoints;

/// Even steps that are handed over together.
#[derive(Debug, Default)]
pub struct Together {
    pub begins: [f64; Self::MOST],
    pub sizes: [f64; Self::MOST],
}

impl Together {
    /// How many there may be: enough that a look at the floating-point mode after them costs next to nothing, and so
    /// few that the processor prepares the next ones, and adds up the last ones, while the FMU still computes.
    pub const MOST: usize = 20;

    /// Takes over the first of some even steps, up to `most`. Returns how many.
    #[inline]
    pub fn fill(&mut self, points: &CommunicationPoints, steps: Range<u64>, most: usize) -> usize {
        points.even_steps(steps.start, &mut self.begins, &mut self.sizes);
        usize::try_from(steps.end - steps.start).map_or(most, |left| left.min(most))
    }

    /// Begin and size of the first of them.
    #[inline]
    pub fn first(&self, count: usize) -> (&[f64], &[f64]) {
        (&self.begins[..count], &self.sizes[..count])
    }
}
