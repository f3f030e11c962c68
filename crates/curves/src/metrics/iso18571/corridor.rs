//! The corridor rating.

/// The half width of the inner corridor, within which a sample counts fully, as a part of the largest magnitude.
const INNER: f64 = 0.05;
/// The half width of the outer corridor, outside of which it does not count.
const OUTER: f64 = 0.5;

/// The mean over the samples; between the corridors the rating falls with the square.
pub fn rating(reference: &[f64], model: &[f64]) -> f64 {
    let largest = reference.iter().fold(0.0_f64, |most, value| most.max(value.abs()));
    let (inner, outer) = (INNER * largest, OUTER * largest);
    let rate = |(r, m): (&f64, &f64)| match (r - m).abs() {
        // Of a reference that is zero both corridors are nothing, and it belongs to them.
        deviation if deviation < inner || deviation == 0.0 => 1.0,
        deviation if deviation > outer => 0.0,
        deviation => ((outer - deviation) / (outer - inner)).powi(2),
    };
    reference.iter().zip(model).map(rate).sum::<f64>() / reference.len() as f64
}
