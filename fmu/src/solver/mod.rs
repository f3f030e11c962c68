//! Error-controlled time integration.

pub mod dormand_prince;
pub mod rodas3;

pub use dormand_prince::{DormandPrince, Passage};
pub use rodas3::Rodas3;

use thiserror::Error;

/// Why an integration stopped short.
#[derive(Debug, Error, PartialEq)]
pub enum Failure {
    /// The step became smaller than the time's own resolution.
    #[error("after {passed:.1e} s the internal step fell below {step:.1e} s")]
    StepTooSmall {
        /// The step, s.
        step: f64,
        /// The time that had passed, s.
        passed: f64,
    },
    /// Too many steps for the time that they took the solution on.
    #[error("{steps} internal steps were taken for the first {passed:.1e} of {span:?} s")]
    TooManySteps {
        /// The steps.
        steps: usize,
        /// The time that had passed, s.
        passed: f64,
        /// The time that was to pass, s.
        span: f64,
    },
    /// The span is too long for the steps that it takes.
    #[error("some {needed:.0e} internal steps would be needed: take shorter communication steps")]
    SpanTooLong {
        /// The steps that it would take.
        needed: f64,
        /// The time that had passed, s.
        passed: f64,
    },
}

impl Failure {
    /// The time that had passed, s.
    pub fn passed(&self) -> f64 {
        match self {
            Self::StepTooSmall { passed, .. }
            | Self::TooManySteps { passed, .. }
            | Self::SpanTooLong { passed, .. } => *passed,
        }
    }
}

/// How many internal steps an integration may take: a first allowance, more with every second that has passed, and a
/// limit for all. A solution that stands still in its own time is given up early, however long
/// the span, and so is one whose span is too long for its steps. What is counted is work: the same call ends
/// the same way on every machine.
#[derive(Clone, Copy, Debug)]
pub struct Budget {
    /// Steps before any time has passed.
    pub at_once: usize,
    /// Further steps per second.
    pub per_second: f64,
    /// Steps in all.
    pub most: f64,
}

impl Budget {
    /// A fixed number of steps, whatever time they cover.
    pub const fn of(steps: usize) -> Self {
        Self { at_once: steps, per_second: 0.0, most: f64::INFINITY }
    }

    /// Whether the work is within it after `passed` seconds of a span.
    pub fn check(&self, work: Work, passed: f64, span: f64) -> Result<(), Failure> {
        /// After this part of all steps the others are foreseen.
        const SAMPLE: f64 = 0.004;
        let steps = work.accepted + work.rejected;
        let taken = steps as f64;
        let needed = taken * (span / passed);
        if taken > SAMPLE * self.most && needed > self.most {
            return Err(Failure::SpanTooLong { needed, passed });
        }
        if taken > self.at_once as f64 + self.per_second * passed {
            return Err(Failure::TooManySteps { steps, passed, span });
        }
        Ok(())
    }
}

/// Work done, for diagnostics.
#[derive(Clone, Copy, Debug, Default)]
pub struct Work {
    /// Accepted steps.
    pub accepted: usize,
    /// Rejected steps.
    pub rejected: usize,
}

/// The largest error relative to its tolerance. NaN counts as larger than any number.
pub fn worst(errors: impl Iterator<Item = f64>) -> f64 {
    errors.map(f64::abs).fold(0.0, |worst, e| if e > worst || e.is_nan() { e } else { worst })
}
