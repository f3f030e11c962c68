//! Leaps of a film that takes steps of its own: turns of its approach to its orbit, the leap, and the turns of its landing. Turns
//! are those of its [scout](super::scout).

use super::{
    EVENTS, Stand,
    scout::{SETTLED, Scout, Turn, share},
};
use crate::multirate::NoLeap;
use fmu_export::model::{Fault, Log};

/// Turns that are resolved before a leap at the most: as a number, and as a share of all.
const APPROACH_TURNS: usize = 48;
const APPROACH_SHARE: f64 = 0.2;
/// An approach that still warms or cools the film by more than this, K, is resolved further: its sum is known to some tenths.
const ROUGH: f64 = 0.02;
/// A film whose heat is off its orbit's by more than this share after the approach does not follow the averaged heat closely enough.
const FAR: f64 = 0.05;
/// Up to this share of all turns.
const LONGEST_APPROACH: f64 = 0.5;
/// Turns that are resolved after it, where the film follows its orbit closely.
const LANDING_TURNS: usize = 2;
/// Up to this share of all turns.
const LONGEST_LANDING: f64 = 0.25;

impl Stand {
    /// Lets `span` seconds pass with a leap over most of its turns. If there is none, the log says why, and all turns are
    /// resolved.
    pub(super) fn leap_with_film(&mut self, span: f64, log: &mut dyn Log) -> Result<(), Fault> {
        let (before, film) = (self.state, self.film.clone());
        match self.leap_over_most(span) {
            Ok(scout) => log.log(
                EVENTS,
                format_args!("{} turns of the film at {} temperatures led the leap", scout.turns, scout.known.len()),
            ),
            Err(NoLeap::Closed(at)) => {
                self.state.temperatures = at;
                self.check_clearance()?;
            }
            Err(reason) => {
                log.log(EVENTS, format_args!("no leap, all turns are resolved: {reason}"));
                self.state = before;
                self.film.clone_from(&film);
            }
        }
        let done = self.resolve(span - (self.state.time - before.time));
        if done.is_err() {
            self.film = film;
            self.film.keep();
        }
        done
    }

    /// Leaps over all but the last turns of `span` seconds.
    fn leap_over_most(&mut self, span: f64) -> Result<Scout, NoLeap> {
        let cycle = self.cycle();
        let whole = (span / cycle) as usize;
        let most = APPROACH_TURNS.min((APPROACH_SHARE * whole as f64) as usize);
        let mut resolved = Vec::new();
        while resolved.len() < most && !repeats(&resolved, share(SETTLED, self)) {
            resolved.push(self.resolve_cycle()?);
        }
        self.check_swing()?;
        let mut scout = self.scout(&resolved)?;
        let first = scout.approach;
        if let Some(share) = first.map(|first| first.share).filter(|&share| share > FAR) {
            return Err(NoLeap::Untold(format!(
                "after the first turns the film's heat is still {:.0} % off that of its orbit",
                100.0 * share
            )));
        }
        while let Some(more) = scout.turns_until_left(ROUGH) {
            let needed = resolved.len() + more;
            if needed as f64 > LONGEST_APPROACH * whole as f64 {
                return Err(NoLeap::Untold(format!(
                    "the film needs {} turns to come near its orbit",
                    needed * self.turns_of_a_cycle()
                )));
            }
            for _ in 0..more {
                resolved.push(self.resolve_cycle()?);
            }
            scout = self.scout(&resolved)?;
        }
        let from = self.state.departure();
        let mut turns = whole - resolved.len() - LANDING_TURNS;
        let mut end = scout.lead(turns, &from)?;
        let landing = scout.landing(first, turns, &end)?;
        if landing as f64 > LONGEST_LANDING * whole as f64 {
            return Err(NoLeap::Untold(format!(
                "the film stays behind its orbit for {} turns",
                landing * self.turns_of_a_cycle()
            )));
        }
        if landing > 0 {
            turns -= landing;
            end = scout.lead(turns, &from)?;
        }
        if let Some(film) = scout.nearest(&end) {
            self.film = film;
        }
        let film = self.film.transient();
        let eccentricity = film.expect("only a transient film leads a leap").eccentricity();
        self.arrive(turns as f64 * cycle, eccentricity, end);
        self.state.means.restart();
        Ok(scout)
    }

    /// A scout at the present place, after these turns of the approach.
    fn scout(&self, resolved: &[Turn]) -> Result<Scout, NoLeap> {
        let mut scout = Scout::new(self)?;
        scout.look(self.state.temperatures)?;
        scout.see_the_approach(resolved)?;
        Ok(scout)
    }
}

/// Whether the last two turns have the same heat.
fn repeats(turns: &[Turn], close: f64) -> bool {
    let [.., before, last] = turns else {
        return false;
    };
    let change = last.flows.minus(&before.flows);
    change.viscous.abs() + change.boundary.abs() < close * last.flows.heat()
}
