//! Shear stress factors: how roughness raises the friction of sliding surfaces.
//!
//! The mean shear stress on isotropic rough surfaces is `eta U/h (phi_f +- phi_fs) +- phi_fp h/2 dp/dx` (Patir & Cheng
//! 1979, J. Lubr. Technol. 101, 220-230), where `phi_fs` carries the difference of both surfaces' shares of the variance.
//! This stress omits the pressure on the flanks of the roughness, which brakes the surfaces too. A smooth surface has no
//! flanks, so all of its braking is shear; and by the balance of forces the other surface is braked as much. Hence, however
//! the roughness is shared between the surfaces,
//!
//! * sliding is resisted by `phi_f + phi_fs`, with `phi_fs` at its full size;
//! * a pressure gradient acts with the mean gap, half on each surface, and with the shear flow `sigma phi_s` on one surface
//!   against the other. For a smooth surface the sum is `phi_fp h`, as it must be.
//!
//! Lengths are in units of the composite rms roughness `sigma`.

/// Film ratio above which `phi_fs` is zero.
const MOST_FOR_SHEAR: f64 = 7.0;

/// The factor `phi_f` at a film ratio `H`, 1: the mean of `h / h_T` over the local gaps `h_T` that exceed a hundredth of
/// the roughness (Patir & Cheng 1979). This is their closed form, in which the polynomial `35/96 (1 - (x/3)^2)^3`,
/// `|x| < 3`, stands for the normal density.
pub fn sliding_stress_factor(ratio: f64) -> f64 {
    ratio * thinness(ratio)
}

/// `phi_f / H`, which stays finite where the mean planes cross.
fn thinness(ratio: f64) -> f64 {
    let z = ratio / 3.0;
    let square = z * z;
    let parabola = (1.0 - square).powi(3);
    let sum = if z <= CLOSED {
        0.0
    } else if z <= 1.0 {
        let series =
            [-55.0, 132.0, 345.0, -160.0, -405.0, 60.0, 147.0].iter().rev().fold(0.0, |sum, term| sum * z + term);
        parabola * (300.0 * (z + 1.0)).ln() + series / 60.0
    } else if z <= 10.0 {
        let series = 66.0 + square * (30.0 * square - 80.0);
        parabola * ((z + 1.0) / (z - 1.0)).ln() + z / 15.0 * series
    } else {
        // Series in the first moments of the distribution.
        let inverse = (ratio * ratio).recip();
        return (1.0 + inverse * (1.0 + 27.0 / 11.0 * inverse)) / ratio;
    };
    (35.0 / 96.0 * sum).max(0.0)
}

/// `H / 3` below which all of the gap is under the cut-off.
const CLOSED: f64 = 1.0 / 300.0 - 1.0;

/// The factor `phi_fs` of one isotropic surface at a film ratio `H`, 1: `11.1 H^2.31 exp(-2.38 H + 0.11 H^2)` up to `H = 7`,
/// zero beyond (Patir & Cheng 1979, table of coefficients).
pub fn shear_stress_factor(ratio: f64) -> f64 {
    if ratio <= 0.0 || ratio > MOST_FOR_SHEAR {
        0.0
    } else {
        11.1 * ratio.powf(2.31) * (ratio * (0.11 * ratio - 2.38)).exp()
    }
}

/// Resistance to the sliding of rough surfaces, `(phi_f + phi_fs) / H`.
pub fn sliding_resistance(ratio: f64) -> f64 {
    let flanks = if ratio > 0.0 { shear_stress_factor(ratio) / ratio } else { 0.0 };
    thinness(ratio) + flanks
}

#[cfg(test)]
mod tests {
    use super::super::{mean_gap, shear_flow_factor};
    use super::*;

    /// The factor `phi_fp` of isotropic surfaces at a film ratio `H`, 1: `1 - 1.40 exp(-0.66 H)` (Patir & Cheng 1979, table of
    /// coefficients, for `H > 0.75`). It is the share of shear in the force of a pressure gradient on a surface.
    fn pressure_stress_factor(ratio: f64) -> f64 {
        1.0 - 1.40 * (-0.66 * ratio).exp()
    }

    /// The mean of `1/h` over the published distribution and cut-off, by the midpoint rule over `ln h`.
    fn mean_thinness(ratio: f64) -> f64 {
        let (least, most) = ((ratio - 3.0).max(0.01), ratio + 3.0);
        let parts = 20_000;
        let d = (most / least).ln() / f64::from(parts);
        let density = |x: f64| 35.0 / 96.0 * (1.0 - x * x / 9.0).powi(3);
        let at = |k: i32| least * ((f64::from(k) + 0.5) * d).exp();
        (0..parts).map(|k| density(at(k) - ratio)).sum::<f64>() * d
    }

    #[test]
    fn the_closed_form_is_the_integral() {
        for ratio in [-2.0, -1.0, -0.3, 0.0, 0.5, 1.0, 2.0, 2.999, 3.001, 5.0, 12.0, 29.9] {
            let (mean, expected) = (thinness(ratio), mean_thinness(ratio));
            assert!((mean - expected).abs() < 0.003, "{ratio}: {mean} {expected}");
            assert!(ratio < 3.0 || (mean / expected - 1.0).abs() < 1e-6, "{ratio}");
        }
        let [below, above] = [30.0, 30.0 + 1e-9].map(thinness);
        assert!((below / above - 1.0).abs() < 1e-6);
        assert_eq!(thinness(-2.999), 0.0);
        assert_eq!(thinness(-1e9), 0.0);
    }

    #[test]
    fn stress_factors_have_their_published_values_and_limits() {
        // Computed by hand from the table of coefficients.
        for (ratio, shear, pressure) in [
            (1.0, 11.1 * (-2.27_f64).exp(), 1.0 - 1.4 * (-0.66_f64).exp()),
            (2.0, 11.1 * 4.9588 * (-4.32_f64).exp(), 0.6260),
            (4.0, 11.1 * 24.590 * (-7.76_f64).exp(), 0.9001),
        ] {
            assert!((shear_stress_factor(ratio) / shear - 1.0).abs() < 1e-4, "{ratio}");
            assert!((pressure_stress_factor(ratio) - pressure).abs() < 1e-4, "{ratio}");
        }
        // Smooth surfaces.
        for (ratio, least) in [(40.0, 1e-3), (1e6, 1e-11)] {
            assert!((sliding_stress_factor(ratio) - 1.0).abs() < least, "{ratio}");
            assert_eq!(shear_stress_factor(ratio), 0.0);
            assert!((pressure_stress_factor(ratio) - 1.0).abs() < least);
            assert!((sliding_resistance(ratio) * ratio - 1.0).abs() < least);
        }
        assert!(sliding_resistance(-20.0) == 0.0 && sliding_resistance(0.0) > 1.7);
    }

    /// Pressure acts on a smooth surface against a rough one by shear alone, `phi_fp h`. By Onsager's reciprocity this equals
    /// the mean gap less the shear flow. Both fits were published independently; they agree within their scatter.
    #[test]
    fn the_factors_are_reciprocal() {
        for k in 4..=28 {
            let ratio = 0.25 * f64::from(k);
            let flow = (mean_gap(ratio) - shear_flow_factor(ratio)) / ratio;
            let stress = pressure_stress_factor(ratio);
            assert!((flow - stress).abs() < 0.02, "{ratio}: {flow} {stress}");
        }
    }
}
