//! Cycles, after each of which speed and load repeat themselves: a turn of the shaft, or several where its speed fluctuates
//! ([`common_turns`](crate::drive::Drive::common_turns)). A leap goes over whole cycles, so that the fluctuation is as far on at its
//! end as at its beginning.

use super::Stand;
use crate::multirate::NoLeap;
use std::f64::consts::TAU;

/// Shorter communication steps, in cycles, are resolved turn by turn.
const FEWEST: f64 = 12.0;
/// The same with a film that takes steps of its own.
const FEWEST_OF_A_FILM: f64 = 40.0;
/// Wear follows from friction work and friction coefficient. A fluctuation of the speed may change the coefficient by this part
/// of it.
const EVEN: f64 = 1e-4;
/// The averaged heat belongs to temperatures that hardly move within a cycle. A fluctuation may swing them by this, K: then the bush
/// is less than 1 % of Table 2's tolerance off after a leap.
const SWING: f64 = 0.03;

impl Stand {
    /// The duration of a turn, s, at the mean speed.
    pub(super) fn turn(&self) -> f64 {
        TAU / self.inputs.speed.value.abs()
    }

    /// The turns of a cycle; `None` if speed and load do not repeat themselves.
    pub(super) fn common_turns(&self) -> Option<u32> {
        self.drive.common_turns(self.inputs.speed.value)
    }

    /// The same as a number. Nothing asks for it where they do not.
    pub(super) fn turns_of_a_cycle(&self) -> usize {
        self.common_turns().unwrap_or(1) as usize
    }

    /// The duration of a cycle, s.
    pub(super) fn cycle(&self) -> f64 {
        self.turns_of_a_cycle() as f64 * self.turn()
    }

    /// Whether a step should leap: it has enough cycles of constant inputs.
    pub(super) fn is_long(&self, span: f64) -> bool {
        let steady = (self.inputs.all().iter()).all(|input| input.slope == 0.0);
        let fewest = if self.film.is_transient() { FEWEST_OF_A_FILM } else { FEWEST };
        self.solver.multirate && steady && span > fewest * self.cycle()
    }

    /// Why no step leaps, however long it is.
    pub(super) fn hindrance(&self) -> Option<&'static str> {
        if self.common_turns().is_none() {
            return Some("drive.fluctuationFrequency and drive.speed have no common period");
        }
        if self.bearing.supply.feeds() && !self.thermal.isothermal {
            return Some("the oil that is fed cools the film");
        }
        if self.has_warm_film() {
            return Some("the film has a temperature around the bearing");
        }
        if self.inputs.bush_speed.value != 0.0 && !self.bearing.profile_file.is_empty() {
            return Some("the form error of the bush turns with it");
        }
        let wears = self.bearing.wear.coefficient > 0.0;
        if wears && self.film.is_transient() {
            return Some("the surfaces wear");
        }
        (wears && !self.wears_evenly())
            .then_some("the fluctuation of the speed changes the asperities' friction coefficient")
    }

    /// Whether the mean wear of a cycle follows from its mean friction work.
    fn wears_evenly(&self) -> bool {
        let [low, high] = [-1.0, 1.0].map(|sign| {
            let factor = 1.0 + sign * self.drive.fluctuation_amplitude;
            let speed = factor * self.inputs.speed.value;
            self.bearing.contact_friction(speed - self.inputs.bush_speed.value).abs()
        });
        (high - low).abs() <= EVEN * high
    }

    /// Refuses a leap over cycles within which the fluctuation swings a temperature too far.
    pub(super) fn check_swing(&self) -> Result<(), NoLeap> {
        let swing = self.swing();
        if swing <= SWING {
            return Ok(());
        }
        Err(NoLeap::Untold(format!("the fluctuation of the speed swings the temperatures by {swing:.1e} K")))
    }

    /// How far the fluctuation swings the temperatures of film, bush or shaft, K, roughly: as far as if the friction heat rose with
    /// the speed and stayed in one of them; of the film's, no further than what its conductances hold.
    fn swing(&self) -> f64 {
        let (drive, thermal) = (&self.drive, &self.thermal);
        if !drive.fluctuates() || thermal.isothermal {
            return 0.0;
        }
        let pace = TAU * drive.fluctuation_frequency;
        let film = (pace * thermal.film_capacity).max(thermal.film_bush + thermal.film_shaft);
        let bodies = pace * thermal.bush_capacity.min(thermal.shaft_capacity);
        drive.fluctuation_amplitude * self.heat() / film.min(bodies)
    }
}
