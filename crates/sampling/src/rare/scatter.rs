//! Mean, axes and variances of weighted points.

use nalgebra::DMatrix;

/// Mean and principal axes of weighted points.
#[derive(Debug)]
pub(super) struct Scatter {
    pub(super) mean: Vec<f64>,
    /// Orthogonal directions of length 1.
    pub(super) axes: Vec<Vec<f64>>,
    /// The variance along each of them.
    pub(super) variances: Vec<f64>,
    /// The effective sample size.
    pub(super) effective: f64,
}

/// The effective sample size (Kish 1965, "Survey Sampling").
pub(super) fn effective(weights: &[f64]) -> f64 {
    let sum: f64 = weights.iter().sum();
    let squares: f64 = weights.iter().map(|w| w * w).sum();
    if squares > 0.0 { sum * sum / squares } else { 0.0 }
}

impl Scatter {
    pub(super) fn of(points: &[impl AsRef<[f64]>], weights: &[f64]) -> Self {
        let dimensions = points.first().map_or(0, |point| point.as_ref().len());
        let sum: f64 = weights.iter().sum();
        let effective = effective(weights);
        let mut mean = vec![0.0; dimensions];
        for (point, weight) in points.iter().zip(weights) {
            for (m, x) in mean.iter_mut().zip(point.as_ref()) {
                *m += weight / sum * x;
            }
        }
        let mut matrix = DMatrix::zeros(dimensions, dimensions);
        let mut centred = vec![0.0; dimensions];
        for (point, weight) in points.iter().zip(weights).filter(|(_, w)| **w > 0.0) {
            for (c, (x, m)) in centred.iter_mut().zip(point.as_ref().iter().zip(&mean)) {
                *c = x - m;
            }
            for (i, a) in centred.iter().enumerate() {
                for (j, b) in centred[..=i].iter().enumerate() {
                    matrix[(i, j)] += weight / sum * a * b;
                }
            }
        }
        matrix.fill_upper_triangle_with_lower_triangle();
        let eigen = matrix.symmetric_eigen();
        let axes: Vec<Vec<f64>> =
            (0..dimensions).map(|k| eigen.eigenvectors.column(k).iter().copied().collect()).collect();
        // Rounding hides small eigenvalues beside large ones; the variance along their axes is exact.
        let correction = effective / (effective - 1.0).max(1.0);
        let variance = |axis: &Vec<f64>| {
            let pairs = points.iter().zip(weights);
            let squares = pairs.map(|(point, weight)| {
                let triples = axis.iter().zip(point.as_ref()).zip(&mean);
                let place: f64 = triples.map(|((a, x), m)| a * (x - m)).sum();
                weight / sum * place * place
            });
            (correction * squares.sum::<f64>()).max(f64::MIN_POSITIVE)
        };
        let variances = axes.iter().map(variance).collect();
        Self { mean, axes, variances, effective }
    }
}
