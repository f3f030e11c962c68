//! The steady start: temperatures at which heat in, averaged over the load's turn on its periodic orbit, equals heat out.
//!
//! The averaged heat balance ([`multirate::equilibrium()`]) finds the equilibrium that the given temperatures reach. It holds
//! the film's temperature constant within a turn, and its orbits have the errors of a leap. Newton's method on turns that are
//! resolved with all unknowns removes both. The stand is on its periodic orbit when a turn changes nothing: `P(y) = y`. The
//! temperatures' part of the turn's derivative is nearly `exp(J*T)`, with J of the averaged balance, so that
//! `(1 - exp(J*T)) dy = P(y) - y` gives the next start (Lust, Roose, Spence & Champneys 1998, SIAM J. Sci. Comput. 19,
//! 1188-1209: the few slow directions by Newton's method; the others settle by themselves). The journal's
//! two directions follow Broyden's method ([`newton`]), which begins with the slopes that the averaged balance has found.
//!
//! Most of the cost is that of the last turns, which must be exact. So the first ones are rough, and the averaged balance knows
//! the clearance's part from few orbits ([`Across::Parabolas`]).
//!
//! For the Reynolds film the mobility film's balance chooses the equilibrium and gives J. Every turn of the refinement is one
//! of the Reynolds film, so that its own heat is balanced.
//!
//! Where speed and load repeat themselves only after several turns of the shaft, a turn here is all of these.

pub mod newton;

use super::{EVENTS, Stand, State, Unknowns, unknowns, validity::SeenByLimits};
use crate::{
    Result,
    drive::MOST_TURNS,
    multirate::{self, Across, Departure, Equilibrium, Matrix4, NoEquilibrium, NoLeap, Vector4, vector},
    sensors::{Sensed, TurnMeans},
    solver::{Budget, DormandPrince, Failure},
    thermal::Initialization,
};
use fmu_export::model::{Fault, Log};
use nalgebra::Vector2;
use newton::{Newton, Turn, lasting};
use std::fmt::Display;

/// The tolerance of the averaged balance, which later turns refine.
const AVERAGED: f64 = 1e-6;
/// Errors allowed per step in a turn that refines: of the eccentricity ratio, and of the temperatures, K.
const PLACE_ERROR: f64 = 2e-9;
const TEMPERATURE_ERROR: f64 = 2e-9;
/// The first turn allows more by this factor, and each later one this share of what the one before has missed. A heat balance
/// with a longer time constant than this, s, magnifies errors of a turn too much for that.
const ROUGH: f64 = 500.0;
const SHARE: f64 = 1e-3;
const QUICK: f64 = 1e4;
/// Change of the temperatures, K, that a change of the eccentricity ratio by one brings about, roughly.
const WARMING: f64 = 20.0;
/// The steady state is known when the last turn moved its temperatures by less than this, K, and its eccentricity
/// ratio by less than this.
const CLOSE: f64 = 1e-6;
const CLOSE_PLACE: f64 = 1e-7;
/// Turns that refine, at most.
const TURNS: usize = 60;
/// Turns of a film that takes steps of its own, at most.
const FILM_TURNS: usize = 300;
/// Newton's method begins when a turn moves the journal by less than this, or after so many turns.
const NEAR_ORBIT: f64 = 1e-2;
const LANDING_TURNS: usize = 20;
/// The largest change of a temperature from turn to turn, K.
const LARGEST_CHANGE: f64 = 10.0;
/// The least share of Newton's change that is taken.
const LEAST_SHARE: f64 = 0.05;
/// The refinement may not leave the averaged equilibrium by more than this, K.
const FARTHEST: f64 = 5.0;
/// Internal steps in one such turn, at most, for each of the shaft's turns in it.
const STEPS: usize = 1_000_000;

impl Stand {
    /// Starts in the steady state, if the parameters ask for it. Isothermal temperatures are steady as they are; only the
    /// journal then starts on its orbit.
    pub(super) fn settle(&mut self, log: &mut dyn Log) -> Result {
        if self.thermal.initialization == Initialization::Given {
            return Ok(());
        }
        self.check_steadiness()?;
        // Wear never rests: the steady state is that of the bearing before it wears.
        let wear = std::mem::take(&mut self.bearing.wear);
        let settled = self.settle_unworn(log);
        self.bearing.wear = wear;
        settled
    }

