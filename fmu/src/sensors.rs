//! The virtual sensors: the readings of the physical stand's sensors, and quantities that no sensor can measure.

mod turn;

use serde::{Deserialize, Serialize};
pub use turn::TurnMeans;

/// The readings of the sensors that the physical stand has, in the order of its fields in [`Readings`]: F_N (N), M (N.m),
/// P_fr (W), mu (1), temperatures of the oil bath and the bush (K).
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Sensed(pub [f64; 6]);

impl Sensed {
    /// The number of sensors.
    pub const COUNT: usize = 6;

    /// A formula applied to each.
    pub fn map(&self, formula: impl Fn(f64) -> f64) -> Self {
        Self(self.0.map(formula))
    }

    fn plus(&self, other: &Self) -> Self {
        Self(std::array::from_fn(|i| self.0[i] + other.0[i]))
    }

    fn minus(&self, other: &Self) -> Self {
        Self(std::array::from_fn(|i| self.0[i] - other.0[i]))
    }
}

/// The outputs of the stand at one instant, SI.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Readings {
    /// Force on the bearing F_N, N.
    pub load_force: f64,
    /// Friction torque on the shaft M, N.m.
    pub friction_torque: f64,
    /// Friction power `M*omega`, W.
    pub friction_power: f64,
    /// Friction coefficient `M/(F_N*D/2)`, 1; zero where there is no load.
    pub friction_coefficient: f64,
    /// Temperature of the oil bath, K.
    pub oil_temperature: f64,
    /// Temperature of the bush, K.
    pub bearing_temperature: f64,
    /// Temperature of the shaft, K.
    pub shaft_temperature: f64,
    /// Eccentricity ratio, 1.
    pub eccentricity_ratio: f64,
    /// Attitude angle from the load line to the eccentricity, rad.
    pub attitude_angle: f64,
    /// Smallest film thickness, m.
    pub min_film_thickness: f64,
    /// Largest film pressure, Pa.
    pub max_film_pressure: f64,
    /// Viscosity of the film, Pa.s.
    pub film_viscosity: f64,
    /// Temperature of the film, K.
    pub film_temperature: f64,
    /// Oil that leaves the film at both ends, m³/s.
    pub side_flow: f64,
    /// Share of the load that the asperities carry, 1.
    pub contact_share: f64,
    /// Friction torque of the asperities, N.m.
    pub contact_torque: f64,
    /// Shaft speed with its fluctuation, rad/s.
    pub shaft_speed: f64,
    /// Shaft angle since the start, rad.
    pub shaft_angle: f64,
    /// Radial clearance that the film sees, m.
    pub hot_radial_clearance: f64,
    /// Velocity of the journal along the load, m/s.
    pub journal_velocity: f64,
    /// Mean wear depth, m.
    pub wear_depth: f64,
    /// Heat flow to the surroundings, W.
    pub ambient_heat_flow: f64,
    /// Heat capacity of the oil bath at its temperature, J/K.
    pub oil_bath_capacity: f64,
}

/// Applies a formula to each reading of two sets.
macro_rules! each_reading {
    ($formula:expr, $one:expr, $other:expr, [$($field:ident),*]) => {
        Readings { $($field: $formula($one.$field, $other.$field)),* }
    };
}

impl Readings {
    /// Those of the sensors that the physical stand has.
    pub fn sensed(&self) -> Sensed {
        Sensed([
            self.load_force,
            self.friction_torque,
            self.friction_power,
            self.friction_coefficient,
            self.oil_temperature,
            self.bearing_temperature,
        ])
    }

    /// The mean rates, per second, from these readings to those `span` seconds later.
    pub fn rates_to(&self, later: &Self, span: f64) -> Self {
        let rate = |begin: f64, end: f64| (end - begin) / span;
        each_reading!(
            rate,
            self,
            later,
            [
                load_force,
                friction_torque,
                friction_power,
                friction_coefficient,
                oil_temperature,
                bearing_temperature,
                shaft_temperature,
                eccentricity_ratio,
                attitude_angle,
                min_film_thickness,
                max_film_pressure,
                film_viscosity,
                film_temperature,
                side_flow,
                contact_share,
                contact_torque,
                shaft_speed,
                shaft_angle,
                hot_radial_clearance,
                journal_velocity,
                wear_depth,
                ambient_heat_flow,
                oil_bath_capacity
            ]
        )
    }
}

/// A force over the load, 1, such as the friction coefficient `M/(F_N*D/2)` (the paper's formula for mu_fr, with the M
/// that is missing in print). Zero without a load. Near zero load the ratio is cut off a little below the largest value that
/// the variables' ranges allow, so that its means, which are rounded, stay within them, too.
pub fn over_load(force: f64, load: f64) -> f64 {
    const MOST: f64 = 0.999e9;
    if load == 0.0 {
        return 0.0;
    }
    (force / load).clamp(-MOST, MOST)
}
