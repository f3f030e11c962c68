//! Where two simulations of an FMU differ.

use crate::probe::Run;
use fmu_import::{Content, Variable};

/// A value as a number; a text is none.
pub(crate) fn number(bits: u64, variable: &Variable) -> Option<f64> {
    Some(match variable.kind.content() {
        Content::Real => f64::from_bits(bits),
        #[allow(clippy::cast_possible_truncation)]
        Content::Integer => bits.cast_signed() as f64,
        Content::Boolean => f64::from(u8::from(bits != 0)),
        Content::Text => return None,
    })
}

/// A number as text that reads back as the same number.
fn written(value: f64) -> String {
    match value.abs() {
        0.0 | 1e-4..1e15 => value.to_string(),
        _ => format!("{value:e}"),
    }
}

/// Where two runs differ first. Zero is zero with either sign.
pub(crate) fn difference(columns: &[&Variable], one: &Run, other: &Run) -> Option<String> {
    for (row, (first, second)) in one.rows.iter().zip(&other.rows).enumerate() {
        for (place, variable) in columns.iter().enumerate() {
            let (first, second) = (first[place], second[place]);
            let numbers = [first, second].map(|bits| number(bits, variable));
            let same = first == second || matches!(numbers, [Some(one), Some(two)] if one == two);
            if !same {
                let shown = |value: Option<f64>| value.map_or("another text".to_owned(), written);
                let [first, second] = numbers.map(shown);
                let (name, time) = (&variable.name, one.times[row]);
                return Some(format!("{name} is {second} instead of {first} at {time} s"));
            }
        }
    }
    let [first, second] = [one, other].map(|run| run.times.last().copied().unwrap_or(f64::NAN));
    (first.to_bits() != second.to_bits())
        .then(|| format!("it ends at {second} s instead of {first} s"))
}

/// The real variable whose last value changes most between two runs, and by what share of its size.
pub(crate) fn largest_change<'a>(
    columns: &[&'a Variable],
    one: &Run,
    other: &Run,
) -> Option<(f64, &'a str)> {
    let ends = one.times.last() == other.times.last();
    let (first, second) = one.rows.last().zip(other.rows.last()).filter(|_| ends)?;
    let share = |(place, variable): (usize, &&'a Variable)| {
        let values = one.rows.iter();
        let values = values.filter_map(|row| number(row[place], variable));
        let scale = values.fold(0.0, |largest: f64, value| largest.max(value.abs()));
        let change = (number(first[place], variable)? - number(second[place], variable)?).abs();
        let real = variable.kind.content() == Content::Real && scale > 0.0;
        real.then_some((change / scale, variable.name.as_str()))
    };
    let shares = columns.iter().enumerate().filter_map(share);
    shares.max_by(|a, b| a.0.total_cmp(&b.0))
}
