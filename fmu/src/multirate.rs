//! Leaping over whole turns: the journal's orbit repeats itself in 0.2 s while the temperatures drift
//! over minutes, so a long communication step need not resolve every turn.
//!
//! At a given film viscosity and clearance the journal runs on a periodic orbit. Its heat, averaged over the turn, is a
//! smooth function of these two alone, as long as speed and load repeat themselves. So a few orbits
//! span a curve, or a family of curves where the clearance changes, and temperatures and wear follow the averaged heat with a stiff solver and error control
//! (the averaging principle: Sanders, Verhulst & Murdock 2007, Averaging Methods in Nonlinear
//! Dynamical Systems, ch. 2). The turn at the end is for the caller to resolve. Where speed and load repeat themselves only after
//! several turns of the shaft, a turn here is all of these.
//!
//! Three errors are controlled, each as a multiple of the solver's tolerance: a turn's own (its place and its
//! mean heat, by the embedded method), what a turn misses its beginning by (what is left of it is extrapolated
//! with the slope that earlier turns have shown), and the curve's between the orbits (by the last term of its
//! polynomial). Where one of them is too large, there are more steps, more turns or more orbits.

mod correction;
mod curve;
mod curves;
mod differences;
mod equilibrium;
pub mod orbit;
mod stiff;

use crate::{
    bearing::Flows,
    solver::{Budget, Failure, Rodas3},
    thermal::Temperatures,
};
pub use correction::{CLOSEST, Correction};
pub use curves::Across;
use curves::Curves;
pub use equilibrium::{Equilibrium, NoEquilibrium, equilibrium, slowest_time_constant};
use fmu_export::model::Fault;
use nalgebra::{SMatrix, SVector, Vector2};
use orbit::Orbit;
use std::cell::RefCell;
use thiserror::Error;

