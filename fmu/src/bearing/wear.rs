//! Wear of the touching surfaces (Archard 1953, J. Appl. Phys. 24, 981-988): the worn volume is `V = k*F*s`, with the contact's
//! normal force F, the sliding distance s, and the specific wear rate `k = K/H` of wear coefficient over hardness.
//!
//! The volume is spread evenly over the bearing's surface, so that it opens the clearance everywhere by `V/(pi*D*B)`. That is right
//! for a shaft that wears under a load at rest. A bush wears deeper where the load presses, and takes on the journal's shape
//! there; the mean depth is then a lower bound of the deepest.

use serde::{Deserialize, Serialize};

/// Wear of both surfaces together.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct Wear {
    /// Specific wear rate k: worn volume over normal force and sliding distance, m²/N. Zero switches wear off.
    pub coefficient: f64,
}

impl Wear {
    /// Rate of the mean wear depth over an area (m²), m/s, while asperities turn `heat` watts into heat at a friction
    /// coefficient. Their heat is the friction coefficient times normal force times sliding speed, of which wear needs the last
    /// two. Zero where there is no friction.
    pub fn rate(&self, heat: f64, friction: f64, area: f64) -> f64 {
        if friction == 0.0 {
            return 0.0;
        }
        self.coefficient * heat / friction / area
    }
}
