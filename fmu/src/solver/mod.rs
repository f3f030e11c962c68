//! Error-controlled time integration.

pub mod dormand_prince;
pub mod rodas3;

pub use dormand_prince::{DormandPrince, Quadrature};
pub use rodas3::Rodas3;

use thiserror::Error;

/// Why an integration stopped short.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum Failure {
    /// The step became smaller than the time's own resolution.
    #[error("the internal step fell below {0:e} s: the solution changes too fast or is no number")]
    StepTooSmall(f64),
    /// Too many steps in one call.
    #[error("more than {0} internal steps in one communication step")]
    TooManySteps(usize),
}

/// Work done, for diagnostics.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Work {
    /// Accepted steps.
    pub accepted: usize,
    /// Rejected steps.
    pub rejected: usize,
}

/// The largest of the errors, each over what is allowed; what is not a number is larger than any.
fn worst(errors: impl Iterator<Item = f64>) -> f64 {
    errors.map(f64::abs).fold(
        0.0,
        |worst, e| if e > worst || e.is_nan() { e } else { worst },
    )
}