/// Why a leap was not made; the caller resolves the turns instead.
#[derive(Debug, Error)]
pub enum NoLeap {
    /// The journal finds no periodic orbit at a viscosity.
    #[error("no periodic orbit at a film viscosity of {0:?} Pa.s")]
    NoOrbit(f64),
    /// The journal needs so many turns to its orbit.
    #[error("the journal comes to its orbit too slowly")]
    Far(f64),
    /// The clearance closes at these temperatures.
    #[error("the clearance closes with the bush at {:.1} K and the shaft at {:.1} K", .0.bush, .0.shaft)]
    Closed(Temperatures),
    /// An integration failed.
    #[error(transparent)]
    Integration(#[from] Failure),
    /// A turn of a film that takes steps of its own could not be resolved.
    #[error(transparent)]
    Turn(#[from] Fault),
    /// Such a film's turns do not tell its heat.
    #[error("{0}")]
    Untold(String),
}

/// A model on two time scales, as a leap needs it: the journal within a turn, and the heat balance over many turns.
pub trait TwoScales {
    /// Duration of a turn, s.
    fn period(&self) -> f64;
    /// The shaft's turns in it.
    fn turns(&self) -> usize {
        1
    }
    /// The journal at a clearance, m: the rate of the eccentricity-ratio vector, 1/s, and the flows, `tau` seconds into a turn, at
    /// an eccentricity-ratio vector and a film viscosity, Pa.s.
    fn journal(&self, clearance: f64) -> impl Fn(f64, [f64; 2], f64) -> ([f64; 2], Flows);
    /// Film viscosity, Pa.s, at a film temperature, K.
    fn viscosity(&self, film_temperature: f64) -> f64;
    /// Clearance, m, at these temperatures and a mean wear depth, m; positive also where it closes.
    fn clearance(&self, temperatures: &Temperatures, worn: f64) -> f64;
    /// Whether the clearance closes there.
    fn is_closed(&self, temperatures: &Temperatures, worn: f64) -> bool;
    /// Rates of the temperatures, K/s, at a clearance, m, under given flows.
    fn thermal_rates(&self, temperatures: &Temperatures, clearance: f64, flows: &Flows) -> Temperatures;
    /// Whether the surfaces wear.
    fn wears(&self) -> bool;
    /// Rate of the wear depth, m/s, under given flows.
    fn wear_rate(&self, flows: &Flows) -> f64;
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
    /// The wear depth, m.
    pub worn: f64,
}

impl Departure {
    /// A place that no turn has led to.
    pub fn at(eccentricity: [f64; 2], temperatures: Temperatures, worn: f64) -> Self {
        Self { before: eccentricity, eccentricity, temperatures, worn }
    }
}

/// Leaps over `turns` whole turns, to where the next leap could begin; `pass` sees temperatures and wear depth at the beginning of
/// each step.
pub fn leap(
    model: &impl TwoScales,
    tolerance: f64,
    turns: usize,
    from: Departure,
    mut pass: impl FnMut(Temperatures, f64),
) -> Result<Departure, NoLeap> {
    let mean = Averaged::new(model, None, tolerance, Across::Cubics, &from)?;
    if let Some(approach) = mean.curves.borrow().far(&from, turns)? {
        return Err(NoLeap::Far(approach));
    }
    let span = turns as f64 * model.period();
    let (t, worn) = if model.wears() {
        mean.follow_wear(tolerance, span, &from, pass)?
    } else {
        (mean.follow(tolerance, span, &from, |t| pass(temperatures(t), from.worn))?, from.worn)
    };
    let eccentricity = mean.place(&t, worn)?.into();
    Ok(Departure::at(eccentricity, temperatures(&t), worn))
}

/// The temperatures at each step of a leap over `turns` whole turns, the first and the last among them. There is no wear; the
/// flows are this film's, corrected to those of another one.
///
/// # Errors
/// When there is no orbit at a temperature, the clearance closes, or an integration fails.
pub fn way(
    model: &impl TwoScales,
    correction: &Correction,
    tolerance: f64,
    turns: usize,
    from: &Departure,
) -> Result<Vec<Temperatures>, NoLeap> {
    let mean = Averaged::new(model, Some(correction), tolerance, Across::Cubics, from)?;
    let mut way = Vec::new();
    let span = turns as f64 * model.period();
    let end = mean.follow(tolerance, span, from, |t| way.push(temperatures(t)))?;
    way.push(temperatures(&end));
    Ok(way)
}

/// The flows averaged over a turn at the temperatures of the departure.
///
/// # Errors
/// When there is no orbit there.
pub fn flows(model: &impl TwoScales, tolerance: f64, at: &Departure) -> Result<Flows, NoLeap> {
    let (_, orbit) = Curves::new(model, tolerance, Across::Cubics, at)?;
    Ok(orbit.flows())
}

/// Derivatives of the rates of the temperatures, 1/s, under the heat averaged over a turn.
///
/// # Errors
/// When there is no orbit at a temperature.
pub fn drift(model: &impl TwoScales, tolerance: f64, from: &Departure) -> Result<Matrix4, NoLeap> {
    let mean = Averaged::new(model, None, tolerance, Across::Cubics, from)?;
    mean.linear(&vector(&from.temperatures)).map(|(_, drift)| drift)
}

/// The same under flows that do not follow the temperatures.
pub fn network(model: &impl TwoScales, at: &Departure, flows: &Flows) -> Matrix4 {
    let t = vector(&at.temperatures);
    let rates = |t: &Vector4| {
        let t = temperatures(t);
        vector(&model.thermal_rates(&t, model.clearance(&t, at.worn), flows))
    };
    let here = rates(&t);
    let mut jacobian = Matrix4::zeros();
    for column in 0..4 {
        let mut nudged = t;
        nudged[column] += NUDGE;
        jacobian.set_column(column, &((rates(&nudged) - here) / NUDGE));
    }
    jacobian
}

/// The temperatures' drift under the heat averaged over a turn.
struct Averaged<'a, M> {
    model: &'a M,
    /// Corrects the model's flows.
    correction: Option<&'a Correction>,
    /// The orbits are found while rates are asked for.
    curves: RefCell<Curves<'a, M>>,
    /// The change of a temperature from which derivatives are taken, K.
    nudge: f64,
    /// The wear depth at the departure, m.
    worn: f64,
}

impl<'a, M: TwoScales> Averaged<'a, M> {
    fn new(
        model: &'a M,
        correction: Option<&'a Correction>,
        tolerance: f64,
        across: Across,
        from: &Departure,
    ) -> Result<Self, NoLeap> {
        let (curves, first) = Curves::new(model, tolerance, across, from)?;
        let mut mean = Self { model, correction, curves: RefCell::new(curves), nudge: NUDGE, worn: from.worn };
        let drift = mean.rates_under(&vector(&from.temperatures), from.worn, &first.flows());
        // Differences step along the drift: the orbits there are needed anyway.
        mean.nudge = NUDGE.copysign(drift[0]);
        Ok(mean)
    }

