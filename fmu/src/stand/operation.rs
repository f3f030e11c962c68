//! The check of an operating point by ISO 7902 (DIN 31652): load, film thickness, temperature and speed beside what is permitted.
//!
//! The standard is for a constant load. Here the worst of the last turn counts, as the stand's own film and heat balance give it.

use super::{Stand, unknowns, validity::SeenByLimits};
use crate::{
    bearing::{self, Strain},
    sensors::Worst,
};
use serde::{Deserialize, Serialize};

/// What is permitted.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Permitted {
    /// Load over the projected area, Pa.
    pub specific_load: f64,
    /// Temperature of bush and film, K.
    pub temperature: f64,
    /// Film thickness at which mixed friction begins, m; 0 takes it from the roughness.
    pub transition_gap: f64,
}

impl Default for Permitted {
    /// ISO 7902-3:1998: alloys of lead and tin, and lubrication without pressure, which are the lowest limits there.
    fn default() -> Self {
        Self { specific_load: 5e6, temperature: 363.15, transition_gap: 0.0 }
    }
}

/// The least film thickness, um, of ISO 7902-3:1998, second-hand (Roloff/Matek, Maschinenelemente, TB 15-16): a row up to each of
/// these diameters, m, and a column up to each of these sliding speeds, m/s. The shaft's surface has Rz of up to 4 um.
const DIAMETERS: [f64; 5] = [0.063, 0.16, 0.4, 1.0, 2.5];
const SPEEDS: [f64; 5] = [1.0, 3.0, 10.0, 30.0, f64::INFINITY];
const GAPS: [[f64; 5]; 5] = [
    [3.0, 4.0, 5.0, 7.0, 10.0],
    [4.0, 5.0, 7.0, 9.0, 12.0],
    [6.0, 7.0, 9.0, 11.0, 14.0],
    [8.0, 9.0, 11.0, 13.0, 16.0],
    [10.0, 12.0, 14.0, 16.0, 18.0],
];
/// The smallest diameter of the table, m.
const SMALLEST: f64 = 0.024;

/// Mixed friction begins at a gap of so many composite rms roughnesses (Hamrock, Schmid & Jacobson 2004, Fundamentals of Fluid Film
/// Lubrication: film parameter).
const FILM_PARAMETER: f64 = 3.0;

/// The largest number that is told.
const MOST: f64 = 1e9;

/// What the check tells.
#[derive(Clone, Copy, Debug, Default)]
pub struct Operation {
    /// The largest load of the turn over the projected area, Pa.
    pub specific_load: f64,
    /// `p psi^2/(eta omega)` under that load, 1.
    pub sommerfeld: f64,
    /// The least film thickness that is permitted, m.
    pub gap_limit: f64,
    /// The speed, of shaft and bush added, below which friction is mixed, rad/s.
    pub transition_speed: f64,
    /// The least ratio of what is permitted to what is, 1.
    pub margin: f64,
    /// The number of the criterion that has it: 1 load, 2 film thickness, 3 temperature, 4 speed, 5 outside of the standard.
    pub decides: i32,
}

impl Stand {
    /// The check by ISO 7902 at the present communication point.
    pub fn operation(&self) -> Operation {
        *self.operation.0.get_or_init(|| self.check_operation())
    }

    fn check_operation(&self) -> Operation {
        let bearing = &self.bearing;
        let at = self.situation(0.0, &unknowns(&self.state));
        let seen = SeenByLimits { at, temperatures: self.state.temperatures, ..SeenByLimits::default() };
        let worst = self.state.means.worst().unwrap_or_else(|| self.worst(&seen, self.readings.min_film_thickness));
        let specific_load = worst.load / (bearing.width * bearing.diameter);
        let psi = at.clearance / bearing.radius();
        let speed = (at.speed + at.bush_speed).abs();
        let parameter = specific_load * psi * psi / at.viscosity;

        let mixed = match self.permitted.transition_gap {
            0.0 => FILM_PARAMETER * bearing.surface.roughness,
            given => given,
        };
        let row = DIAMETERS.iter().position(|most| bearing.diameter <= *most);
        let column = SPEEDS.iter().position(|most| at.sliding().abs() * bearing.radius() <= *most);
        let tabulated = row.zip(column).map_or(0.0, |(row, column)| 1e-6 * GAPS[row][column]);
        let gap_limit = mixed.max(tabulated);
        let e = 1.0 - mixed / at.clearance;
        let transition_speed = match mixed {
            0.0 => 0.0,
            _ if e <= 0.0 => MOST,
            _ => (parameter / bearing::sommerfeld(bearing.width / bearing.diameter, e)).min(MOST),
        };

        let warmth = |temperature: f64| temperature - self.inputs.ambient_temperature.value;
        let margins = [
            self.permitted.specific_load / specific_load,
            worst.gap / gap_limit,
            // A bearing that is no warmer than the room is warm enough for none.
            match warmth(worst.temperature) {
                rise if rise > 0.0 => warmth(self.permitted.temperature) / rise,
                _ => MOST,
            },
            speed / transition_speed,
        ];
        let covered = row.is_some() && bearing.diameter >= SMALLEST && specific_load > 0.0 && speed > 0.0;
        let covered = covered && self.turbulent(&seen, &Strain::default()).is_none();
        let least = (1..).zip(margins).min_by(|a, b| a.1.total_cmp(&b.1)).filter(|_| covered);
        let (decides, margin) = least.map_or((5, 0.0), |(criterion, margin)| (criterion, margin.clamp(0.0, MOST)));
        let sommerfeld = if speed > 0.0 { (parameter / speed).min(MOST) } else { 0.0 };
        Operation { specific_load, sommerfeld, gap_limit, transition_speed, margin, decides }
    }

    /// What of an instant counts, with the smallest gap there, m.
    pub(super) fn worst(&self, seen: &SeenByLimits, gap: f64) -> Worst {
        let film = self.film.hottest().unwrap_or(seen.temperatures.film);
        Worst { load: seen.at.load_magnitude(), gap, temperature: film.max(seen.temperatures.bush) }
    }
}
