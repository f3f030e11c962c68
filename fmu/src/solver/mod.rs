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
    fn check(&self, work: Work, passed: f64, span: f64) -> Result<(), Failure> {
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
fn worst(errors: impl Iterator<Item = f64>) -> f64 {
    errors.map(f64::abs).fold(0.0, |worst, e| if e > worst || e.is_nan() { e } else { worst })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Ten steps at once, two more a second, a thousand in all.
    const BUDGET: Budget = Budget { at_once: 10, per_second: 2.0, most: 1000.0 };

    fn after(accepted: usize, rejected: usize, passed: f64, span: f64) -> Result<(), Failure> {
        BUDGET.check(Work { accepted, rejected }, passed, span)
    }

    #[test]
    fn every_failure_tells_how_far_it_came() {
        let (passed, step, steps, span, needed) = (3.0, 1.0, 7, 9.0, 1e9);
        assert_eq!(Failure::StepTooSmall { step, passed }.passed(), passed);
        let slow = Failure::TooManySteps { steps, passed, span };
        assert_eq!(slow.passed(), passed);
        assert_eq!(Failure::SpanTooLong { needed, passed }.passed(), passed);
    }

    #[test]
    fn all_of_a_budget_may_be_used_and_no_step_more() {
        assert_eq!(after(13, 1, 2.0, 10.0), Ok(()));
        let (steps, passed, span) = (15, 2.0, 10.0);
        let failure = Failure::TooManySteps { steps, passed, span };
        assert_eq!(after(13, 2, passed, span), Err(failure));
    }

    /// The first four of a thousand steps are the sample from which the others are foreseen.
    #[test]
    fn a_span_that_is_too_long_is_foreseen_after_the_sample() {
        assert_eq!(after(4, 0, 1.0, 1e6), Ok(()));
        assert_eq!(after(5, 0, 1.0, 200.0), Ok(()));
        let failure = Failure::SpanTooLong { needed: 1005.0, passed: 1.0 };
        assert_eq!(after(5, 0, 1.0, 201.0), Err(failure));
    }

    #[test]
    fn the_worst_error_is_the_largest_or_no_number() {
        assert_eq!(worst([0.5, -2.0, 1.0].into_iter()), 2.0);
        assert!(worst([0.5, f64::NAN, 1.0].into_iter()).is_nan());
    }
}
