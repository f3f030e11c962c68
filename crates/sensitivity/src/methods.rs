//! The sensitivity methods: the one place that knows them all.
//!
//! A new method is a file beside [`crate::morris`] with a type that implements [`FromRuns`] or [`FromPoints`], its `mod`
//! line in ``lib.rs``, and its name in a list below. The command, the terminal and the page show its results.

use crate::method::{FromPoints, FromRuns};
use crate::{morris, pawn, rank, shapley, sobol};

/// Methods that need runs of their own; the first one is the usual one.
pub const RUNS: &[&dyn FromRuns] = &[&sobol::Sobol, &morris::Morris, &shapley::Shapley];

/// Methods for any points.
pub const VIEWS: &[&dyn FromPoints] = &[&rank::Ranks, &pawn::Slices];

/// The method of this name.
///
/// # Errors
/// Lists the names that there are.
pub fn named(name: &str) -> Result<&'static dyn FromRuns, String> {
    let known = RUNS.iter().find(|method| method.name() == name);
    known.copied().ok_or_else(|| {
        let names: Vec<&str> = RUNS.iter().map(|method| method.name()).collect();
        format!("unknown method `{name}`; there are {}", names.join(", "))
    })
}
