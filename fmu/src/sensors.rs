//! The virtual sensors: the readings of the physical stand's sensors, and quantities that no sensor can measure.

mod turn;

use serde::{Deserialize, Serialize};
pub use turn::{TurnMeans, Worst};

/// The readings of the sensors that the physical stand has, in the order of its fields in [`Readings`]: F_N (N), M (N.m),
/// P_fr (W), mu (1), temperatures of the oil bath and the bush (K).
pub type Sensed = [f64; SENSORS];

/// The number of sensors that the physical stand has.
pub const SENSORS: usize = 6;

/// Declares the readings, real numbers.
macro_rules! readings {
    ($($(#[$doc:meta])* $field:ident,)*) => {
        /// The outputs of the stand at one instant, SI.
        #[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
        pub struct Readings {
            $($(#[$doc])* pub $field: f64,)*
        }

        impl Readings {
            /// The mean rates, per second, from these readings to those `span` seconds later.
            pub fn rates_to(&self, later: &Self, span: f64) -> Self {
                Self { $($field: (later.$field - self.$field) / span,)* }
            }
        }
    };
}

readings! {
    /// Force on the bearing F_N along the load line, N.
    load_force,
    /// Friction torque on the shaft M, N.m.
    friction_torque,
    /// Friction power `M*omega`, W.
    friction_power,
    /// Friction coefficient `M/(F*D/2)`, 1, over the load's magnitude; zero where there is no load.
    friction_coefficient,
    /// Temperature of the oil bath, K.
    oil_temperature,
    /// Temperature of the bush, K.
    bearing_temperature,
    /// Temperature of the shaft, K.
    shaft_temperature,
    /// Eccentricity ratio, 1.
    eccentricity_ratio,
    /// Attitude angle from the load line to the eccentricity, rad.
    attitude_angle,
    /// Smallest film thickness, m.
    min_film_thickness,
    /// Largest film pressure, Pa.
    max_film_pressure,
    /// Viscosity of the film, Pa.s.
    film_viscosity,
    /// Temperature of the film, K.
    film_temperature,
    /// Highest temperature of the film around the bearing, K.
    max_film_temperature,
    /// Oil that leaves the film at both ends, m³/s.
    side_flow,
    /// Oil that comes in through feeds, m³/s.
    feed_flow,
    /// How far the mean planes of journal and bush cross, over the roughness, 1.
    contact_reach,
    /// Share of the load that the asperities carry, 1.
    contact_share,
    /// Friction torque of the asperities, N.m.
    contact_torque,
    /// Shaft speed with its fluctuation, rad/s.
    shaft_speed,
    /// Shaft angle since the start, rad.
    shaft_angle,
    /// Radial clearance that the film sees, m.
    hot_radial_clearance,
    /// Velocity of the journal along the load, m/s.
    journal_velocity,
    /// Mean wear depth, m.
    wear_depth,
    /// Heat flow to the surroundings, W.
    ambient_heat_flow,
    /// Heat capacity of the oil bath at its temperature, J/K.
    oil_bath_capacity,
}

impl Readings {
    /// The readings of the sensors that the physical stand has.
    pub fn sensed(&self) -> Sensed {
        [
            self.load_force,
            self.friction_torque,
            self.friction_power,
            self.friction_coefficient,
            self.oil_temperature,
            self.bearing_temperature,
        ]
    }
}

/// The ratio of a force to the load's magnitude, 1, such as the friction coefficient `M/(F_N*D/2)` (the paper's formula for mu_fr, with
/// the M that is missing in print). Zero without a load. Near zero load it is cut off a little below the largest value that
/// the variables' ranges allow, so that its means, which are rounded, stay within them, too.
pub fn load_ratio(force: f64, load: f64) -> f64 {
    const MOST: f64 = 0.999e9;
    if load == 0.0 {
        return 0.0;
    }
    (force / load).clamp(-MOST, MOST)
}
