//! The slope rating.

use super::part;

/// The error at which the rating is zero.
const WORST: f64 = 2.0;
/// How many samples to each side are averaged; fewer towards the ends.
const SIDE: usize = 4;

/// One without an error, zero for the worst one, and straight between. The error is the sum of the differences of the
/// slopes, as a part of the sum of the reference's.
pub fn rating(reference: &[f64], model: &[f64]) -> f64 {
    let (reference, model) = (smoothed(&slopes(reference)), smoothed(&slopes(model)));
    let differences: f64 = reference.iter().zip(&model).map(|(r, m)| (m - r).abs()).sum();
    let all: f64 = reference.iter().map(|slope| slope.abs()).sum();
    ((WORST - part(differences, all)) / WORST).max(0.0)
}

/// Slopes a sample: central differences, and one-sided ones at the ends.
fn slopes(values: &[f64]) -> Vec<f64> {
    let last = values.len() - 1;
    (0..=last)
        .map(|k| {
            let (before, after) = (k.saturating_sub(1), (k + 1).min(last));
            (values[after] - values[before]) / (after - before) as f64
        })
        .collect()
}

/// Means over nine samples; at the ends over seven, five, three, one.
fn smoothed(values: &[f64]) -> Vec<f64> {
    let last = values.len() - 1;
    (0..=last)
        .map(|k| {
            let side = SIDE.min(k).min(last - k);
            let part = &values[k - side..=k + side];
            part.iter().sum::<f64>() / part.len() as f64
        })
        .collect()
}
