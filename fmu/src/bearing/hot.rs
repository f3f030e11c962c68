//! The hot clearance: how thermal expansion changes the clearance that was measured cold.
//!
//! Bush and shaft each have one temperature, so that the shaft's radius grows by `R*alpha*(T - T0)`. The bush's bore grows in
//! the same way when the bush is free. A bush in a stiffer housing that expands less is held: a pressure p between bush and
//! housing makes their common surface one again. Both are Lame's thick-walled cylinders in plane stress (Timoshenko &
//! Goodier 1970, Theory of Elasticity, 3rd ed., art. 28), the housing with an outer radius that is large against the bush's.
//! With the bush between the radii a and b, its pressure and its bore's growth are
//!
//! ```text
//! p = (alpha_b - alpha_h)*(T - T0) / (((b^2 + a^2)/(b^2 - a^2) - nu)/E_b + (1 + nu)/E_h)
//! u = a*alpha_b*(T - T0) - p/E_b * 2*a*b^2/(b^2 - a^2)
//! ```
//!
//! p comes on top of the pressure of the press fit, which the measured clearance already contains. It may be negative: a housing
//! that expands more than its bush lets the fit off, and the bush follows as long as the fit holds.

use serde::{Deserialize, Serialize};

/// Poisson's ratio of bush and housing, 1: that of most metals.
const POISSON: f64 = 0.3;

/// How temperatures change the clearance.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum ThermalClearance {
    /// Not at all.
    #[default]
    Off,
    /// The bush expands freely.
    FreeBush,
    /// The bush is pressed into a housing.
    ConstrainedBush,
}

/// The parts' thermal expansion.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Expansion {
    /// How the clearance changes.
    pub thermal_clearance: ThermalClearance,
    /// Temperature at which the radial clearance was measured, K.
    pub reference: f64,
    /// Coefficient of thermal expansion of the bush, 1/K.
    pub bush: f64,
    /// The same of the shaft.
    pub shaft: f64,
    /// The same of the housing.
    pub housing: f64,
    /// Wall thickness of the bush, m.
    pub wall: f64,
    /// Young's modulus of the bush, Pa.
    pub bush_modulus: f64,
    /// The same of the housing.
    pub housing_modulus: f64,
}

impl Default for Expansion {
    /// Shaft, bush and housing of steel, measured at the reference temperature of ISO 1.
    fn default() -> Self {
        Self {
            thermal_clearance: ThermalClearance::Off,
            reference: 293.15,
            bush: 11.5e-6,
            shaft: 11.5e-6,
            housing: 11.5e-6,
            wall: 2.5e-3,
            bush_modulus: 210e9,
            housing_modulus: 210e9,
        }
    }
}

impl Expansion {
    /// Growth of the clearance, m, at temperatures of bush and shaft (K), of a bore and a shaft with these radii (m).
    pub fn growth(&self, [bore, shaft]: [f64; 2], [bush_at, shaft_at]: [f64; 2]) -> f64 {
        let warmer = bush_at - self.reference;
        let opening = match self.thermal_clearance {
            ThermalClearance::Off => return 0.0,
            ThermalClearance::FreeBush => bore * self.bush * warmer,
            ThermalClearance::ConstrainedBush => self.held(bore, warmer),
        };
        opening - shaft * self.shaft * (shaft_at - self.reference)
    }

    /// Growth of the bore, m, of a bush that its housing holds, both warmer by `warmer` K.
    fn held(&self, bore: f64, warmer: f64) -> f64 {
        let [inner, outer] = [bore, bore + self.wall].map(|radius| radius * radius);
        let wall = outer - inner;
        let yielding = ((outer + inner) / wall - POISSON) / self.bush_modulus + (1.0 + POISSON) / self.housing_modulus;
        let pressure = (self.bush - self.housing) * warmer / yielding;
        bore * (self.bush * warmer - pressure / self.bush_modulus * 2.0 * outer / wall)
    }
}
