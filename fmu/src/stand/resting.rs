//! The film about a resting journal: stiffness, damping, and the speed at which a rotor would begin to whirl.

use std::f64::consts::PI;

use super::{Stand, unknowns};
use crate::bearing::{Press, Situation};
use journal_bearing::reynolds::Coefficients;
use nalgebra::Vector2;

/// The journal rests where it moves by less than this part of the clearance while the shaft turns by a radian, and where this is
/// the load's swing, as a part of it.
const RESTS: f64 = 1e-4;
/// Standard gravity, m/s2.
const GRAVITY: f64 = 9.806_65;
/// The threshold where no speed makes a rotor whirl, rad/s.
const NEVER: f64 = 1e9;

/// The linearised film; zero where the journal does not rest.
#[derive(Clone, Copy, Debug, Default)]
pub struct Resting {
    /// Stiffness, N/m, and damping, N.s/m.
    pub coefficients: Coefficients,
    /// The speed from which on a rigid rotor whirls whose weight is the load, rad/s.
    pub threshold: f64,
}

impl Stand {
    /// The film linearised about the journal, where it rests under a constant load.
    pub fn resting(&self) -> Resting {
        *self.resting.0.get_or_init(|| {
            let at = self.situation(0.0, &unknowns(&self.state));
            if !self.rests(&at) {
                return Resting::default();
            }
            let coefficients = self.film.coefficients(&self.bearing, &at);
            let load = at.load_magnitude();
            let threshold = coefficients.whirl_threshold(load / GRAVITY, at.speed);
            Resting { coefficients, threshold: threshold.min(NEVER) }
        })
    }

    /// Whether the journal rests, in the film of a turning shaft and under a load that a turn does not change.
    pub(super) fn rests(&self, at: &Situation) -> bool {
        let magnitude = at.load_magnitude();
        if magnitude == 0.0 || at.speed == 0.0 {
            return false;
        }
        let velocity = self.film.drift(&self.bearing, at, false, &mut Press::default()).velocity;
        let quarter = 0.5 * PI / at.speed.abs();
        let is_constant = |quarters: f64| {
            let (.., load) = self.driven(quarters * quarter);
            (Vector2::from(load) - Vector2::from(at.load)).norm() < RESTS * magnitude
        };
        Vector2::from(velocity).norm() < RESTS * at.speed.abs() && is_constant(1.0) && is_constant(2.0)
    }
}
