#![doc = include_str!("../README.md")]

pub mod design;
pub mod distribution;
pub mod random;
pub mod recording;
pub mod statistics;

/// The word that a choice is in a study and in results.
pub fn word(choice: &impl serde::Serialize) -> String {
    match serde_json::to_value(choice) {
        Ok(serde_json::Value::String(word)) => word,
        other => unreachable!("a choice is written as a word, not as {other:?}"),
    }
}
