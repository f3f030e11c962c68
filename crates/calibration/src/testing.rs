//! Problems, starts and settings that several tests use.

use super::{
    local::Limits,
    outcome::IdentificationOutcome,
    problem::{Case, Free, Named, Problem, Spacing, UncertainValue},
    sample::Settings,
    search::Effort,
    text,
};

/// When the values of [`decay`] are measured.
pub const TIMES: [f64; 6] = [0.3, 0.6, 1.0, 1.5, 2.2, 3.0];

/// A decay with amplitude and rate.
pub fn decay(p: &[f64]) -> Vec<f64> {
    TIMES.iter().map(|t| p[0] * (-p[1] * t).exp()).collect()
}

/// The unknowns of [`decay`].
pub fn unknown_decay() -> Vec<Free> {
    vec![free("amplitude", Spacing::Linear, 0.5, 2.0), free("rate", Spacing::Log, 0.1, 10.0)]
}

/// A parameter without a prior.
pub fn free(name: &str, scale: Spacing, min: f64, max: f64) -> Free {
    Free { name: name.to_owned(), unit: None, scale, min, max, prior: None }
}

/// A quantity or latent parameter without a unit.
pub fn named(name: &str) -> Named {
    Named { name: name.to_owned(), unit: None }
}

/// Values that are all as accurate.
pub fn measured(values: &[f64], accuracy: f64) -> Vec<UncertainValue> {
    let measured = values.iter().map(|&value| UncertainValue { value, accuracy });
    measured.collect()
}

/// Cases with these measured values, labelled from 0; the quantities are `y0`, `y1` and so on.
pub fn problem(free: Vec<Free>, cases: Vec<Vec<UncertainValue>>) -> Problem {
    let quantities = 0..cases.first().map_or(0, Vec::len);
    let case = |(index, measured): (usize, Vec<UncertainValue>)| Case {
        label: index.to_string(),
        latents: Vec::new(),
        measured,
    };
    Problem {
        free,
        quantities: quantities.map(|k| named(&format!("y{k}"))).collect(),
        cases: cases.into_iter().enumerate().map(case).collect(),
        ..Problem::default()
    }
}

/// One case: parameters `p0`, `p1` and so on between bounds, and values with their accuracies.
pub fn one_case(bounds: &[(f64, f64)], measured: &[(f64, f64)]) -> Problem {
    let bounds = bounds.iter().enumerate();
    let free = bounds.map(|(k, &(min, max))| free(&format!("p{k}"), Spacing::Linear, min, max));
    let values = measured.iter();
    let values = values.map(|&(value, accuracy)| UncertainValue { value, accuracy });
    problem(free.collect(), vec![values.collect()])
}

/// Starts on a diagonal lattice (Kronecker's, with the powers of an irrational number).
pub fn starts(dimensions: usize, count: usize) -> Vec<Vec<f64>> {
    let place = |i: usize, d: usize| ((i + 1) as f64 * 0.754_877_666_f64.powi(d as i32 + 1)).fract();
    (0..count).map(|i| (0..dimensions).map(|d| place(i, d)).collect()).collect()
}

/// A search without a time limit.
pub fn effort(descents: usize, iterations: usize) -> Effort {
    Effort { descents, iterations }
}

/// A local search without a time limit.
pub fn limits(iterations: usize, decrease: f64) -> Limits {
    Limits { iterations, decrease }
}

/// A sample without a time limit.
pub fn settings(particles: u64, seed: u64) -> Settings {
    Settings { particles, seed }
}

/// All sentences on a result.
pub fn said(outcome: &IdentificationOutcome) -> String {
    let several = text::several(outcome).into_iter().collect();
    let parts = [
        text::doubts(outcome),
        several,
        text::remarks(outcome),
        text::open(outcome),
        text::shared(outcome),
        text::excluded(outcome),
        text::influence(outcome),
        text::searches(outcome),
    ];
    parts.concat().join("\n")
}
