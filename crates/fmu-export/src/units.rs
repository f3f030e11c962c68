//! The units of the stand's variables. All values inside are SI; display units are for people.

use crate::model::{DisplayUnit, Unit};
use std::f64::consts::PI;

const fn scaled(name: &'static str, factor: f64) -> DisplayUnit {
    DisplayUnit {
        name,
        factor,
        offset: 0.0,
    }
}

macro_rules! units {
    ($($(#[$doc:meta])* $id:ident = $name:literal, $exponents:expr, [$($display:expr),*];)*) => {
        $($(#[$doc])* pub const $id: Unit = Unit { name: $name, exponents: $exponents, display: &[$($display),*], relative: false };)*
    };
}

/// Temperature difference.
pub const KELVIN_DIFFERENCE: Unit = Unit {
    display: &[],
    relative: true,
    ..KELVIN
};

// Exponents: kg, m, s, K, rad.
units! {
    /// A ratio or a count.
    ONE = "1", [0, 0, 0, 0, 0], [scaled("%", 100.0)];
    /// Length.
    METRE = "m", [0, 1, 0, 0, 0], [scaled("mm", 1e3), scaled("um", 1e6)];
    /// Angle.
    RADIAN = "rad", [0, 0, 0, 0, 1], [scaled("deg", 180.0 / PI)];
    /// Angular velocity.
    RADIAN_PER_SECOND = "rad/s", [0, 0, -1, 0, 1], [scaled("rpm", 30.0 / PI)];
    /// Frequency of a periodic event.
    HERTZ = "Hz", [0, 0, -1, 0, 0], [];
    /// Time.
    SECOND = "s", [0, 0, 1, 0, 0], [scaled("ms", 1e3)];
    /// Force.
    NEWTON = "N", [1, 1, -2, 0, 0], [scaled("kN", 1e-3)];
    /// Stiffness.
    NEWTON_PER_METRE = "N/m", [1, 0, -2, 0, 0], [scaled("N/mm", 1e-3)];
    /// Damping.
    NEWTON_SECOND_PER_METRE = "N.s/m", [1, 0, -1, 0, 0], [];
    /// Torque.
    NEWTON_METRE = "N.m", [1, 2, -2, 0, 0], [scaled("mN.m", 1e3)];
    /// Power.
    WATT = "W", [1, 2, -3, 0, 0], [];
    /// Pressure.
    PASCAL = "Pa", [1, -1, -2, 0, 0], [scaled("MPa", 1e-6), scaled("GPa", 1e-9), scaled("bar", 1e-5)];
    /// Pressure-viscosity coefficient.
    PER_PASCAL = "1/Pa", [-1, 1, 2, 0, 0], [scaled("1/GPa", 1e9)];
    /// Dynamic viscosity.
    PASCAL_SECOND = "Pa.s", [1, -1, -1, 0, 0], [scaled("mPa.s", 1e3)];
    /// Kinematic viscosity.
    SQUARE_METRE_PER_SECOND = "m2/s", [0, 2, -1, 0, 0], [scaled("mm2/s", 1e6)];
    /// Density.
    KILOGRAM_PER_CUBIC_METRE = "kg/m3", [1, -3, 0, 0, 0], [];
    /// Volume.
    CUBIC_METRE = "m3", [0, 3, 0, 0, 0], [scaled("dm3", 1e3)];
    /// Volume flow.
    CUBIC_METRE_PER_SECOND = "m3/s", [0, 3, -1, 0, 0], [scaled("mm3/s", 1e9)];
    /// Temperature.
    KELVIN = "K", [0, 0, 0, 1, 0], [DisplayUnit { name: "degC", factor: 1.0, offset: -273.15 }];
    /// Heat capacity of a body.
    JOULE_PER_KELVIN = "J/K", [1, 2, -2, -1, 0], [];
    /// Thermal conductance between two bodies.
    WATT_PER_KELVIN = "W/K", [1, 2, -3, -1, 0], [];
}
