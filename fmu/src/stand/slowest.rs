//! The slowest time constant of the heat balance, which tells how long a run must be for its temperatures to settle.
//!
//! Friction changes with the oil's temperature, so that the time constant is not that of the conductances alone: where
//! warmer oil means more friction, temperatures settle more slowly, or run away. The linearised balance takes the heat
//! averaged over the journal's periodic orbit at each film temperature; for a film that takes steps of its own, the orbit of
//! the mobility film.

use super::{Stand, inputs::INPUTS, unknowns, validity::SeenByLimits};
use crate::{
    Result,
    bearing::{Film, Flows},
    multirate::{self, Departure, Vector4},
};
use std::sync::{Mutex, PoisonError};

/// The tolerance of the orbits.
const TOLERANCE: f64 = 1e-6;
/// The orbits are computed at temperatures that are multiples of this, K. So the time constant follows from the state
/// alone, and a host that reads it after each short step does not pay for orbits each time.
const GRAIN: f64 = 0.1;
/// The same for wear depths, m: some 1e-5 of a clearance.
const WEAR_GRAIN: f64 = 1e-10;

/// The time constant that was computed last, s, and for what. It is `None` where there is no orbit.
pub type Last = Mutex<Option<(Key, Option<f64>)>>;

/// Temperatures and wear depth in grains, and the inputs.
type Key = ([i64; 4], i64, [u64; INPUTS]);

impl Stand {
    /// The slowest time constant of the heat balance at the present temperatures, s, negative where a deviation grows, and
    /// zero when isothermal or before the start.
    pub fn slowest_time_constant(&self) -> f64 {
        if self.thermal.isothermal {
            return 0.0;
        }
        let grains: [f64; 4] = multirate::vector(&self.state.temperatures).map(|t| (t / GRAIN).round()).into();
        let wear = (self.state.worn / WEAR_GRAIN).round();
        let inputs = self.inputs.all().map(|input| input.value.to_bits());
        let key = (grains.map(|grain| grain as i64), wear as i64, inputs);
        let temperatures = multirate::temperatures(&(Vector4::from(grains) * GRAIN));
        let from = Departure::at([0.0; 2], temperatures, wear * WEAR_GRAIN);
        let mut remembered = self.slowest.0.lock().unwrap_or_else(PoisonError::into_inner);
        let averaged = match *remembered {
            Some((known, value)) if known == key => value,
            _ => {
                let value = self.averaged_at(&from);
                *remembered = Some((key, value));
                value
            }
        };
        averaged.unwrap_or_else(|| self.under_present_friction(&from))
    }

    /// The time constant under the heat averaged over the orbit there; `None` where there is no orbit.
    fn averaged_at(&self, from: &Departure) -> Option<f64> {
        let drift = if self.inputs.speed.value == 0.0 {
            // At rest there is no friction heat.
            multirate::network(self, from, &Flows::default())
        } else {
            let mut still = self.clone();
            still.drive.fluctuation_amplitude = 0.0;
            // The last digits of an orbit depend on where it begins.
            (still.state.time, still.state.angle) = (0.0, 0.0);
            still.inputs.each(|input| input.slope = 0.0);
            let fast = still.with_a_fast_film().ok()?;
            multirate::drift(&fast, TOLERANCE, from).ok()?
        };
        Some(multirate::slowest_time_constant(&drift))
    }

    /// The time constant where the friction stays as it is now. It depends on where the journal is, so it is not remembered.
    fn under_present_friction(&self, from: &Departure) -> f64 {
        let at = &from.temperatures;
        let viscosity = self.fluid.viscosity(at.film);
        let clearance = self.clearance(at, from.worn);
        let drift = self.drift(0.0, self.state.eccentricity, viscosity, clearance, &mut SeenByLimits::default());
        let drift = multirate::network(self, from, &drift.flows);
        multirate::slowest_time_constant(&drift)
    }

    /// The same stand with the mobility film in place of one that takes steps of its own, which would need seconds for
    /// its orbits.
    pub(super) fn with_a_fast_film(mut self) -> Result<Self> {
        if self.film.is_transient() {
            self.assumed_feed = self.feed_after_a_turn();
            self.film = Film::mobility(&self.bearing)?;
        }
        Ok(self)
    }

    /// What the feeds bring a turn later at the present temperatures, m³/s; zero where that turn cannot be resolved.
    fn feed_after_a_turn(&self) -> f64 {
        if !self.bearing.supply.feeds() {
            return 0.0;
        }
        let mut ahead = self.clone();
        ahead.thermal.isothermal = true;
        match ahead.resolve(ahead.turn()) {
            Ok(()) => ahead.read(0.0, &unknowns(&ahead.state)).feed_flow,
            Err(_) => 0.0,
        }
    }
}
