//! The steady start: temperatures at which heat in, averaged over the load's turn on its periodic orbit, equals heat out.
//!
//! The averaged heat balance ([`multirate::equilibrium`]) finds the equilibrium that the given temperatures reach. It holds
//! the film's temperature constant within a turn, and its orbits have the errors of a leap. Newton's method on turns that are
//! resolved with all unknowns removes both. The stand is on its periodic orbit when a turn changes nothing: `P(y) = y`. The
//! temperatures' part of the turn's derivative is nearly `exp(J*T)`, with J of the averaged balance, so that
//! `(1 - exp(J*T)) dy = P(y) - y` gives the next start (Lust, Roose, Spence & Champneys 1998, SIAM J. Sci. Comput. 19,
//! 1188-1209: the few slow directions by Newton's method; the others settle by themselves). The journal's
//! two directions follow Broyden's method, which begins with the slope that the averaged balance has found.
//!
//! For the Reynolds film the mobility film's balance chooses the equilibrium and gives J. Every turn of the refinement is one
//! of the Reynolds film, so that its own heat is balanced.

use super::{EVENTS, Stand, State, Unknowns, unknowns};
use crate::multirate::{
    self, Departure, Equilibrium, Matrix4, NoEquilibrium, NoLeap, Vector4, vector,
};
use crate::sensors::{Sensed, TurnMeans};
use crate::solver::{Budget, DormandPrince, Failure, Quadrature};
use crate::thermal::Initialization;
use fmu_export::model::{Fault, Log};
use nalgebra::{Const, LU, Matrix2, SVector, Vector2};
use std::fmt::Display;

/// The tolerance of the averaged balance, which later turns refine.
const AVERAGED: f64 = 1e-6;
/// Errors allowed per step in a turn that refines: of the eccentricity ratio, and of the temperatures, K.
const PLACE_ERROR: f64 = 1e-9;
const TEMPERATURE_ERROR: f64 = 1e-9;
/// The first turns allow more by this factor. They bring the temperatures so near that Newton's method needs no more of
/// the later turns. A heat balance with a longer time constant than this, s, magnifies errors of a turn too much for that.
const ROUGH: f64 = 100.0;
const QUICK: f64 = 1e4;
const ROUGH_TURNS: usize = 2;
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
/// The refinement may not leave the averaged equilibrium by more than this, K.
const FARTHEST: f64 = 5.0;
/// Internal steps in one such turn, at most.
const STEPS: usize = 1_000_000;

impl Stand {
    /// Starts in the steady state, if the parameters ask for it. Isothermal temperatures are steady as they are; only the
    /// journal then starts on its orbit.
    pub(super) fn settle(&mut self, log: &mut dyn Log) -> Result<(), Fault> {
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

    fn settle_unworn(&mut self, log: &mut dyn Log) -> Result<(), Fault> {
        let from = Departure {
            before: self.state.eccentricity,
            eccentricity: self.state.eccentricity,
            temperatures: self.state.temperatures,
            worn: self.state.worn,
        };
        let fast = self.clone().with_a_fast_film()?;
        let found =
            multirate::equilibrium(&fast, AVERAGED, &from).map_err(|why| self.refuse(&why))?;
        let turns = if self.film.is_transient() {
            self.refine_transient(&fast, &found)?
        } else {
            self.refine(&found)?
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
                multirate::slowest_time_constant(&found.drift)
            ),
        );
        Ok(())
    }

    /// Refuses what has no steady state: there must be a turn that repeats, and heat must be able to leave.
    fn check_steadiness(&self) -> Result<(), Fault> {
        if self.inputs.speed.value == 0.0 {
            return Err(refusal(
                "drive.speed is 0, so that there is no turn over which heat could be averaged: set a speed",
            ));
        }
        if self.drive.fluctuation_amplitude != 0.0 {
            return Err(refusal(
                "turns do not repeat while the speed fluctuates: set drive.fluctuationAmplitude = 0",
            ));
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
            NoEquilibrium::Unstable { .. } => refusal(format_args!(
                "{why}: set thermal.initialBearingTemperature away from it"
            )),
            other => refusal(format_args!("{other}; {}", self.advice())),
        }
    }

