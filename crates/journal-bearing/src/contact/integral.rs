//! Greenwood & Tripp's integral over the heights of the asperities.

/// Coefficients of `ln F_5/2(H)` as a polynomial, lowest power first. This minimax fit is this crate's own; it is within
/// 0.02 % of the integral for `H` from -6 to 7. The usual power law is 11 % low at `H = 0` and 35 % low at 2.5.
const LOG: [f64; 11] = [
    -0.483591,
    -1.74352,
    -0.269523,
    -0.0228896,
    0.000615966,
    0.000202136,
    -1.72596e-5,
    -2.45196e-6,
    2.98994e-7,
    1.61908e-8,
    -2.2404e-9,
];

/// Lower end of the fit's range of `H`.
const CROSSED: f64 = -6.0;

/// `ln F_5/2` and its slope at a film ratio. Above the fit's range it falls faster than the integral.
fn log(h: f64) -> (f64, f64) {
    LOG.iter().rev().fold((0.0, 0.0), |(value, slope), coefficient| (value * h + coefficient, slope * h + value))
}

/// Greenwood & Tripp's integral `F_5/2(H) = 1/sqrt(2*pi) * int_H^inf (s-H)^(5/2) exp(-s^2/2) ds` for Gaussian heights, and
/// its slope, at the film ratio `H = h/sigma`, 1. Below `H = -6`, where the mean planes have crossed far, the power law
/// `|H|^(5/2)` continues it.
pub fn f_5_2(film_ratio: f64) -> (f64, f64) {
    let (exponent, slope) = f_5_2_log(film_ratio);
    let value = exponent.exp();
    (value, slope * value)
}

/// Its logarithm, and that one's slope.
pub fn f_5_2_log(film_ratio: f64) -> (f64, f64) {
    if film_ratio < CROSSED {
        let value = log(CROSSED).0 + 2.5 * (film_ratio / CROSSED).ln();
        return (value, 2.5 / film_ratio);
    }
    log(film_ratio)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;

    /// Compares the fit with the integral by numerical quadrature, and its slope with differences.
    #[test]
    fn f_5_2_is_the_integral() {
        for i in -60..=70 {
            let h = 0.1 * f64::from(i);
            let (n, width) = (20_000, 16.0);
            let ds = width / f64::from(n);
            let integrand = |k: i32| {
                let x = (f64::from(k) + 0.5) * ds;
                x.powf(2.5) * (-0.5 * (h + x).powi(2)).exp()
            };
            let integral = (0..n).map(integrand).sum::<f64>() * ds / (2.0 * PI).sqrt();
            assert!((f_5_2(h).0 / integral - 1.0).abs() < 2e-4, "H = {h}");
        }
        for h in [-8.0, -5.0, -1.0, 0.5, 3.0, 6.0] {
            let slope = (f_5_2(h + 1e-6).0 - f_5_2(h - 1e-6).0) / 2e-6;
            assert!((f_5_2(h).1 / slope - 1.0).abs() < 1e-6, "H = {h}");
        }
    }
}
