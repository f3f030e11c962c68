//! Where two simulations of an FMU differ.

use crate::probe::Run;
use fmu_import::{Content, Value, Variable};

/// A number as text that reads back as the same number.
fn shown(value: &Value) -> String {
    let number = value.number();
    match number.abs() {
        _ if value.content() == Content::Text => "another text".to_owned(),
        0.0 | 1e-4..1e15 => number.to_string(),
        _ => format!("{number:e}"),
    }
}

/// Whether two values are the same. Zero is zero with either sign.
fn are_same(one: &Value, other: &Value) -> bool {
    match (one, other) {
        (Value::Real(one), Value::Real(other)) => one == other || one.to_bits() == other.to_bits(),
        _ => one == other,
    }
}

/// Where two runs differ first. Zero is zero with either sign.
pub(crate) fn difference(columns: &[&Variable], one: &Run, other: &Run) -> Option<String> {
    for (row, (first, second)) in one.rows.iter().zip(&other.rows).enumerate() {
        for (place, variable) in columns.iter().enumerate() {
            let (first, second) = (&first[place], &second[place]);
            if !are_same(first, second) {
                let [first, second] = [first, second].map(shown);
                let (name, time) = (&variable.name, one.times[row]);
                return Some(format!("{name} is {second} instead of {first} at {time} s"));
            }
        }
    }
    let [first, second] = [one, other].map(|run| run.times.last().copied().unwrap_or(f64::NAN));
    (first.to_bits() != second.to_bits()).then(|| format!("it ends at {second} s instead of {first} s"))
}
