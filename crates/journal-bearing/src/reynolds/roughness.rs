//! The mean gap between rough surfaces, and flow factors for how roughness helps or hinders the flow.
//!
//! Lengths are in units of the composite rms roughness `sigma`: `H` is the film ratio, the distance of the surfaces' mean
//! planes over `sigma`.

use std::f64::consts::TAU;
use std::sync::LazyLock;

use serde::{Deserialize, Serialize};

/// How the film sees rough surfaces.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub enum RoughFilm {
    /// The film ignores the roughness: its gap is the distance of the mean planes, and must not close.
    #[default]
    Nominal,
    /// The film's gap is the mean gap that remains between the asperities, also where the mean planes cross.
    MeanGap,
    /// The mean gap, and the flow factors of Patir & Cheng (1978, 1979) for isotropic surfaces.
    FlowFactors {
        /// The journal's share of the composite roughness' variance, 0..1. At one half, the shear flows of both
        /// surfaces cancel.
        journal_share: f64,
    },
}

/// Below this film ratio the mean gap continues as an exponential: contact keeps surfaces from coming that close.
const LEAST: f64 = -5.0;
/// Above this film ratio the mean gap is the distance of the mean planes.
const MOST: f64 = 6.0;
/// Table nodes per unit of `H`.
const PER_UNIT: f64 = 32.0;

/// Mean gap and its slope at evenly spaced film ratios.
static MEAN_GAP: LazyLock<Vec<[f64; 2]>> = LazyLock::new(|| {
    let step = 1.0 / PER_UNIT;
    let count = ((MOST - LEAST) * PER_UNIT) as usize + 1;
    // The integration starts far below the table, where the leading terms of the tail are accurate.
    let far = LEAST - 4.0;
    let density = |x: f64| (-0.5 * x * x).exp() / TAU.sqrt();
    let mut slope = density(far) / far.abs();
    let mut gap = slope / far.abs();
    let mut x = far;
    let mut nodes = Vec::with_capacity(count);
    let parts = 8;
    let d = step / f64::from(parts);
    while nodes.len() < count {
        if x > LEAST - 0.5 * d {
            nodes.push([gap, slope]);
        }
        for _ in 0..parts {
            // Simpson's rule for the slope; for the gap, its second integral, the matching weights.
            let [a, b, c] = [x, x + 0.5 * d, x + d].map(density);
            gap += d * slope + d * d * (a + 2.0 * b) / 6.0;
            slope += d * (a + 4.0 * b + c) / 6.0;
            x += d;
        }
    }
    nodes
});

/// The mean gap between Gaussian surfaces over the roughness, `H Phi(H) + phi(H)`, and its derivative `Phi(H)`, the share
/// of the area where they do not touch. `Phi` is the normal distribution and `phi` its density (average gap of Patir &
/// Cheng 1978).
pub(super) fn mean_gap(ratio: f64) -> [f64; 2] {
    let position = (ratio - LEAST) * PER_UNIT;
    let nodes = &*MEAN_GAP;
    if position < 0.0 {
        let [gap, slope] = nodes[0];
        let fall = (slope / gap * (ratio - LEAST)).exp();
        return [gap * fall, slope * fall];
    }
    // The cast saturates for huge ratios.
    let cell = (position as usize).min(nodes.len());
    let (Some(&[a, slope_a]), Some(&[b, slope_b])) = (nodes.get(cell), nodes.get(cell + 1)) else {
        return [ratio, 1.0];
    };
    let t = position - cell as f64;
    let (slope_a, slope_b) = (slope_a / PER_UNIT, slope_b / PER_UNIT);
    let (rise, bend) = (b - a, slope_a + slope_b - 2.0 * (b - a));
    let curve = rise - slope_a - bend;
    let gap = a + t * (slope_a + t * (curve + t * bend));
    let slope = slope_a + t * (2.0 * curve + 3.0 * t * bend);
    [gap, slope * PER_UNIT]
}

