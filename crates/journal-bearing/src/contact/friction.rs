//! Friction of touching asperities.

use super::Surface;

/// Sliding speed, m/s, at which friction reaches 76 % of its value. It smooths the jump of Coulomb's law at standstill, at
/// which an integrator would have to stop.
const REVERSAL: f64 = 1e-6;

impl Surface {
    /// Friction coefficient of the touching asperities at a sliding speed, m/s, with the sign of the speed:
    /// `mu (1 + (r - 1) exp(-(v/v_s)^2))`, with the breakaway ratio r and the transition speed v_s (Armstrong-Helouvry,
    /// Dupont & Canudas de Wit 1994, Automatica 30, 1083-1138). From standstill on, the asperities resist with `mu r`. At
    /// standstill itself the law gives zero: Coulomb friction takes any value there up to `mu r`.
    ///
    /// Canudas de Wit, Olsson, Astrom & Lischinsky (1995), IEEE Trans. Autom. Control 40, 419-425, use a transition speed
    /// of 1 mm/s in their examples; it is the default here. The default ratio of 1 assumes no peak.
    ///
    /// ```
    /// use journal_bearing::contact::Surface;
    ///
    /// let surface = Surface { boundary_friction: 0.05, breakaway_ratio: 1.5, ..Surface::default() };
    /// assert!((surface.friction(5e-5) - 0.075).abs() < 1e-3); // barely sliding
    /// assert!((surface.friction(-0.4) + 0.05).abs() < 1e-12); // m/s, the other way
    /// ```
    pub fn friction(&self, sliding: f64) -> f64 {
        let peak = match self.breakaway_ratio - 1.0 {
            0.0 => 0.0,
            above => above * (-(sliding / self.transition_speed).powi(2)).exp(),
        };
        self.boundary_friction * (1.0 + peak) * direction(sliding)
    }
}

/// The sign of a sliding speed, m/s; gradual within some 20 um/s about standstill.
pub fn direction(sliding: f64) -> f64 {
    if sliding.abs() > 20.0 * REVERSAL { sliding.signum() } else { (sliding / REVERSAL).tanh() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn friction_falls_from_breakaway_to_sliding() {
        let surface =
            Surface { boundary_friction: 0.1, breakaway_ratio: 1.4, transition_speed: 2e-3, ..Surface::default() };
        let falling = 0.1 * (1.0 + 0.4 * (-1_f64).exp());
        for (sliding, expected) in [(0.0, 0.0), (3e-5, 0.14), (2e-3, falling), (0.4, 0.1)] {
            let apart = (surface.friction(sliding) - expected).abs();
            assert!(apart < 1e-4 * expected.max(1e-9), "{sliding}");
            assert_eq!(surface.friction(-sliding), -surface.friction(sliding));
        }
        let without_peak = Surface::default();
        assert_eq!(without_peak.friction(3e-5), without_peak.boundary_friction);
    }
}
