//! The sensitivity of a study's outputs: the crate `sensitivity` has the methods, here they meet a table of points.
//! Whether a run failed is an output of its own ([`study`]).

mod failures;
pub mod study;
