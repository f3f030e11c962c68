//! Uncertain parameters and what their samples tell.
//!
//! [`distribution`] says how a parameter is distributed, [`design`] places the points of a study in the unit cube and
//! maps them to values, [`random`] has the random numbers of all of them, and [`statistics`] condenses what comes back:
//! signals over time, moments, and shares with their intervals.

pub mod design;
pub mod distribution;
pub mod random;
pub mod rare;
pub mod recording;
pub mod statistics;

/// The word that a choice is in a study.
fn word(choice: &impl serde::Serialize) -> String {
    match serde_json::to_value(choice) {
        Ok(serde_json::Value::String(word)) => word,
        other => unreachable!("a choice is written as a word, not as {other:?}"),
    }
}

/// The README's example, as a test.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
