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
pub fn difference(columns: &[&Variable], one: &Run, other: &Run) -> Option<String> {
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

/// By how much a variable changes between two runs, in parts of its range.
pub struct Change<'a> {
    pub name: &'a str,
    pub most: f64,
    pub mean: f64,
}

/// The real variables that change between two runs at the times that both have; infinitely where only one is finite.
pub fn changes<'a>(columns: &[&'a Variable], one: &Run, other: &Run) -> Vec<Change<'a>> {
    /// The least range, as a part of the largest value: what is constant but for a solver's tolerance has hardly any.
    const LEAST: f64 = 1e-3;
    let pairs: Vec<_> = one
        .times
        .iter()
        .zip(&one.rows)
        .zip(other.times.iter().zip(&other.rows))
        .filter(|((time, _), (same, _))| time == same)
        .map(|((_, row), (_, other))| (row, other))
        .collect();
    columns
        .iter()
        .enumerate()
        .filter_map(move |(place, variable)| {
            let values = || pairs.iter().map(|(row, _)| row[place].number());
            let finite = || values().filter(|value| value.is_finite());
            let [low, high] =
                finite().fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], v| [low.min(v), high.max(v)]);
            let range = (high - low).max(LEAST * low.abs().max(high.abs()));
            let change = |(row, other): &(&Vec<Value>, &Vec<Value>)| {
                let [one, other] = [row, other].map(|row| row[place].number());
                match (one.is_finite(), other.is_finite()) {
                    (true, true) => (one - other).abs() / range,
                    (false, false) => 0.0,
                    _ => f64::INFINITY,
                }
            };
            let is_real = variable.kind.content() == Content::Real && range > 0.0;
            is_real.then(|| Change {
                name: variable.name.as_str(),
                most: pairs.iter().map(change).fold(0.0, f64::max),
                mean: pairs.iter().map(change).sum::<f64>() / pairs.len() as f64,
            })
        })
        .collect()
}
