//! Leaping over whole turns: the journal's orbit repeats itself in 0.2 s while the temperatures drift
//! over minutes, so a long communication step need not resolve every turn.
//!
//! At a given film viscosity the journal runs on a periodic orbit. Its heat, averaged over the turn, is a
//! smooth function of the viscosity alone, as long as speed and load repeat themselves. So a few orbits
//! span a curve, and the temperatures follow the averaged heat with a stiff solver and error control
//! (the averaging principle: Sanders, Verhulst & Murdock 2007, Averaging Methods in Nonlinear
//! Dynamical Systems, ch. 2). The turn at the end is for the caller to resolve.
//!
//! Three errors are controlled, each as a multiple of the solver's tolerance: a turn's own (its place and its
//! mean heat, by the embedded method), what a turn misses its beginning by (what is left of it is extrapolated
//! with the slope that earlier turns have shown), and the curve's between the orbits (by the last term of its
//! polynomial). Where one of them is too large, there are more steps, more turns or more orbits.

mod curve;
mod equilibrium;
mod orbit;

use crate::bearing::Flows;
use crate::solver::{Budget, Failure, Rodas3};
use crate::thermal::Temperatures;
use curve::Curve;
pub use equilibrium::{Equilibrium, NoEquilibrium, equilibrium, slowest_time_constant};
use nalgebra::{SMatrix, SVector, Vector2};
use orbit::Orbit;
use std::cell::RefCell;
use thiserror::Error;

/// Why a leap was not made; the caller resolves the turns instead.
#[derive(Clone, Debug, Error)]
pub enum NoLeap {
    /// The journal finds no periodic orbit at a viscosity.
    #[error("no periodic orbit at a film viscosity of {0} Pa.s")]
    NoOrbit(f64),
    /// An integration failed.
    #[error(transparent)]
    Integration(#[from] Failure),
}

/// A model on two time scales, as a leap needs it: the journal within a turn, and the heat balance over many turns.
pub trait TwoScales {
    /// Duration of a turn, s.
    fn period(&self) -> f64;
    /// Rate of the eccentricity-ratio vector, 1/s, and the flows, `tau` seconds into a turn.
    fn journal(&self, tau: f64, eccentricity: [f64; 2], viscosity: f64) -> ([f64; 2], Flows);
    /// Film viscosity, Pa.s, at a film temperature, K.
    fn viscosity(&self, film_temperature: f64) -> f64;
    /// Rates of the temperatures, K/s, under given flows.
    fn thermal_rates(&self, temperatures: &Temperatures, flows: &Flows) -> Temperatures;
}

/// Where a leap begins: after a turn that was resolved.
#[derive(Clone, Copy, Debug)]
pub struct Departure {
    /// Eccentricity-ratio vector at the beginning of that turn, 1.
    pub before: [f64; 2],
    /// Eccentricity-ratio vector at its end, 1.
    pub eccentricity: [f64; 2],
    /// The temperatures at its end, K.
    pub temperatures: Temperatures,
}

/// Where a leap ends.
#[derive(Clone, Copy, Debug)]
pub struct Landing {
    /// Eccentricity-ratio vector, 1.
    pub eccentricity: [f64; 2],
    /// The temperatures, K.
    pub temperatures: Temperatures,
}

/// Leaps over `turns` whole turns.
pub fn leap(
    model: &impl TwoScales,
    tolerance: f64,
    turns: usize,
    from: Departure,
) -> Result<Landing, NoLeap> {
    let mut t = vector(&from.temperatures);
    let mean = Averaged::new(model, tolerance, &from)?;
    let integrator = Rodas3 {
        allowed: [DRIFT_ERROR * tolerance; 4],
        budget: Budget::of(100_000),
    };
    let span = turns as f64 * model.period();
    integrator.integrate(
        |t| mean.rates(t),
        |t| mean.linear(t),
        &mut t,
        span,
        model.period(),
    )?;
    Ok(Landing {
        eccentricity: mean.place(t[0])?.into(),
        temperatures: temperatures(&t),
    })
}

/// Derivatives of the rates of the temperatures, 1/s, under the heat averaged over a turn.
///
/// # Errors
/// When there is no orbit at a temperature.
pub fn drift(model: &impl TwoScales, tolerance: f64, from: &Departure) -> Result<Matrix4, NoLeap> {
    let mean = Averaged::new(model, tolerance, from)?;
    mean.linear(&vector(&from.temperatures))
        .map(|(_, drift)| drift)
}

/// The same under flows that do not follow the temperatures.
pub fn network(model: &impl TwoScales, temperatures_now: &Temperatures, flows: &Flows) -> Matrix4 {
    let t = vector(temperatures_now);
    let rates = |t: &Vector4| vector(&model.thermal_rates(&temperatures(t), flows));
    let here = rates(&t);
    let mut jacobian = Matrix4::zeros();
    for column in 0..4 {
        let mut beside = t;
        beside[column] += NUDGE;
        jacobian.set_column(column, &((rates(&beside) - here) / NUDGE));
    }
    jacobian
}

/// The temperatures' drift under the heat averaged over a turn.
struct Averaged<'a, M> {
    model: &'a M,
    /// The orbits are found while rates are asked for.
    curve: RefCell<Curve<'a, M>>,
    /// The change of a temperature from which derivatives are taken, K.
    nudge: f64,
}