    fn settle_unworn(&mut self, log: &mut dyn Log) -> Result {
        let from = self.state.departure();
        let (drift, turns) = if self.film.is_transient() {
            self.settle_across(Across::Cubics, &from)?
        } else {
            let begin = self.state;
            // Few orbits will do for nearly every stand; where they do not, more may.
            self.settle_across(Across::Parabolas, &from).or_else(|_| {
                self.state = begin;
                self.settle_across(Across::Cubics, &from)
            })?
        };
        let t = &self.state.temperatures;
        log.log(
            EVENTS,
            format_args!(
                "steady state: film {:.3} K, bush {:.3} K, shaft {:.3} K, oil {:.3} K; slowest time constant {:.0} s; \
                 {turns} turns refined it",
                t.film,
                t.bush,
                t.shaft,
                t.oil,
                multirate::slowest_time_constant(&drift)
            ),
        );
        Ok(())
    }

    /// Returns the linearised heat balance, and the number of turns that refined its equilibrium.
    fn settle_across(&mut self, across: Across, from: &Departure) -> Result<(Matrix4, usize)> {
        let fast = self.clone().with_a_fast_film()?;
        let equilibrium = multirate::equilibrium(&fast, AVERAGED, across, from).map_err(|why| self.refuse(&why))?;
        let turns = if self.film.is_transient() {
            self.refine_transient(&fast, &equilibrium)?
        } else {
            self.refine(&equilibrium)?
        };
        Ok((equilibrium.drift, turns * self.turns_of_a_cycle()))
    }

    /// Refuses what has no steady state: there must be a turn that repeats, and heat must be able to leave.
    fn check_steadiness(&self) -> Result {
        if self.inputs.speed.value == 0.0 {
            return Err(refusal(
                "drive.speed is 0, so that there is no turn over which heat could be averaged: set a speed",
            ));
        }
        if self.common_turns().is_none() {
            return Err(refusal(format_args!(
                "turns of {:.4e} s and a fluctuation of drive.fluctuationFrequency = {:?} Hz have no common period of up to \
                 {MOST_TURNS} turns: set another frequency, or drive.fluctuationAmplitude = 0",
                self.turn(),
                self.drive.fluctuation_frequency
            )));
        }
        if !self.thermal.isothermal && !self.thermal.loses_heat() {
            return Err(refusal(
                "no heat can leave: thermal.bushAmbientConductance, thermal.shaftAmbientConductance and \
                 thermal.oilAmbientConductance are all 0",
            ));
        }
        Ok(())
    }

    /// The refusal for want of an equilibrium, with the parameter to look at.
    fn refuse(&self, why: &NoEquilibrium) -> Fault {
        match why {
            NoEquilibrium::Runaway { .. } => refusal(format_args!(
                "{why}: friction heats more than thermal.oilAmbientConductance and the other conductances let out"
            )),
            NoEquilibrium::Orbit(NoLeap::Closed(at)) => match self.seizure(at, self.state.worn) {
                Some(seizure) => refusal(seizure),
                None => refusal(why),
            },
            NoEquilibrium::Unstable { .. } => {
                refusal(format_args!("{why}: set thermal.initialBearingTemperature away from it"))
            }
            other => refusal(format_args!("{other}; {}", self.advice())),
        }
    }

    /// Newton's method on resolved turns. Returns their number.
    fn refine(&mut self, equilibrium: &Equilibrium) -> Result<usize> {
        self.state.eccentricity = equilibrium.eccentricity;
        self.state.temperatures = equilibrium.temperatures;
        let period = self.cycle();
        let slow = vector(&equilibrium.temperatures);
        let quick = (0.0..QUICK).contains(&multirate::slowest_time_constant(&equilibrium.drift));
        let mut newton = Newton::new(equilibrium, period, self.thermal.isothermal);
        let mut step = self.turn() / 100.0;
        let mut slack = if quick { ROUGH } else { 1.0 };
        for turn in 1..=TURNS {
            let start = unknowns(&self.state);
            let (end, means) = self
                .steady_turn(&start, slack, &mut step)
                .map_err(|failure| refusal(self.explain(failure, &start, 0..7)))?;
            let seen = Turn::of(&start, &end, slack * PLACE_ERROR);
            newton.learn(seen);
            let Some(change) = newton.change() else {
                break;
            };
            let e = Vector2::from(self.state.eccentricity) + change.place;
            let t = vector(&self.state.temperatures) + change.temperatures;
            if !((t - slow).amax() < FARTHEST && e.norm() < multirate::reach(seen.place, seen.place + seen.miss)) {
                break;
            }
            self.state.eccentricity = e.into();
            self.state.temperatures = multirate::temperatures(&t);
            let (warmer, moved) = (change.temperatures.amax(), seen.miss.norm());
            if slack == 1.0 && warmer < CLOSE && moved < CLOSE_PLACE {
                self.state.means = self.last_turn(means)?;
                return Ok(turn);
            }
            let off = moved.max(warmer / WARMING);
            let next = (SHARE * off / PLACE_ERROR).clamp(1.0, slack);
            // The step size is proportional to the fifth root of the allowed error.
            step *= (next / slack).powf(0.2);
            slack = next;
        }
        Err(refusal(format_args!("journal and temperatures have found no periodic orbit; {}", self.advice())))
    }

