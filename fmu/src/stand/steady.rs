//! The steady start: temperatures at which heat in, averaged over the load's turn on its periodic orbit, equals heat out.
//!
//! The averaged heat balance ([`multirate::equilibrium`]) finds the equilibrium that the given temperatures reach. It holds
//! the film's temperature constant within a turn, and its orbits have the errors of a leap. Newton's method on turns that are
//! resolved with all unknowns removes both. The stand is on its periodic orbit when a turn changes nothing: `P(y) = y`. The
//! temperatures' part of the turn's derivative is nearly `exp(J*T)`, with J of the averaged balance, so that
//! `(1 - exp(J*T)) dy = P(y) - y` gives the next start (Lust, Roose, Spence & Champneys 1998, SIAM J. Sci. Comput. 19,
//! 1188-1209: the few slow directions by Newton's method; the others settle by themselves). The journal starts where its
//! orbit at the new temperature does, less its own miss.

use super::{EVENTS, Stand, Unknowns, temperatures, unknowns};
use crate::multirate::{self, Departure, Equilibrium, NoEquilibrium};
use crate::solver::{Budget, DormandPrince, Failure};
use crate::thermal::Initialization;
use fmu_export::model::{Fault, Log};
use nalgebra::{SVector, Vector2};
use std::fmt::Display;

/// The tolerance of the averaged balance, which later turns refine.
const AVERAGED: f64 = 1e-6;
/// Errors allowed per step in a turn that refines: of the eccentricity ratio, and of the temperatures, K.
const PLACE_ERROR: f64 = 1e-9;
const TEMPERATURE_ERROR: f64 = 1e-9;
/// The steady state is known when the last turn moved its temperatures by less than this, K, and its eccentricity
/// ratio by less than this.
const CLOSE: f64 = 1e-6;
const CLOSE_PLACE: f64 = 1e-7;
/// Turns that refine, at most.
const TURNS: usize = 60;
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
        let from = Departure {
            before: self.state.eccentricity,
            eccentricity: self.state.eccentricity,
            temperatures: self.state.temperatures,
        };
        let found =
            multirate::equilibrium(self, AVERAGED, &from).map_err(|why| self.refuse(why))?;
        let turns = self.refine(&found)?;
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
        if self.film.is_transient() {
            return Err(refusal(
                "it is not available for this film: set bearing.film = Mobility",
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

    fn refuse(&self, why: NoEquilibrium) -> Fault {
        match why {
            NoEquilibrium::Runaway { .. } => refusal(format_args!(
                "{why}: friction heats more than thermal.oilAmbientConductance and the other conductances let out"
            )),
            NoEquilibrium::Unstable { .. } => refusal(format_args!(
                "{why}: set thermal.initialBearingTemperature away from it"
            )),
            other => refusal(other),
        }
    }

    /// Newton's method on resolved turns. Returns their number.
    fn refine(&mut self, found: &Equilibrium) -> Result<usize, Fault> {
        self.state.eccentricity = found.eccentricity;
        self.state.temperatures = found.temperatures;
        let near = unknowns(&self.state);
        let period = self.period();
        let slow = SVector::<f64, 4>::from_row_slice(&near[2..]);
        let stay = nalgebra::Matrix4::identity() - (found.drift * period).exp();
        let settle = stay.lu();
        let mut step = period / 100.0;
        for turn in 1..=TURNS {
            let start = unknowns(&self.state);
            let end = self
                .steady_turn(&start, &mut step)
                .map_err(|failure| refusal(self.explain(failure, &start, 0..6)))?;
            let miss = SVector::<f64, 6>::from(end) - SVector::from(start);
            let warmer = if self.thermal.isothermal {
                SVector::zeros()
            } else {
                settle
                    .solve(&miss.fixed_rows::<4>(2).into_owned())
                    .ok_or_else(|| refusal("the heat balance is singular"))?
            };
            let place: Vector2<f64> = miss.fixed_rows::<2>(0).into();
            let shift = found.shift * warmer[0];
            let e = Vector2::from(self.state.eccentricity) + place + shift;
            let t = SVector::<f64, 4>::from_row_slice(&start[2..]) + warmer;
            if !((t - slow).amax() < FARTHEST && e.norm() < 1.0) {
                break;
            }
            self.state.eccentricity = e.into();
            self.state.temperatures = temperatures(&[e.x, e.y, t[0], t[1], t[2], t[3]]);
            if warmer.amax() < CLOSE && place.norm() < CLOSE_PLACE {
                return Ok(turn);
            }
        }
        Err(refusal(
            "no periodic orbit of journal and temperatures was found",
        ))
    }

    /// The unknowns a turn later.
    fn steady_turn(&self, start: &Unknowns, step: &mut f64) -> Result<Unknowns, Failure> {
        const T: f64 = TEMPERATURE_ERROR;
        let integrator = DormandPrince {
            allowed: [PLACE_ERROR, PLACE_ERROR, T, T, T, T],
            budget: Budget::of(STEPS),
        };
        let mut y = *start;
        let mut oil = self.nearby;
        let rates = |tau: f64, y: &Unknowns| self.rates_at(tau, y, &mut oil);
        integrator.integrate(rates, &mut y, self.period(), step)?;
        Ok(y)
    }
}

fn refusal(why: impl Display) -> Fault {
    Fault::Invalid(format!("thermal.initialization = SteadyState: {why}"))
}