impl<'a, M: TwoScales> Averaged<'a, M> {
    fn new(model: &'a M, tolerance: f64, from: &Departure) -> Result<Self, NoLeap> {
        let (curve, first) = Curve::new(model, tolerance, from)?;
        let drift = model.thermal_rates(&from.temperatures, &first.flows());
        Ok(Self {
            model,
            curve: RefCell::new(curve),
            // Beside a point means ahead of it, where the orbits are needed anyway.
            nudge: NUDGE.copysign(drift.film),
        })
    }

    /// The flows averaged over a turn at a film temperature.
    fn flows(&self, film: f64) -> Result<Flows, NoLeap> {
        Ok(self.orbit(film)?.flows())
    }

    /// The orbit at a film temperature.
    fn orbit(&self, film: f64) -> Result<Orbit, NoLeap> {
        self.curve.borrow_mut().at(self.model.viscosity(film))
    }

    /// Where the orbit at a film temperature begins.
    fn place(&self, film: f64) -> Result<Vector2<f64>, NoLeap> {
        self.curve.borrow_mut().place(self.model.viscosity(film))
    }

    fn rates_under(&self, t: &Vector4, flows: &Flows) -> Vector4 {
        vector(&self.model.thermal_rates(&temperatures(t), flows))
    }

    /// The temperatures' rates, K/s.
    fn rates(&self, t: &Vector4) -> Result<Vector4, NoLeap> {
        Ok(self.rates_under(t, &self.flows(t[0])?))
    }

    /// The rates, and their derivatives over the temperatures, 1/s. The flows depend on the first one, the film's, alone.
    fn linear(&self, t: &Vector4) -> Result<(Vector4, Matrix4), NoLeap> {
        let here = self.flows(t[0])?;
        let at_here = self.rates_under(t, &here);
        let mut jacobian = Matrix4::zeros();
        for column in 0..4 {
            let mut beside = *t;
            beside[column] += self.nudge;
            let changed = if column == 0 {
                self.flows(beside[0])?
            } else {
                here
            };
            let change = self.rates_under(&beside, &changed) - at_here;
            jacobian.set_column(column, &(change / self.nudge));
        }
        Ok((at_here, jacobian))
    }
}

/// The change of a temperature from which derivatives are taken, K.
const NUDGE: f64 = 1e-3;
/// The error allowed in each temperature per step, K, at a relative tolerance of one.
const DRIFT_ERROR: f64 = 6000.0;

/// The temperatures of film, bush, shaft and oil, K, or their rates, K/s.
pub type Vector4 = SVector<f64, 4>;
/// Derivatives of the temperatures' rates, 1/s.
pub type Matrix4 = SMatrix<f64, 4, 4>;

/// Temperatures as a vector.
pub fn vector(t: &Temperatures) -> Vector4 {
    Vector4::new(t.film, t.bush, t.shaft, t.oil)
}

/// A vector as temperatures.
pub fn temperatures(t: &Vector4) -> Temperatures {
    Temperatures {
        film: t[0],
        bush: t[1],
        shaft: t[2],
        oil: t[3],
    }
}
