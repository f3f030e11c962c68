//! Finds the parameters that make a model's predictions most probable, given measured values with
//! their accuracies.
//!
//! - [`problem`] says what is to be found, and from what;
//! - [`objective`] is the weighted sum of squares over all cases;
//! - [`remembered`] asks the model each question once;
//! - [`local`] goes down to the nearest minimum, [`search`] does so from many starts;
//! - [`optima`] tells which of the ends are distinct, and what part of the posterior each has;
//! - [`posterior`] says how well the data determine it;
//! - [`sample`] draws from the posterior where its normal approximation will not do;
//! - [`surrogate`] puts polynomials in place of a model whose runs are dear;
//! - [`failures`] says what is excluded as runs failed there;
//! - [`discrepancy`] is how far the model is from the truth by itself, and [`rounds`] searches with unknown ones;
//! - [`cross`] leaves out one case at a time and predicts it from the others.
//!
//! - [`outcome`] is the result for programs, [`text`] for people.
//!
//! A model is anything that implements [`problem::Simulate`].

pub mod cross;
mod digits;
pub mod discrepancy;
pub mod failures;
pub mod local;
pub mod objective;
pub mod optima;
#[cfg(test)]
mod optima_tests;
pub mod outcome;
pub mod posterior;
pub mod problem;
#[cfg(test)]
mod recovery_tests;
pub mod remembered;
pub mod rounds;
pub mod sample;
pub mod search;
pub mod surrogate;
#[cfg(test)]
mod testing;
pub mod text;

/// The README's example, as a test.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
