//! From points to an answer: what the crates `parameter-regions` and `sensitivity` need of a study's results.
//!
//! Nothing here runs a simulation or knows FMI. The input is a [`parameter_regions::table::PointTable`] or plain slices; the output is numbers
//! with their uncertainty. [`from_results`] makes the table from a study's results.

pub mod from_results;
pub mod motion;
pub mod sensitivity;
pub mod verdict;