    fn clearance(&self, t: &Vector4, worn: f64) -> f64 {
        self.model.clearance(&temperatures(t), worn)
    }

    /// The flows averaged over a turn.
    fn flows(&self, t: &Vector4, worn: f64) -> Result<Flows, NoLeap> {
        Ok(self.orbit(t, worn)?.flows())
    }

    /// The orbit at these temperatures and this wear depth.
    fn orbit(&self, t: &Vector4, worn: f64) -> Result<Orbit, NoLeap> {
        let clearance = self.clearance(t, worn);
        let viscosity = self.model.viscosity(t[0]);
        self.curves.borrow_mut().at(viscosity, clearance)
    }

    /// Where that orbit begins.
    fn place(&self, t: &Vector4, worn: f64) -> Result<Vector2<f64>, NoLeap> {
        let clearance = self.clearance(t, worn);
        let viscosity = self.model.viscosity(t[0]);
        self.curves.borrow_mut().place(viscosity, clearance)
    }

    fn rates_under(&self, t: &Vector4, worn: f64, flows: &Flows) -> Vector4 {
        let clearance = self.clearance(t, worn);
        let corrected = self.correction.map(|correction| {
            let viscosity = self.model.viscosity(t[0]);
            correction.apply(viscosity, flows)
        });
        let flows = corrected.as_ref().unwrap_or(flows);
        let rates = self.model.thermal_rates(&temperatures(t), clearance, flows);
        vector(&rates)
    }

    /// The temperatures' rates, K/s.
    fn rates(&self, t: &Vector4) -> Result<Vector4, NoLeap> {
        Ok(self.rates_under(t, self.worn, &self.flows(t, self.worn)?))
    }

    /// The rates, and their derivatives over the temperatures, 1/s. The flows depend on the first one, the film's, and on
    /// those that change the clearance.
    fn linear(&self, t: &Vector4) -> Result<(Vector4, Matrix4), NoLeap> {
        self.check(t, self.worn)?;
        let here = self.flows(t, self.worn)?;
        let clearance = self.clearance(t, self.worn);
        let at_here = self.rates_under(t, self.worn, &here);
        let mut jacobian = Matrix4::zeros();
        for column in 0..4 {
            let mut nudged = *t;
            nudged[column] += self.nudge;
            let changed = if self.follows(column, &nudged, clearance) { self.flows(&nudged, self.worn)? } else { here };
            let change = self.rates_under(&nudged, self.worn, &changed) - at_here;
            jacobian.set_column(column, &(change / self.nudge));
        }
        Ok((at_here, jacobian))
    }

    /// Whether the orbit follows this temperature: the film's, or one that has changed the clearance, m.
    fn follows(&self, column: usize, nudged: &Vector4, clearance: f64) -> bool {
        column == 0 || self.clearance(nudged, self.worn) != clearance
    }

    /// Ends the way where the clearance closes.
    fn check(&self, t: &Vector4, worn: f64) -> Result<(), NoLeap> {
        let t = temperatures(t);
        if self.model.is_closed(&t, worn) {
            return Err(NoLeap::Closed(t));
        }
        Ok(())
    }

