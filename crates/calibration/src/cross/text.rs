//! A cross-validation as text: for people, and as a table.

use std::fmt::Write;

use super::super::digits::{Digits, digits, shown};
use super::super::local::End;
use super::outcome::{CrossValidation, ErrorSize, HeldOut, Moves, QuantityErrors};

/// A summary for people.
pub fn summary(told: &CrossValidation) -> String {
    let mut text = String::from(
        "\ncross-validation: each case predicted by the model fitted to the others\n\
         errors (predicted less measured) as root mean square, with the largest one and its case\n",
    );
    let columns = columns(told);
    let width = |k: usize| {
        let cells = columns[k].1.iter().map(|cell| cell.chars().count());
        cells.chain([columns[k].0.len()]).max().unwrap_or(0)
    };
    for row in 0..=told.quantities.len() {
        for (k, (head, cells)) in columns.iter().enumerate() {
            let cell = if row == 0 { head } else { &cells[row - 1] };
            let pad = width(k);
            let _ = match k {
                0 => write!(text, "{cell:pad$}"),
                _ => write!(text, "  {cell:>pad$}"),
            };
        }
        text.push('\n');
    }
    explanation(&mut text, told);
    parameters(&mut text, told);
    cases(&mut text, told);
    text
}

/// The columns of the table of errors that have anything in them, each with its head.
fn columns(told: &CrossValidation) -> Vec<(String, Vec<String>)> {
    type Pick = fn(&QuantityErrors) -> Option<&ErrorSize>;
    let picks: [(&str, Pick); 5] = [
        ("fitted", |q| q.fitted.as_ref()),
        ("predicted", |q| q.predicted.as_ref()),
        ("own unknowns", |q| q.own.as_ref()),
        ("linear regression", |q| q.linear.as_ref()),
        ("mean of the others", |q| q.mean.as_ref()),
    ];
    let name = |q: &QuantityErrors| named(&q.quantity, &q.unit);
    let names = told.quantities.iter().map(name).collect();
    let mut columns = vec![("result".to_owned(), names)];
    for (head, pick) in picks {
        let cell = |q| {
            pick(q).map_or_else(
                || "-".to_owned(),
                |size: &ErrorSize| {
                    format!(
                        "{} ({}, {})",
                        Digits::of(size.rms, 3),
                        Digits::of(size.largest, 3),
                        size.case
                    )
                },
            )
        };
        if told.quantities.iter().any(|q| pick(q).is_some()) {
            columns.push((head.to_owned(), told.quantities.iter().map(cell).collect()));
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

fn explanation(text: &mut String, told: &CrossValidation) {
    let latents = told.cases.iter().find(|case| !case.latents.is_empty());
    if let Some(case) = latents {
        let names: Vec<&str> = case.latents.iter().map(|l| l.name.as_str()).collect();
        let names = names.join(", ");
        let _ = writeln!(
            text,
            "predicted: {names} of the case left out is known to its interval only, and the mean over the interval is \
             taken\nown unknowns: {names} is found from the case's own results, within the interval"
        );
    }
    text.push_str(
        "no prediction has an interval: the errors of the cases left out show how far one may be off\n",
    );
    if told.quantities.iter().any(|q| q.linear.is_some()) {
        text.push_str(
            "linear regression: least squares of each result on the known values of the other cases\n",
        );
    } else {
        text.push_str(
            "no linear regression: the known values are none, or too many for so few cases\n",
        );
    }
}

fn parameters(text: &mut String, told: &CrossValidation) {
    text.push_str(
        "\nparameters as cases are left out: all cases, least (without case), greatest\n",
    );
    let name = |m: &Moves| named(&m.name, &m.unit);
    let width = told.free.iter().map(|m| name(m).len()).max().unwrap_or(0);
    for moves in &told.free {
        let end = |end: &Option<(f64, String)>| {
            end.as_ref().map_or_else(
                || "-".to_owned(),
                |(value, case)| format!("{} ({case})", digits(*value)),
            )
        };
        let _ = writeln!(
            text,
            "{:width$}  {:>11}  {} .. {}",
            name(moves),
            digits(moves.value),
            end(&moves.least),
            end(&moves.greatest)
        );
    }
}

fn cases(text: &mut String, told: &CrossValidation) {
    for case in &told.cases {
        if let Some(failure) = &case.failure {
            let _ = writeln!(
                text,
                "case {} could not be predicted: {failure}",
                case.label
            );
        } else if case.end == Some(End::Iterations) {
            let _ = writeln!(
                text,
                "case {}: the search over the others ended before it converged",
                case.label
            );
        }
        if case.failed_simulations > 0 {
            let _ = writeln!(
                text,
                "case {}: {} simulations over its interval failed and are left out",
                case.label, case.failed_simulations
            );
        }
        outside(text, case);
    }
}

/// Latent parameters that the case wants outside of their intervals.
fn outside(text: &mut String, case: &HeldOut) {
    for latent in case.latents.iter().filter(|latent| latent.outside) {
        let [low, high] = latent.interval.map(digits);
        let _ = write!(
            text,
            "case {}: its results need {} = {}, outside of {low} .. {high}",
            case.label,
            latent.name,
            digits(latent.value)
        );
        let _ = match case.squares {
            Some([within, needed]) => writeln!(
                text,
                " (sum of squares {} within, {} there)",
                Digits::of(within, 3),
                Digits::of(needed, 3)
            ),
            None => writeln!(text),
        };
    }
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
            let texts = [
                case.label.clone(),
                result.quantity.clone(),
                quantity.unit.clone().unwrap_or_default(),
            ];
            rows.push(texts.into_iter().chain(numbers.map(number)).collect());
        }
    }
    rows
}