    /// The same for a film that takes steps of its own. Its oil and its journal settle by themselves from turn to turn;
    /// only the temperatures are set. `fast` is the same stand with the mobility film, whose heat changes over the
    /// temperature in nearly the same way.
    fn refine_transient(&mut self, fast: &Self, equilibrium: &Equilibrium) -> Result<usize> {
        let begin = self.state;
        let mut t = vector(&equilibrium.temperatures);
        let (mut share, mut last) = (1.0_f64, None::<Vector4>);
        for turn in 1..=FILM_TURNS {
            let start = self.state.eccentricity;
            self.state = State { temperatures: multirate::temperatures(&t), eccentricity: start, ..begin };
            self.resolve(self.cycle()).map_err(refusal)?;
            let end = self.state.eccentricity;
            let moved = (end[0] - start[0]).hypot(end[1] - start[1]);
            let miss = vector(&self.state.temperatures) - t;
            let warmer = fast.warmer(&t, &miss)?;
            let change = warmer.amax();
            if moved < NEAR_ORBIT || turn > LANDING_TURNS {
                share = match last {
                    // The lumped balance may be off by a factor here, which two changes tell (Aitken's method; Irons & Tuck 1969,
                    // Int. J. Numer. Methods Eng. 1, 275-277).
                    Some(last) if self.has_warm_film() => {
                        let bend: Vector4 = warmer - last;
                        let told = -share * last.dot(&bend) / bend.norm_squared();
                        told.clamp(LEAST_SHARE, 1.0)
                    }
                    _ => 1.0,
                };
                share = share.min(LARGEST_CHANGE / change);
                last = Some(warmer);
                t += warmer * share;
            }
            if change < CLOSE && moved < CLOSE_PLACE {
                self.state = State {
                    temperatures: multirate::temperatures(&t),
                    eccentricity: end,
                    means: self.state.means.begin_turn(),
                    ..begin
                };
                return Ok(turn);
            }
        }
        Err(refusal(format_args!(
            "journal, oil and temperatures have found no periodic orbit after {FILM_TURNS} turns; {}",
            self.advice()
        )))
    }

    /// Newton's change of the temperatures `t`, which a turn has moved by `miss`.
    fn warmer(&self, t: &Vector4, miss: &Vector4) -> Result<Vector4> {
        if self.thermal.isothermal {
            return Ok(Vector4::zeros());
        }
        let from = Departure::at([0.0; 2], multirate::temperatures(t), self.state.worn);
        let drift = multirate::drift(self, AVERAGED, &from).map_err(refusal)?;
        (Matrix4::identity() - lasting(&drift, self.cycle()))
            .lu()
            .solve(miss)
            .ok_or_else(|| refusal("the heat balance has no definite solution"))
    }

    /// The unknowns a turn later, with errors that are `slack` times as large, and the sensors' means over it.
    fn steady_turn(&self, start: &Unknowns, slack: f64, step: &mut f64) -> Result<(Unknowns, Sensed), Failure> {
        const T: f64 = TEMPERATURE_ERROR;
        let integrator = DormandPrince {
            allowed: [PLACE_ERROR, PLACE_ERROR, T, T, T, T, f64::INFINITY].map(|error| slack * error),
            budget: Budget::of(STEPS * self.turns_of_a_cycle()),
        };
        let mut y = *start;
        let mut oil = self.nearby;
        let mut seen = SeenByLimits::default();
        let course = |tau: f64, y: &Unknowns| self.course_at(tau, y, &mut oil, &mut seen);
        let (_, integrals) = integrator.integrate_along(course, &mut y, [], self.cycle(), step)?;
        Ok((y, integrals.map(|integral| integral / self.cycle())))
    }

    /// The sensors' means over the shaft's last turn, from those over all turns of a cycle. If there are several, another cycle
    /// shows the last one.
    fn last_turn(&self, means: Sensed) -> Result<TurnMeans> {
        if self.turns_of_a_cycle() == 1 {
            return Ok(TurnMeans::after(means));
        }
        let mut ahead = self.clone();
        ahead.solver.tolerance = PLACE_ERROR;
        ahead.resolve(ahead.cycle()).map_err(refusal)?;
        Ok(ahead.state.means.begin_turn())
    }
}

fn refusal(why: impl Display) -> Fault {
    Fault::Invalid(format!("thermal.initialization = SteadyState: {why}"))
}
