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
mod orbit;

use crate::bearing::Flows;
use crate::solver::{Budget, Failure, Rodas3};
use crate::thermal::Temperatures;
use curve::Curve;
use nalgebra::{SMatrix, SVector};
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
    let rates = |t: &Vector4, flows: &Flows| vector(&model.thermal_rates(&temperatures(t), flows));
    let mut t = vector(&from.temperatures);
    let (curve, first) = Curve::new(model, tolerance, &from)?;
    // Beside a point means ahead of it, where the orbits are needed anyway.
    let nudge = NUDGE.copysign(rates(&t, &first.flows())[0]);
    let curve = RefCell::new(curve);
    let flows = |t: &Vector4| {
        let viscosity = model.viscosity(t[0]);
        curve.borrow_mut().at(viscosity).map(|orbit| orbit.flows())
    };
    // The flows depend on the first unknown, the film's temperature, alone.
    let linear = |t: &Vector4| -> Result<_, NoLeap> {
        let here = flows(t)?;
        let at_here = rates(t, &here);
        let mut jacobian = SMatrix::<f64, 4, 4>::zeros();
        for column in 0..4 {
            let mut beside = *t;
            beside[column] += nudge;
            let changed = if column == 0 { flows(&beside)? } else { here };
            jacobian.set_column(column, &((rates(&beside, &changed) - at_here) / nudge));
        }
        Ok((at_here, jacobian))
    };
    let integrator = Rodas3 {
        allowed: [DRIFT_ERROR * tolerance; 4],
        budget: Budget::of(100_000),
    };
    let span = turns as f64 * model.period();
    integrator.integrate(
        |t| Ok(rates(t, &flows(t)?)),
        linear,
        &mut t,
        span,
        model.period(),
    )?;
    let viscosity = model.viscosity(t[0]);
    let mut curve = curve.into_inner();
    Ok(Landing {
        eccentricity: curve.place(viscosity)?.into(),
        temperatures: temperatures(&t),
    })
}

/// The change of a temperature from which derivatives are taken, K.
const NUDGE: f64 = 1e-3;
/// The error allowed in each temperature per step, K, at a relative tolerance of one.
const DRIFT_ERROR: f64 = 6000.0;

type Vector4 = SVector<f64, 4>;

fn vector(t: &Temperatures) -> Vector4 {
    Vector4::new(t.film, t.bush, t.shaft, t.oil)
}

fn temperatures(t: &Vector4) -> Temperatures {
    Temperatures {
        film: t[0],
        bush: t[1],
        shaft: t[2],
        oil: t[3],
    }
}
