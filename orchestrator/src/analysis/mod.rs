//! From a cloud of simulated points to an answer: pure functions on tables of numbers.
//!
//! Nothing here runs a simulation or knows FMI. The input is a [`table::PointTable`] or plain slices; the output is numbers
//! with their uncertainty. [`from_results`] makes the table from a study's results.

pub mod from_results;
pub mod motion;
pub mod pareto;
pub mod robustness;
pub mod sensitivity;
pub mod synchronise;
pub mod table;
pub mod tolerances;
pub mod verdict;
