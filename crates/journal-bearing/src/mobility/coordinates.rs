//! Coordinates over which the mobility is smooth enough to interpolate.
//!
//! Near the bush the mobility turns from radial to tangential while the load's direction changes by only about `1 - e`.
//! Its size changes over `sqrt(1 - e)`, the angle over which the gap is narrow, and more slowly beyond. One coordinate
//! resolves all three:
//!
//! ```text
//! s = asinh(tan(phi/4) / d) / asinh(1/d),   d = 0.3 (1 - e)
//! ```
//!
//! `phi` is the angle from the eccentricity to the load; `s` is 0 with the load along the eccentricity, 1 against it.

/// Ratio of `d` to `1 - e`.
const CORE: f64 = 0.3;

/// Least relative gap `1 - e` for which the coordinates are computed; smaller ones count as this.
const NARROWEST: f64 = 1e-12;

/// A point of the map: `u = -ln(1 - e)` and `s`, both from 0.
#[derive(Clone, Copy, Debug)]
pub struct Point {
    pub u: f64,
    pub s: f64,
}

impl Point {
    /// The point at the relative gap `1 - e`, given the cosine and the sine (of either sign) of the angle from the
    /// eccentricity to the load.
    #[inline]
    pub fn new(gap: f64, cos: f64, sin: f64) -> Self {
        let gap = gap.clamp(NARROWEST, 1.0);
        Self { u: -gap.ln(), s: Self::direction(gap, cos, sin) }
    }

    /// The coordinate of the direction alone, at a relative gap in 0..1.
    #[inline]
    pub fn direction(gap: f64, cos: f64, sin: f64) -> f64 {
        let core = CORE * gap;
        // Numerator and denominator use the same operations, so that a load against the eccentricity gives exactly 1.
        let per_core = 1.0 / core;
        asinh(quarter_tangent(cos, sin.abs()) * per_core) / asinh(per_core)
    }

    /// The eccentricity ratio, 1.
    pub fn eccentricity(self) -> f64 {
        -(-self.u).exp_m1()
    }

    /// The angle between eccentricity and load, rad, from 0 to pi.
    pub fn angle(self) -> f64 {
        let core = CORE * (-self.u).exp();
        4.0 * (core * (self.s * asinh(1.0 / core)).sinh()).min(1.0).atan()
    }
}

/// `asinh(x)` for `x >= 0`.
fn asinh(x: f64) -> f64 {
    (x + (x * x + 1.0).sqrt()).ln()
}

/// `tan(phi / 4)` for `phi` from 0 to pi, by half-angle formulas that do not cancel at either end.
fn quarter_tangent(cos: f64, sin: f64) -> f64 {
    let (half_cos, half_sin) = if cos >= 0.0 {
        let half = (0.5 + 0.5 * cos).sqrt();
        (half, 0.5 * sin / half)
    } else {
        let half = (0.5 - 0.5 * cos).sqrt();
        (0.5 * sin / half, half)
    };
    half_sin / (1.0 + half_cos)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;

    #[test]
    fn there_and_back() {
        for e in [0.0, 0.3, 0.9, 0.9999] {
            for phi in [0.0, 1e-6, 0.01, 1.0, 3.0, PI] {
                let point = Point::new(1.0 - e, phi.cos(), phi.sin());
                assert!((point.angle() - phi).abs() < 1e-9, "{e} {phi} {point:?}");
                assert!((point.eccentricity() - e).abs() < 1e-12);
                assert!((0.0..=1.0 + 1e-12).contains(&point.s));
            }
        }
    }
}