/// The pressure flow factor of isotropic Gaussian surfaces at a film ratio `H`, 1: `1 - 0.90 exp(-0.56 H)` (Patir & Cheng
/// 1978, J. Lubr. Technol. 100, 12-17, table of coefficients, for `H > 0.5`). It multiplies the flow through a gap of the
/// mean planes' distance.
pub fn pressure_flow_factor(ratio: f64) -> f64 {
    1.0 - 0.90 * (-0.56 * ratio).exp()
}

/// The shear flow factor of one isotropic Gaussian surface at a film ratio `H`, 1: `1.899 H^0.98 exp(-0.92 H + 0.05 H^2)`
/// up to `H = 5`, `1.126 exp(-0.25 H)` beyond (Patir & Cheng 1979, J. Lubr. Technol. 101, 220-230, table of
/// coefficients).
pub fn shear_flow_factor(ratio: f64) -> f64 {
    if ratio <= 0.0 {
        0.0
    } else if ratio <= 5.0 {
        1.899 * ratio.powf(0.98) * (ratio * (0.05 * ratio - 0.92)).exp()
    } else {
        1.126 * (-0.25 * ratio).exp()
    }
}

/// The least film ratio of Patir & Cheng's simulations of the pressure flow.
const LEAST_FOR_FLOW: f64 = 0.5;

/// The pressure flow factor for a gap that is the *mean gap* instead of the mean planes' distance. Below the range of
/// Patir & Cheng's simulations it keeps its value at the end of the range.
pub(super) fn ease_of_mean_gap(ratio: f64) -> f64 {
    let ratio = ratio.max(LEAST_FOR_FLOW);
    pressure_flow_factor(ratio) * (ratio / mean_gap(ratio)[0]).powi(3)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// `Phi` to 7 decimals: Abramowitz & Stegun 1964, table 26.1.
    #[test]
    fn the_mean_gap_is_that_of_the_normal_distribution() {
        for (ratio, distribution) in [
            (-3.0, 0.001_349_9),
            (-1.0, 0.158_655_3),
            (0.0, 0.5),
            (0.44, 0.670_031_4),
            (2.0, 0.977_249_9),
        ] {
            let ratio: f64 = ratio;
            let density = (-0.5 * ratio * ratio).exp() / TAU.sqrt();
            let [gap, slope] = mean_gap(ratio);
            assert!((slope - distribution).abs() < 2e-7, "{ratio}: {slope}");
            let expected = ratio * distribution + density;
            assert!((gap - expected).abs() < 3e-7, "{ratio}: {gap} {expected}");
        }
        let [gap, slope] = mean_gap(5.999);
        assert!((gap - 5.999).abs() < 1e-8 && (slope - 1.0).abs() < 1e-8);
        assert_eq!(mean_gap(7.0), [7.0, 1.0]);
        assert_eq!(mean_gap(1e300), [1e300, 1.0]);
        // Below the table it tends to zero without a jump.
        let [above, below] = [-4.999, -5.001].map(|ratio| mean_gap(ratio)[0]);
        assert!(below > 0.0 && below < above && above < 1.1 * below);
        assert!(mean_gap(-20.0)[0] >= 0.0);
    }

    #[test]
    fn flow_factors_have_their_published_limits() {
        // Patir & Cheng 1978: 1 for smooth surfaces (large H), and values from the published coefficients.
        assert!((pressure_flow_factor(40.0) - 1.0).abs() < 1e-9);
        assert!((ease_of_mean_gap(40.0) - 1.0).abs() < 1e-9);
        assert!((pressure_flow_factor(3.0) - 0.832).abs() < 1e-3);
        assert!((pressure_flow_factor(0.5) - 0.320).abs() < 1e-3);
        // Patir & Cheng 1979: no shear flow between smooth surfaces, the maximum near H = 1.2, continuous at H = 5.
        assert!(shear_flow_factor(40.0) < 1e-4 && shear_flow_factor(0.0) == 0.0);
        let [near, at, far] = [0.8, 1.2, 2.0].map(shear_flow_factor);
        assert!(
            at > near && at > far && (at - 0.81).abs() < 0.02,
            "{near} {at} {far}"
        );
        let [below, above] = [5.0, 5.0 + 1e-9].map(shear_flow_factor);
        assert!((below / above - 1.0).abs() < 0.05, "{below} {above}");
    }
}
