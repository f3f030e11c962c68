//! A sample of the posterior as text and as a table.

use std::fmt::Write;

use super::super::digits::{Digits, digits, shown};
use super::super::discrepancy::Unknown;
use super::super::problem::Problem;
use super::outcome::{Marginal, PosteriorOutcome};
use super::{GROUPS, Sample};

/// Intervals that are named one by one.
const NAMED: usize = 8;

/// A summary for people.
pub fn summary(outcome: &PosteriorOutcome) -> String {
    let mut text = String::new();
    let PosteriorOutcome {
        particles,
        effective,
        evaluated,
        ..
    } = outcome;
    let judged = if outcome.trusted {
        format!("{GROUPS} independent groups agree; worth about {effective:.0} independent draws")
    } else {
        "NOT to be relied on, see below".to_owned()
    };
    let _ = writeln!(
        text,
        "\nposterior sample: {particles} particles ({judged}), from {evaluated} evaluations"
    );
    marginals(&mut text, &outcome.free);
    shares(&mut text, outcome);
    let [low, high] = outcome.holds.map(|part| 100.0 * part);
    let _ = writeln!(
        text,
        "{} % of the particles are different. A sample is finite: each 95 % interval above really holds {low:.0} to {high:.0} % \
         of the posterior (with a probability of 95 %). ln evidence {} +- {}",
        Digits::of(100.0 * outcome.distinct as f64 / *particles as f64, 3),
        digits(outcome.log_evidence),
        Digits::of(outcome.log_evidence_error, 2)
    );
    for note in &outcome.notes {
        let _ = writeln!(text, "{note}");
    }
    for doubt in &outcome.doubts {
        let _ = writeln!(text, "do not rely on this sample: {doubt}");
    }
    if !outcome.trusted {
        let _ = writeln!(text, "--posterior {} may do", outcome.more());
    }
    text
}

fn marginals(text: &mut String, free: &[Marginal]) {
    let width = free.iter().map(|own| own.name.len()).max().unwrap_or(0);
    let _ = writeln!(
        text,
        "{:width$}  {:>11} {:>11} {:>11}  95 % of it",
        "parameter", "mean", "deviation", "median"
    );
    for own in free {
        let parts = own.intervals.iter().take(NAMED);
        let parts = parts.map(|ends| {
            let [low, high] = ends.map(digits);
            format!("{low} .. {high}")
        });
        let parts: Vec<String> = parts.collect();
        let more = match own.intervals.len().saturating_sub(NAMED) {
            0 => String::new(),
            more => format!(" or {more} more"),
        };
        let _ = writeln!(
            text,
            "{:width$}  {:>11} {:>11} {:>11}  {} {}{more}",
            own.name,
            digits(own.mean),
            Digits::of(own.deviation, 3),
            digits(own.median),
            parts.join(" or "),
            shown(&own.unit)
        );
    }
}

fn shares(text: &mut String, outcome: &PosteriorOutcome) {
    if outcome.optima.len() < 2 {
        return;
    }
    for own in &outcome.optima {
        let _ = writeln!(
            text,
            "near optimum {}: {:.1} +- {:.1} % of the sample ({:.1} % by its normal approximation)",
            own.optimum,
            100.0 * own.share,
            100.0 * own.error,
            100.0 * own.approximation
        );
    }
}

/// The head of the table of particles: free parameters, latent ones as `CASE/NAME`, discrepancies as `NAME.discrepancy`, and the logarithm of the likelihood.
pub fn head(problem: &Problem, unknown: &[Unknown]) -> Vec<String> {
    let free = problem.free.iter().map(|free| free.name.clone());
    let latents = problem.cases.iter().flat_map(|case| {
        let latents = problem.latents.iter();
        latents.map(|latent| format!("{}/{}", case.label, latent.name))
    });
    let discrepancies = unknown.iter().map(|own| {
        let name = &problem.quantities[own.quantity].name;
        format!("{name}.discrepancy")
    });
    ["point".to_owned()]
        .into_iter()
        .chain(free)
        .chain(latents)
        .chain(discrepancies)
        .chain(["log_likelihood".to_owned()])
        .collect()
}

/// The units of the table's columns, as a comment.
pub fn units(problem: &Problem) -> String {
    let free = problem.free.iter().map(|own| (&own.name, &own.unit));
    let latents = problem.latents.iter().map(|own| (&own.name, &own.unit));
    let units = free.chain(latents).map(|(name, unit)| {
        let unit = unit.as_deref().unwrap_or("1");
        format!("{name} in {unit}")
    });
    units.collect::<Vec<_>>().join(", ")
}

/// The rows of the table: all of equal weight.
pub fn rows<'a>(
    problem: &'a Problem,
    unknown: &'a [Unknown],
    sample: &'a Sample,
) -> impl Iterator<Item = Vec<String>> + 'a {
    sample
        .particles
        .iter()
        .enumerate()
        .map(move |(index, own)| {
            let free = problem.free_values(&own.places).into_iter();
            let latents =
                (0..problem.cases.len()).flat_map(|case| problem.latent_values(case, &own.places));
            let places = own.places.iter().skip(problem.unknowns());
            let deviations = unknown.iter().zip(places);
            let deviations = deviations.map(|(unknown, &place)| unknown.deviation(place));
            let numbers = free
                .chain(latents)
                .chain(deviations)
                .chain([own.log_likelihood]);
            let label = (index + 1).to_string();
            [label]
                .into_iter()
                .chain(numbers.map(|value| value.to_string()))
                .collect()
        })
}
