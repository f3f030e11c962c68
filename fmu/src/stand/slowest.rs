//! The slowest time constant of the heat balance, which tells how long a run must be for its temperatures to settle.
//!
//! Friction changes with the oil's temperature, so that the time constant is not that of the conductances alone: where
//! warmer oil means more friction, temperatures settle more slowly, or run away. The linearised balance takes the heat
//! averaged over the journal's periodic orbit at each film temperature; for a film that takes steps of its own, the orbit of
//! the mobility film.

use super::Stand;
use super::inputs::Inputs;
use crate::bearing::{Film, Flows};
use crate::multirate::{self, Departure};
use crate::thermal::Temperatures;
use fmu_export::model::Fault;
use std::sync::{Mutex, PoisonError};

/// The tolerance of the orbits.
const TOLERANCE: f64 = 1e-6;
/// The time constant is computed at temperatures that are multiples of this, K. So it follows from the state alone, and a
/// host that reads it after each short step does not pay for orbits each time.
const GRAIN: f64 = 0.1;

/// The time constant that was computed last, s, and for what: film and oil temperature in grains, speed and external force.
#[derive(Debug, Default)]
pub(super) struct Remembered(Mutex<Option<(Key, f64)>>);

type Key = ([i64; 2], [u64; 2]);

impl Clone for Remembered {
    /// A clone may get other parameters, so that it computes anew.
    fn clone(&self) -> Self {
        Self::default()
    }
}

impl Remembered {
    /// Forgets, as parameters have changed.
    pub(super) fn forget(&mut self) {
        *self = Self::default();
    }
}

impl Stand {
    /// The slowest time constant of the heat balance at the present temperatures, s, negative where a deviation grows, and
    /// zero when isothermal or before the start.
    pub fn slowest_time_constant(&self) -> f64 {
        if self.thermal.isothermal {
            return 0.0;
        }
        let t = &self.state.temperatures;
        let Inputs {
            speed,
            external_force,
            ..
        } = &self.inputs;
        let grains = [t.film, t.oil].map(|t| (t / GRAIN).round() as i64);
        let key = (
            grains,
            [speed.value.to_bits(), external_force.value.to_bits()],
        );
        let mut remembered = self
            .slowest
            .0
            .lock()
            .unwrap_or_else(PoisonError::into_inner);
        match *remembered {
            Some((known, value)) if known == key => value,
            _ => {
                let value = self.linearised_at(grains.map(|grain| grain as f64 * GRAIN));
                *remembered = Some((key, value));
                value
            }
        }
    }

    /// The time constant at temperatures of film and oil, K.
    fn linearised_at(&self, [film, oil]: [f64; 2]) -> f64 {
        let mut still = self.clone();
        still.drive.fluctuation_amplitude = 0.0;
        for input in still.inputs.all() {
            input.slope = 0.0;
        }
        // The other temperatures enter the balance linearly, so that its derivatives do not depend on them.
        let at = Temperatures {
            film,
            oil,
            ..self.state.temperatures
        };
        let from = Departure {
            before: [0.0; 2],
            eccentricity: [0.0; 2],
            temperatures: at,
        };
        let drift = if self.inputs.speed.value == 0.0 {
            // At rest there is no friction heat.
            multirate::network(self, &at, &Flows::default())
        } else {
            let fast = still.with_a_fast_film().ok();
            let averaged = fast.and_then(|fast| multirate::drift(&fast, TOLERANCE, &from).ok());
            // Without an orbit, the friction counts as constant.
            averaged.unwrap_or_else(|| {
                let viscosity = self.fluid.viscosity(film);
                let (_, flows) = self.drift(0.0, self.state.eccentricity, viscosity);
                multirate::network(self, &at, &flows)
            })
        };
        multirate::slowest_time_constant(&drift)
    }

    /// The same stand with the mobility film in place of one that takes steps of its own, which would need seconds for
    /// its orbits.
    pub(super) fn with_a_fast_film(mut self) -> Result<Self, Fault> {
        if self.film.is_transient() {
            self.film = Film::mobility(&self.bearing)?;
        }
        Ok(self)
    }
}
