//! Conformity of a model with measured values that are uncertain themselves.
//!
//! *Tolerance* says how far the model may be from the true value, *measurement uncertainty* how far
//! the measured value may be from it. The true value is taken as normal about the measured one;
//! nothing else is known of it (JCGM 106:2012, "Evaluation of measurement data - The role of
//! measurement uncertainty in conformity assessment", whose terms are used here).

pub mod conclusion;
pub mod decision;
pub mod gain;
pub mod interval;
pub mod joint;
pub mod likelihood;
pub mod looks;
pub mod measured;
pub mod normal;
pub mod risk;
pub mod sequence;
pub mod validation;

mod genz;
mod lattice;
mod one_factor;
mod tabulated;

/// The README's example, as a test.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
