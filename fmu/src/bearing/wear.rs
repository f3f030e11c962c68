//! Wear of the touching surfaces (Archard 1953, J. Appl. Phys. 24, 981-988): the worn volume is `V = k*F*s`, with the contact's
//! normal force F, the sliding distance s, and the specific wear rate `k = K/H` of wear coefficient over hardness.
//!
//! The volume is spread evenly over the bearing's surface, so that it opens the clearance everywhere by `V/(pi*D*B)`. That is right
//! for a shaft that wears under a load at rest. A bush wears deeper where the load presses, and takes on the journal's shape
//! there; the mean depth is then a lower bound of the deepest.

use super::parameters::Bearing;
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;

/// Wear of both surfaces together.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Wear {
    /// Specific wear rate k: worn volume over normal force and sliding distance, m²/N. Zero switches wear off.
    pub coefficient: f64,
}

impl Bearing {
    /// Rate of the mean wear depth, m/s, while the asperities turn `heat` watts into heat at a shaft speed, rad/s. Their heat is
    /// the friction coefficient times normal force times sliding speed, of which wear needs the last two.
    pub fn wear_rate(&self, heat: f64, speed: f64) -> f64 {
        let friction = self.contact_friction(speed).abs();
        if self.wear.coefficient == 0.0 || friction == 0.0 {
            return 0.0;
        }
        self.wear.coefficient * heat / friction / (PI * self.diameter * self.width)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 1e-16 m²/N under 800 N at 0.3927 m/s on 14.92 cm²: 2.105e-11 m/s.
    #[test]
    fn depth_grows_with_force_and_speed_and_not_with_friction() {
        let rate = |coefficient: f64, friction: f64| {
            let mut bearing = Bearing::default();
            bearing.wear.coefficient = coefficient;
            bearing.surface.boundary_friction = friction;
            let speed = 31.415_926_535_897_93;
            let heat = friction * 800.0 * 0.0125 * speed;
            bearing.wear_rate(heat, speed)
        };
        assert!((rate(1e-16, 0.05) / 2.105_263e-11 - 1.0).abs() < 1e-6);
        assert!((rate(1e-16, 0.10) / rate(1e-16, 0.05) - 1.0).abs() < 1e-12);
        assert_eq!(rate(0.0, 0.05), 0.0);
        assert_eq!(rate(1e-16, 0.0), 0.0);
    }
}
