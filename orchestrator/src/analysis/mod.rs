//! From points to an answer: what the crates `parameter-regions` and `sensitivity` need of a study's results.
//!
//! Nothing here runs a simulation or knows FMI. [`from_results`] makes the table of points from a study's results.

pub mod from_results;
pub mod motion;
pub mod sensitivity;
pub mod verdict;