    /// The temperatures `span` seconds later; `pass` sees those at the beginning of each step.
    fn follow(
        &self,
        tolerance: f64,
        span: f64,
        from: &Departure,
        mut pass: impl FnMut(&Vector4),
    ) -> Result<Vector4, NoLeap> {
        let mut t = vector(&from.temperatures);
        let integrator = Rodas3 { allowed: [DRIFT_ERROR * tolerance; 4], budget: Budget::of(100_000) };
        integrator.integrate(
            |t| self.rates(t),
            |t| {
                pass(t);
                self.linear(t)
            },
            &mut t,
            span,
            self.model.period(),
        )?;
        Ok(t)
    }

    /// The temperatures and the wear depth `span` seconds later; `pass` sees them at the beginning of each step.
    fn follow_wear(
        &self,
        tolerance: f64,
        span: f64,
        from: &Departure,
        mut pass: impl FnMut(Temperatures, f64),
    ) -> Result<(Vector4, f64), NoLeap> {
        let mut y = vector(&from.temperatures).push(from.worn);
        let [kelvin, metre] = [DRIFT_ERROR, WEAR_ERROR].map(|error| error * tolerance);
        let integrator = Rodas3 { allowed: [kelvin, kelvin, kelvin, kelvin, metre], budget: Budget::of(100_000) };
        let linear = |y: &Vector5| {
            pass(temperatures(&y.fixed_rows::<4>(0).into()), y[4]);
            self.wearing_linear(y)
        };
        integrator.integrate(|y| self.wearing(y), linear, &mut y, span, self.model.period())?;
        Ok((y.fixed_rows::<4>(0).into(), y[4]))
    }

    /// The rates of temperatures and wear depth.
    fn wearing(&self, y: &Vector5) -> Result<Vector5, NoLeap> {
        let (t, worn) = (y.fixed_rows::<4>(0).into(), y[4]);
        let flows = self.flows(&t, worn)?;
        let rates = self.rates_under(&t, worn, &flows);
        Ok(rates.push(self.model.wear_rate(&flows)))
    }

    /// The same with their derivatives.
    fn wearing_linear(&self, y: &Vector5) -> Result<(Vector5, SMatrix<f64, 5, 5>), NoLeap> {
        self.check(&y.fixed_rows::<4>(0).into(), y[4])?;
        let here = self.wearing(y)?;
        let mut jacobian = SMatrix::<f64, 5, 5>::zeros();
        for column in 0..5 {
            let nudge = if column < 4 { self.nudge } else { WEAR_NUDGE };
            let mut nudged = *y;
            nudged[column] += nudge;
            jacobian.set_column(column, &((self.wearing(&nudged)? - here) / nudge));
        }
        Ok((here, jacobian))
    }
}

/// How far from the middle a turn between these places may begin instead. Where rough surfaces cross, it is beyond 1.
pub fn reach(start: Vector2<f64>, end: Vector2<f64>) -> f64 {
    let farthest = start.norm().max(end.norm());
    if farthest < 1.0 { 1.0 } else { farthest + 0.1 }
}

/// The change of a temperature from which derivatives are taken, K.
const NUDGE: f64 = 1e-3;
/// The error allowed in each temperature per step, K, at a relative tolerance of one.
const DRIFT_ERROR: f64 = 6000.0;
/// The same of the wear depth, m, and the change of it from which derivatives are taken.
const WEAR_ERROR: f64 = 1e-3;
const WEAR_NUDGE: f64 = 1e-10;

/// The temperatures of film, bush, shaft and oil, K, or their rates, K/s.
pub type Vector4 = SVector<f64, 4>;
/// The same and the wear depth, m, or its rate, m/s.
type Vector5 = SVector<f64, 5>;
/// Derivatives of the temperatures' rates, 1/s.
pub type Matrix4 = SMatrix<f64, 4, 4>;

/// Temperatures as a vector.
pub fn vector(t: &Temperatures) -> Vector4 {
    t.array().into()
}

/// A vector as temperatures.
pub fn temperatures(t: &Vector4) -> Temperatures {
    Temperatures::of((*t).into())
}
