//! Units for variables. A model computes in SI units; display units are for people.
//!
//! A unit that is missing here is made in the same way:
//!
//! ```
//! use fmu_export::model::{BaseExponents, DisplayUnit, Unit};
//!
//! const VOLT: Unit = Unit {
//!     name: "V",
//!     base: BaseExponents { kg: 1, m: 2, s: -3, a: -1, ..BaseExponents::ONE },
//!     display: &[DisplayUnit { name: "mV", factor: 1e3, offset: 0.0 }],
//!     relative: false,
//! };
//! ```

use std::f64::consts::PI;

use crate::model::{BaseExponents, DisplayUnit, Unit};

const fn scaled(name: &'static str, factor: f64) -> DisplayUnit {
    DisplayUnit { name, factor, offset: 0.0 }
}

macro_rules! units {
    ($($(#[$doc:meta])* $id:ident = $name:literal, {$($base:ident: $exponent:literal),*}, [$($display:expr),*];)*) => {
        $($(#[$doc])* pub const $id: Unit = Unit {
            name: $name,
            #[allow(clippy::needless_update)]
            base: BaseExponents { $($base: $exponent,)* ..BaseExponents::ONE },
            display: &[$($display),*],
            relative: false,
        };)*
        /// All of them.
        const ALL: &[Unit] = &[$($id),*];
    };
}

/// The unit with this name.
pub fn named(name: &str) -> Option<&'static Unit> {
    ALL.iter().find(|unit| unit.name == name)
}

/// Temperature difference.
pub const KELVIN_DIFFERENCE: Unit = Unit { display: &[], relative: true, ..KELVIN };

units! {
    /// A ratio or a count.
    ONE = "1", {}, [scaled("%", 100.0)];
    /// Length.
    METRE = "m", {m: 1}, [scaled("mm", 1e3), scaled("um", 1e6)];
    /// Angle.
    RADIAN = "rad", {rad: 1}, [scaled("deg", 180.0 / PI)];
    /// Angular velocity.
    RADIAN_PER_SECOND = "rad/s", {s: -1, rad: 1}, [scaled("rpm", 30.0 / PI)];
    /// Area.
    SQUARE_METRE = "m2", {m: 2}, [scaled("cm2", 1e4), scaled("mm2", 1e6)];
    /// Mass.
    KILOGRAM = "kg", {kg: 1}, [scaled("g", 1e3)];
    /// Mass flow.
    KILOGRAM_PER_SECOND = "kg/s", {kg: 1, s: -1}, [];
    /// Velocity.
    METRE_PER_SECOND = "m/s", {m: 1, s: -1}, [scaled("km/h", 3.6), scaled("mm/s", 1e3)];
    /// Acceleration.
    METRE_PER_SECOND_SQUARED = "m/s2", {m: 1, s: -2}, [];
    /// Energy.
    JOULE = "J", {kg: 1, m: 2, s: -2}, [scaled("kJ", 1e-3)];
    /// Electric current.
    AMPERE = "A", {a: 1}, [scaled("mA", 1e3)];
    /// Voltage.
    VOLT = "V", {kg: 1, m: 2, s: -3, a: -1}, [scaled("mV", 1e3)];
    /// Electric resistance.
    OHM = "Ohm", {kg: 1, m: 2, s: -3, a: -2}, [];
    /// Amount of substance.
    MOLE = "mol", {mol: 1}, [];
    /// Luminous intensity.
    CANDELA = "cd", {cd: 1}, [];
    /// Frequency of a periodic event.
    HERTZ = "Hz", {s: -1}, [];
    /// Time.
    SECOND = "s", {s: 1}, [scaled("ms", 1e3)];
    /// Rate of a ratio or of a count.
    PER_SECOND = "1/s", {s: -1}, [];
    /// Rate of a temperature.
    KELVIN_PER_SECOND = "K/s", {s: -1, k: 1}, [];
    /// Force.
    NEWTON = "N", {kg: 1, m: 1, s: -2}, [scaled("kN", 1e-3)];
    /// Stiffness.
    NEWTON_PER_METRE = "N/m", {kg: 1, s: -2}, [scaled("N/mm", 1e-3)];
    /// Damping.
    NEWTON_SECOND_PER_METRE = "N.s/m", {kg: 1, s: -1}, [];
    /// Torque over angular velocity.
    NEWTON_METRE_SECOND_PER_RADIAN = "N.m.s/rad", {kg: 1, m: 2, s: -1, rad: -1}, [];
    /// Torque.
    NEWTON_METRE = "N.m", {kg: 1, m: 2, s: -2}, [scaled("mN.m", 1e3)];
    /// Power.
    WATT = "W", {kg: 1, m: 2, s: -3}, [];
    /// Pressure.
    PASCAL = "Pa", {kg: 1, m: -1, s: -2}, [scaled("MPa", 1e-6), scaled("GPa", 1e-9), scaled("bar", 1e-5), scaled("kPa", 1e-3)];
    /// Pressure-viscosity coefficient.
    PER_PASCAL = "1/Pa", {kg: -1, m: 1, s: 2}, [scaled("1/GPa", 1e9)];
    /// Specific wear rate: worn volume over force and sliding distance.
    SQUARE_METRE_PER_NEWTON = "m2/N", {kg: -1, m: 1, s: 2}, [scaled("mm3/(N.m)", 1e9)];
    /// Dynamic viscosity.
    PASCAL_SECOND = "Pa.s", {kg: 1, m: -1, s: -1}, [scaled("mPa.s", 1e3)];
    /// Kinematic viscosity.
    SQUARE_METRE_PER_SECOND = "m2/s", {m: 2, s: -1}, [scaled("mm2/s", 1e6)];
    /// Density.
    KILOGRAM_PER_CUBIC_METRE = "kg/m3", {kg: 1, m: -3}, [];
    /// Volume.
    CUBIC_METRE = "m3", {m: 3}, [scaled("dm3", 1e3)];
    /// Volume flow.
    CUBIC_METRE_PER_SECOND = "m3/s", {m: 3, s: -1}, [scaled("mm3/s", 1e9)];
    /// Temperature.
    KELVIN = "K", {k: 1}, [DisplayUnit { name: "degC", factor: 1.0, offset: -273.15 }];
    /// Coefficient of thermal expansion.
    PER_KELVIN = "1/K", {k: -1}, [];
    /// Heat capacity of a body.
    JOULE_PER_KELVIN = "J/K", {kg: 1, m: 2, s: -2, k: -1}, [];
    /// Thermal conductance between two bodies.
    WATT_PER_KELVIN = "W/K", {kg: 1, m: 2, s: -3, k: -1}, [];
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Exponents of a product such as `N.s/m2`, from those of its factors.
    fn product(name: &str) -> [i32; 8] {
        let (above, below) = name.split_once('/').unwrap_or((name, ""));
        let mut sum = [0; 8];
        for (factors, sign) in [(above, 1), (below, -1)] {
            for factor in factors.split('.').filter(|factor| !["", "1"].contains(factor)) {
                let (symbol, power) = match factor.strip_suffix(['2', '3']) {
                    Some(symbol) => (symbol, factor[symbol.len()..].parse::<i32>().unwrap()),
                    None => (factor, 1),
                };
                let base = ALL.iter().find(|unit| unit.name == symbol).unwrap().base;
                for (sum, (_, exponent)) in sum.iter_mut().zip(base.named()) {
                    *sum += sign * power * exponent;
                }
            }
        }
        sum
    }

    #[test]
    fn products_have_the_exponents_of_their_factors() {
        for unit in ALL.iter().filter(|unit| unit.name.contains(['/', '.', '2', '3'])) {
            let exponents = unit.base.named().map(|(_, exponent)| exponent);
            assert_eq!(exponents, product(unit.name), "{}", unit.name);
        }
        let named = |unit: Unit| unit.base.named().map(|(_, exponent)| exponent);
        for (unit, same) in [(NEWTON, "kg.m/s2"), (JOULE, "N.m"), (WATT, "J/s"), (PASCAL, "N/m2"), (HERTZ, "1/s")] {
            assert_eq!(named(unit), product(same), "{}", unit.name);
        }
        assert_eq!(product("V.A"), named(WATT));
        assert_eq!(product("Ohm.A"), named(VOLT));
    }
}
