//! Flow factors: how roughness helps or hinders the flow.

/// The pressure flow factor of isotropic Gaussian surfaces at a film ratio `H`, 1: `1 - 0.90 exp(-0.56 H)` (Patir & Cheng
/// 1978, J. Lubr. Technol. 100, 12-17, table of coefficients, for `H > 0.5`). It multiplies the flow through a gap of the
/// mean planes' distance. Below 0.5 the formula is extrapolated.
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn flow_factors_have_their_published_limits() {
        // Patir & Cheng 1978: 1 for smooth surfaces (large H), and values from the published coefficients.
        assert!((pressure_flow_factor(40.0) - 1.0).abs() < 1e-9);
        assert!((pressure_flow_factor(3.0) - 0.832).abs() < 1e-3);
        assert!((pressure_flow_factor(0.5) - 0.320).abs() < 1e-3);
        // Patir & Cheng 1979: no shear flow between smooth surfaces, the maximum near H = 1.2, continuous at H = 5.
        assert!(shear_flow_factor(40.0) < 1e-4 && shear_flow_factor(0.0) == 0.0);
        let [near, at, far] = [0.8, 1.2, 2.0].map(shear_flow_factor);
        assert!(at > near && at > far && (at - 0.81).abs() < 0.02, "{near} {at} {far}");
        let [below, above] = [5.0, 5.0 + 1e-9].map(shear_flow_factor);
        assert!((below / above - 1.0).abs() < 0.05, "{below} {above}");
    }
}