    /// Newton's method on resolved turns. Returns their number.
    fn refine(&mut self, found: &Equilibrium) -> Result<usize, Fault> {
        self.state.eccentricity = found.eccentricity;
        self.state.temperatures = found.temperatures;
        let near = unknowns(&self.state);
        let period = self.period();
        let slow = Vector4::from_row_slice(&near[2..6]);
        let settle = settling(&found.drift, period);
        let mut step = period / 100.0;
        let quick = (0.0..QUICK).contains(&multirate::slowest_time_constant(&found.drift));
        let rough_turns = if quick { ROUGH_TURNS } else { 0 };
        let mut slope = found.slope;
        let mut before: Option<(Vector2<f64>, Vector2<f64>)> = None;
        for turn in 1..=TURNS {
            let start = unknowns(&self.state);
            let from = Vector2::from(self.state.eccentricity);
            let slack = if turn <= rough_turns { ROUGH } else { 1.0 };
            let (end, means) = self
                .steady_turn(&start, slack, &mut step)
                .map_err(|failure| refusal(self.explain(failure, &start, 0..7)))?;
            let miss = SVector::<f64, 7>::from(end) - SVector::from(start);
            let warmer = if self.thermal.isothermal {
                Vector4::zeros()
            } else {
                settle
                    .solve(&miss.fixed_rows::<4>(2).into_owned())
                    .ok_or_else(|| refusal("the heat balance has no definite solution"))?
            };
            let place: Vector2<f64> = miss.fixed_rows::<2>(0).into();
            if let Some((e, miss)) = before {
                // Broyden's correction: a turn's end moves by what its beginning and its miss move.
                let (moved, missed) = (from - e, place - miss);
                if moved.norm() > CLOSE_PLACE {
                    slope +=
                        (moved + missed - slope * moved) * moved.transpose() / moved.norm_squared();
                }
            }
            // Differences of rough turns would tell more of their errors.
            before = (slack == 1.0).then_some((from, place));
            let shift = found.shift * warmer[0];
            let back = Matrix2::identity() - slope;
            let Some(closer) = back.lu().solve(&place) else {
                break;
            };
            let e = from + closer + shift;
            let t = Vector4::from_row_slice(&start[2..6]) + warmer;
            if !((t - slow).amax() < FARTHEST && e.norm() < 1.0) {
                break;
            }
            self.state.eccentricity = e.into();
            self.state.temperatures = multirate::temperatures(&t);
            if turn > rough_turns && warmer.amax() < CLOSE && place.norm() < CLOSE_PLACE {
                self.state.means = TurnMeans::after(means);
                return Ok(turn);
            }
        }
        Err(refusal(format_args!(
            "journal and temperatures have found no periodic orbit; {}",
            self.advice()
        )))
    }

    /// The same for a film that takes steps of its own. Its oil and its journal settle by themselves from turn to turn;
    /// only the temperatures are set. `fast` is the same stand with the mobility film, whose heat changes over the
    /// temperature in nearly the same way.
    fn refine_transient(&mut self, fast: &Self, found: &Equilibrium) -> Result<usize, Fault> {
        let begin = self.state;
        let mut t = vector(&found.temperatures);
        for turn in 1..=FILM_TURNS {
            let start = self.state.eccentricity;
            self.state = State {
                temperatures: multirate::temperatures(&t),
                eccentricity: start,
                ..begin
            };
            self.resolve(self.period()).map_err(refusal)?;
            let end = self.state.eccentricity;
            let moved = (end[0] - start[0]).hypot(end[1] - start[1]);
            let miss = vector(&self.state.temperatures) - t;
            let warmer = fast.warmer(&t, &miss)?;
            let change = warmer.amax();
            if moved < NEAR_ORBIT || turn > LANDING_TURNS {
                t += warmer * (LARGEST_CHANGE / change).min(1.0);
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
    fn warmer(&self, t: &Vector4, miss: &Vector4) -> Result<Vector4, Fault> {
        if self.thermal.isothermal {
            return Ok(Vector4::zeros());
        }
        let from = Departure {
            before: [0.0; 2],
            eccentricity: [0.0; 2],
            temperatures: multirate::temperatures(t),
            worn: self.state.worn,
        };
        let drift = multirate::drift(self, AVERAGED, &from).map_err(refusal)?;
        settling(&drift, self.period())
            .solve(miss)
            .ok_or_else(|| refusal("the heat balance has no definite solution"))
    }

    /// The unknowns a turn later, with errors that are `slack` times as large, and the sensors' means over it.
    fn steady_turn(
        &self,
        start: &Unknowns,
        slack: f64,
        step: &mut f64,
    ) -> Result<(Unknowns, Sensed), Failure> {
        const T: f64 = TEMPERATURE_ERROR;
        let integrator = DormandPrince {
            allowed: [PLACE_ERROR, PLACE_ERROR, T, T, T, T, f64::INFINITY]
                .map(|error| slack * error),
            budget: Budget::of(STEPS),
        };
        let mut y = *start;
        let mut oil = self.nearby;
        let course = |tau: f64, y: &Unknowns| {
            let (rates, Sensed(sensed)) = self.course_at(tau, y, &mut oil);
            (rates, sensed)
        };
        let any = Quadrature::default();
        let (_, integrals) =
            integrator.integrate_along(course, &mut y, any, self.period(), step)?;
        let means = Sensed(integrals).map(|integral| integral / self.period());
        Ok((y, means))
    }
}

fn refusal(why: impl Display) -> Fault {
    Fault::Invalid(format!("thermal.initialization = SteadyState: {why}"))
}

/// `1 - exp(J*T)` of a drift J over a turn's duration T: what is left of a change of the temperatures after a turn.
fn settling(drift: &Matrix4, period: f64) -> LU<f64, Const<4>, Const<4>> {
    (Matrix4::identity() - (drift * period).exp()).lu()
}
