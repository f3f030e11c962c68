//! A cross-validation as text: for people, and as a table.

use std::fmt::Write;

use super::super::digits::{digits, rounded, shown};
use super::super::local::End;
use super::outcome::{CrossValidation, ErrorSize, HeldOut, Moves, QuantityErrors};

/// A summary for people.
pub fn summary(told: &CrossValidation) -> String {
    let mut text = String::from(
        "\ncross-validation: each case predicted by the model fitted to the others\n\
         errors (predicted less measured) as root mean square, with the largest one and its case\n",
    );
    let columns = columns(told);
    for row in 0..=told.quantities.len() {
        for (k, cells) in columns.iter().enumerate() {
            let lengths = cells.iter().map(|cell| cell.chars().count());
            let (cell, pad) = (&cells[row], lengths.max().unwrap_or(0));
            let _ = match k {
                0 => write!(text, "{cell:pad$}"),
                _ => write!(text, "  {cell:>pad$}"),
            };
        }
        text.push('\n');
    }
    text += &explanation(told);
    text += &parameters(told);
    text.extend(told.cases.iter().map(case));
    text
}

/// The columns of the table of errors that have anything in them, each below its head.
fn columns(told: &CrossValidation) -> Vec<Vec<String>> {
    type Pick = fn(&QuantityErrors) -> Option<&ErrorSize>;
    let picks: [(&str, Pick); 5] = [
        ("fitted", |q| q.fitted.as_ref()),
        ("predicted", |q| q.predicted.as_ref()),
        ("own unknowns", |q| q.own.as_ref()),
        ("linear regression", |q| q.linear.as_ref()),
        ("mean of the others", |q| q.mean.as_ref()),
    ];
    let below = |head: &str, cell: &dyn Fn(&QuantityErrors) -> String| {
        let cells = told.quantities.iter().map(cell);
        std::iter::once(head.to_owned()).chain(cells).collect()
    };
    let mut columns = vec![below("result", &|q| named(&q.quantity, &q.unit))];
    for (head, pick) in picks {
        let cell = |q: &QuantityErrors| match pick(q) {
            None => "-".to_owned(),
            Some(ErrorSize { rms, largest, case }) => {
                format!("{} ({}, {case})", rounded(*rms, 3), rounded(*largest, 3))
            }
        };
        if told.quantities.iter().any(|q| pick(q).is_some()) {
            columns.push(below(head, &cell));
        }
    }
    columns
}

/// A name with its unit.
fn named(name: &str, unit: &Option<String>) -> String {
    match shown(unit) {
        "" => name.to_owned(),
        unit => format!("{name}, {unit}"),
    }
}

fn explanation(told: &CrossValidation) -> String {
    let latents = told.cases.iter().find(|case| !case.latents.is_empty());
    let latents = latents.map_or_else(String::new, |case| {
        let names: Vec<&str> = case.latents.iter().map(|l| l.name.as_str()).collect();
        let names = names.join(", ");
        format!(
            "predicted: {names} of the case left out is known to its interval only, and the mean over the interval is \
             taken\nown unknowns: {names} is found from the case's own results, within the interval\n"
        )
    });
    let linear = match told.quantities.iter().any(|q| q.linear.is_some()) {
        true => "linear regression: least squares of each result on the known values of the other cases",
        false => "no linear regression: the known values are none, or too many for so few cases",
    };
    format!(
        "{latents}no prediction has an interval: the errors of the cases left out show how far one may be off\n{linear}\n"
    )
}

fn parameters(told: &CrossValidation) -> String {
    let name = |m: &Moves| named(&m.name, &m.unit);
    let width = told.free.iter().map(|m| name(m).len()).max().unwrap_or(0);
    let end = |end: &Option<(f64, String)>| match end {
        None => "-".to_owned(),
        Some((value, case)) => format!("{} ({case})", digits(*value)),
    };
    let line = |moves: &Moves| {
        let (name, value) = (name(moves), digits(moves.value));
        let [least, greatest] = [&moves.least, &moves.greatest].map(end);
        format!("{name:width$}  {value:>11}  {least} .. {greatest}\n")
    };
    let lines: String = told.free.iter().map(line).collect();
    format!("\nparameters as cases are left out: all cases, least (without case), greatest\n{lines}")
}

/// Sentences on one case that its reader must know.
fn case(case: &HeldOut) -> String {
    let label = &case.label;
    let mut text = match &case.failure {
        Some(failure) => format!("case {label} could not be predicted: {failure}\n"),
        None if case.end == Some(End::Iterations) => {
            format!("case {label}: the search over the others ended before it converged\n")
        }
        None => String::new(),
    };
    if case.failed_simulations > 0 {
        text += &format!(
            "case {label}: {} simulations over its interval failed and are left out\n",
            case.failed_simulations
        );
    }
    let squares = case.squares.map_or_else(String::new, |squares| {
        let [within, needed] = squares.map(|squares| rounded(squares, 3));
        format!(" (sum of squares {within} within, {needed} there)")
    });
    for latent in case.latents.iter().filter(|latent| latent.outside) {
        let (name, value) = (&latent.name, digits(latent.value));
        let [low, high] = latent.interval.map(digits);
        text += &format!("case {label}: its results need {name} = {value}, outside of {low} .. {high}{squares}\n");
    }
    text
}

/// The head of the table.
pub const HEAD: [&str; 11] = [
    "case",
    "result",
    "unit",
    "measured",
    "accuracy",
    "fitted",
    "predicted",
    "spread",
    "own_unknowns",
    "linear_regression",
    "mean_of_others",
];

/// A row for each case and result; what is not known is empty.
pub fn rows(told: &CrossValidation) -> Vec<Vec<String>> {
    let number = |value: Option<f64>| value.map_or_else(String::new, |value| value.to_string());
    let mut rows = Vec::new();
    for case in &told.cases {
        for (result, quantity) in case.results.iter().zip(&told.quantities) {
            let numbers = [
                Some(result.measured),
                Some(result.accuracy),
                Some(result.fitted),
                result.predicted,
                result.spread,
                result.own,
                result.linear,
                result.mean,
            ];
            let texts = [case.label.clone(), result.quantity.clone(), quantity.unit.clone().unwrap_or_default()];
            rows.push(texts.into_iter().chain(numbers.map(number)).collect());
        }
    }
    rows
}
