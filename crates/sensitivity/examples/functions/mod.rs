//! Test functions with known indices; no program needs all.
#![allow(dead_code)]

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
