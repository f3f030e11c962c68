//! Uncertain parameters and what their samples tell.
//!
//! [`distribution`] says how a parameter is distributed, [`design`] places the points of a study in the unit cube and
//! maps them to values, [`random`] has the random numbers of all of them, and [`statistics`] condenses what comes back: signals over time, moments, and shares with their
//! intervals.

pub mod design;
pub mod distribution;
pub mod random;
pub mod rare;
pub mod recording;
pub mod statistics;

/// The README's example, as a test.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
