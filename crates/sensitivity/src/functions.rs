//! Test functions with known indices.
use std::f64::consts::PI;

/// Ishigami & Homma (1990), a = 7, b = 0.1; inputs in the unit cube.
pub fn ishigami(u: &[f64]) -> f64 {
    let x: Vec<f64> = u.iter().map(|v| PI * (2.0 * v - 1.0)).collect();
    x[0].sin() + 7.0 * x[1].sin().powi(2) + 0.1 * x[2].powi(4) * x[0].sin()
}

/// The function's first-order and total indices.
pub fn ishigami_indices() -> ([f64; 3], [f64; 3]) {
    let (a, b) = (7.0f64, 0.1f64);
    let v1 = 0.5 * (1.0 + b * PI.powi(4) / 5.0).powi(2);
    let v2 = a * a / 8.0;
    let v13 = b * b * PI.powi(8) * (1.0 / 18.0 - 1.0 / 50.0);
    let v = v1 + v2 + v13;
    ([v1 / v, v2 / v, 0.0], [(v1 + v13) / v, v2 / v, v13 / v])
}

/// Sobol's g-function (Saltelli & Sobol 1995); inputs in the unit cube.
pub fn sobol_g(u: &[f64], a: &[f64]) -> f64 {
    u.iter().zip(a).map(|(x, a)| ((4.0 * x - 2.0).abs() + a) / (1.0 + a)).product()
}

/// The function's first-order and total indices.
pub fn sobol_g_indices(a: &[f64]) -> (Vec<f64>, Vec<f64>) {
    let parts: Vec<f64> = a.iter().map(|a| 1.0 / (3.0 * (1.0 + a).powi(2))).collect();
    let all: f64 = parts.iter().map(|v| 1.0 + v).product();
    let v = all - 1.0;
    (parts.iter().map(|p| p / v).collect(), parts.iter().map(|p| p * (all / (1.0 + p)) / v).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::near;

    /// `Ishigami.evaluate` of SALib 1.5. The indices are those that its documentation gives.
    #[test]
    fn ishigami_is_that_of_others() {
        near([ishigami(&[0.6, 0.3, 0.9])], [9.264_535_220_628]);
        let (first, total) = ishigami_indices();
        let rounded = |indices: [f64; 3]| indices.map(|index| (1e4 * index).round() / 1e4);
        assert_eq!(rounded(first), [0.3139, 0.4424, 0.0]);
        assert_eq!(rounded(total), [0.5576, 0.4424, 0.2437]);
    }

    /// `Sobol_G` of SALib 1.5: `evaluate`, `sensitivity_index`, `total_sensitivity_index`.
    #[test]
    fn sobol_g_is_that_of_others() {
        let a = [0.0, 1.0, 4.5, 9.0];
        near([sobol_g(&[0.1, 0.3, 0.8, 0.6], &a)], [1.402_821_818_182]);
        let (first, total) = sobol_g_indices(&a);
        let exact = [0.716_492_934_858, 0.179_123_233_714, 0.023_685_716_855, 0.007_164_929_349];
        near(first.try_into().unwrap(), exact);
        let exact = [0.787_369_701_143, 0.242_267_600_352, 0.034_326_744_464, 0.010_463_384_733];
        near(total.try_into().unwrap(), exact);
    }
}
