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

#[cfg(test)]
mod tests {
    use super::*;

    const RADII: [f64; 2] = [0.0125, 0.01248];

    /// A bush of bronze in a housing of steel.
    fn bronze() -> Expansion {
        Expansion { bush: 18e-6, bush_modulus: 110e9, ..Expansion::default() }
    }

    fn growth(thermal_clearance: ThermalClearance, set: impl FnOnce(&mut Expansion)) -> f64 {
        let mut expansion = Expansion { thermal_clearance, ..bronze() };
        set(&mut expansion);
        expansion.growth(RADII, [353.15, 363.15])
    }

    use ThermalClearance::{ConstrainedBush, FreeBush, Off};

    /// 60 K on the bore's 12.5 mm at 18e-6/K are 13.5 um, 70 K on the shaft's 12.48 mm at 11.5e-6/K are 10.0464 um.
    #[test]
    fn a_free_bush_and_its_shaft_grow_with_their_temperatures() {
        assert_eq!(growth(Off, |_| ()), 0.0);
        assert!((growth(FreeBush, |_| ()) - (13.5e-6 - 10.0464e-6)).abs() < 1e-15);
    }

    /// Parts of one material at one temperature stay similar: the clearance grows like every other length.
    #[test]
    fn one_material_at_one_temperature_keeps_its_shape() {
        for fit in [FreeBush, ConstrainedBush] {
            let expansion =
                Expansion { thermal_clearance: fit, bush: 20e-6, shaft: 20e-6, housing: 20e-6, ..Expansion::default() };
            let grown = expansion.growth(RADII, [393.15, 393.15]);
            assert!((grown - 20e-6 * 20e-6 * 100.0).abs() < 1e-15, "{grown}");
        }
    }

    #[test]
    fn a_housing_that_expands_alike_or_is_soft_leaves_the_bush_free() {
        let free = growth(FreeBush, |_| ());
        let alike = growth(ConstrainedBush, |e| e.housing = e.bush);
        assert!((alike - free).abs() < 1e-18, "{alike} {free}");
        let soft = growth(ConstrainedBush, |e| e.housing_modulus = 1e-9 * e.bush_modulus);
        assert!((soft - free).abs() < 1e-8 * free, "{soft} {free}");
    }

    /// A rigid housing sets the outer radius b. The bush's free growth exceeds the housing's by the strain `d`, and an outer
    /// displacement of `-b*d` moves the bore by `-a*d*2b^2/(b^2 + a^2 - nu*(b^2 - a^2))`.
    #[test]
    fn a_rigid_housing_sets_the_outer_radius() {
        let rigid = growth(ConstrainedBush, |e| e.housing_modulus = 1e9 * e.bush_modulus);
        let (a2, b2) = (12.5_f64.powi(2), 15_f64.powi(2));
        let inwards = 6.5e-6 * 60.0 * 2.0 * b2 / (b2 + a2 - 0.3 * (b2 - a2));
        let expected = 0.0125 * (18e-6 * 60.0 - inwards) - 10.0464e-6;
        assert!((rigid - expected).abs() < 1e-13, "{rigid} {expected}");
        // A thin bush has the bore of its housing.
        let thin = growth(ConstrainedBush, |e| {
            e.wall = 1e-8;
            e.housing_modulus = 1e9 * e.bush_modulus;
        });
        let of_the_housing = 0.0125 * 11.5e-6 * 60.0 - 10.0464e-6;
        assert!((thin - of_the_housing).abs() < 1e-10, "{thin}");
    }

    /// Radii, stresses and displacements of both cylinders in numbers: an own solution of the three conditions (free bore, equal
    /// pressures, equal displacements) for the four constants of `u = A*r + B/r` in bush and housing.
    #[test]
    fn the_pressure_joins_bush_and_housing() {
        let held = growth(ConstrainedBush, |_| ());
        let e = bronze();
        let (a, b, nu) = (0.0125_f64, 0.015_f64, 0.3);
        // Bush: sigma_r = E/(1-nu) A - E/(1+nu) B/r^2 beyond the thermal strain; zero at a.
        let of_b = |r: f64| e.bush_modulus * ((1.0 / a.powi(2) - 1.0 / r.powi(2)) / (1.0 + nu));
        // A = B (1-nu)/(1+nu)/a^2 from the free bore, and the housing u = C/r with sigma_r = -E/(1+nu) C/r^2.
        let slope = (1.0 - nu) / (1.0 + nu) / a.powi(2);
        // Equal stress at b: of_b(b)*B = -E_h/(1+nu)*C/b^2; equal displacement: (slope*b + 1/b)*B + d*b = C/b.
        let d = (e.bush - e.housing) * 60.0;
        let c_over_b = -of_b(b) * b.powi(2) * (1.0 + nu) / e.housing_modulus;
        let constant = d * b / (c_over_b / b - (slope * b + 1.0 / b));
        let expected = constant * (slope * a + 1.0 / a) + a * e.bush * 60.0 - 10.0464e-6;
        assert!((held - expected).abs() < 1e-14, "{held} {expected}");
    }
}
