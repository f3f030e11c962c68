//! Leaping over whole turns: the journal's orbit repeats itself in 0.2 s while the temperatures drift
//! over minutes, so a long communication step need not resolve every turn.
//!
//! At a given film viscosity the journal runs on a periodic orbit. Its heat, averaged over the turn, is a
//! smooth function of the viscosity alone, as long as speed and load repeat themselves. So a few orbits
//! span a curve, and the temperatures follow the averaged heat with a stiff solver and error control
//! (the averaging principle: Sanders, Verhulst & Murdock 2007, Averaging Methods in Nonlinear
//! Dynamical Systems, ch. 2). The turn at the end is for the caller to resolve.

use crate::bearing::Flows;
use crate::solver::{DormandPrince, Failure, Rodas3};
use crate::thermal::Temperatures;
use nalgebra::{Matrix2, SMatrix, SVector, Vector2};
use std::cell::RefCell;
use std::collections::BTreeMap;
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

/// What a leap needs to know: the journal within a turn, and the temperatures' balance.
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

/// Where a leap ends.
#[derive(Clone, Copy, Debug)]
pub struct Landing {
    /// Eccentricity-ratio vector, 1.
    pub eccentricity: [f64; 2],
    /// The temperatures, K.
    pub temperatures: Temperatures,
}

/// Leaps over `turns` whole turns from a point at which the journal is near its orbit.
pub fn leap(
    model: &impl TwoScales,
    tolerance: f64,
    turns: usize,
    from: Landing,
) -> Result<Landing, NoLeap> {
    let curve = RefCell::new(Curve::new(model, tolerance, &from));
    let flows = |t: &Vector4| {
        curve
            .borrow_mut()
            .at(model.viscosity(t[0]))
            .map(|o| o.flows())
    };
    let rates = |t: &Vector4| -> Result<Vector4, NoLeap> {
        Ok(vector(&model.thermal_rates(&temperatures(t), &flows(t)?)))
    };
    let integrator = Rodas3 {
        allowed: [100.0 * tolerance; 4],
        limit: 100_000,
    };
    let mut t = vector(&from.temperatures);
    let span = turns as f64 * model.period();
    integrator.integrate(rates, |t| jacobian(rates, t), &mut t, span, model.period())?;
    let orbit = curve.borrow_mut().at(model.viscosity(t[0]))?;
    Ok(Landing {
        eccentricity: orbit.start(),
        temperatures: temperatures(&t),
    })
}

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

/// Derivatives of the rates over the temperatures by one-sided differences.
fn jacobian(
    rates: impl Fn(&Vector4) -> Result<Vector4, NoLeap>,
    at: &Vector4,
) -> Result<SMatrix<f64, 4, 4>, NoLeap> {
    const CHANGE: f64 = 1e-3;
    let here = rates(at)?;
    let mut matrix = SMatrix::<f64, 4, 4>::zeros();
    for column in 0..4 {
        let mut beside = *at;
        beside[column] += CHANGE;
        matrix.set_column(column, &((rates(&beside)? - here) / CHANGE));
    }
    Ok(matrix)
}

/// A periodic orbit: where it begins, and the logarithms of its flows averaged over the turn. The flows
/// go nearly as powers of the viscosity, so their logarithms are nearly straight over its logarithm.
#[derive(Clone, Copy, Debug, Default)]
struct Orbit([f64; 5]);

/// Boundary heat is stored on top of this part of the viscous heat: a logarithm wants no zero.
const PEDESTAL: f64 = 1e-3;
/// The least viscous heat, W, and side flow, m³/s, for the same reason.
const LEAST: f64 = 1e-18;

impl Orbit {
    fn new(start: Vector2<f64>, flows: &Flows) -> Self {
        let viscous = flows.viscous.max(LEAST);
        let boundary = flows.boundary.max(0.0) + PEDESTAL * viscous;
        let side_flow = flows.side_flow.max(LEAST);
        Self([
            start.x,
            start.y,
            viscous.ln(),
            boundary.ln(),
            side_flow.ln(),
        ])
    }

    fn start(&self) -> [f64; 2] {
        [self.0[0], self.0[1]]
    }

    fn flows(&self) -> Flows {
        let viscous = self.0[2].exp();
        Flows {
            viscous,
            boundary: self.0[3].exp() - PEDESTAL * viscous,
            side_flow: self.0[4].exp(),
        }
    }
}

/// Orbits over the logarithm of the viscosity, found where they are needed and interpolated by cubics.
struct Curve<'a, M> {
    model: &'a M,
    tolerance: f64,
    origin: f64,
    guess: [f64; 2],
    nodes: BTreeMap<i32, Orbit>,
    /// Approximate derivative of a turn's end over its beginning, minus one.
    slope: Matrix2<f64>,
}

/// Spacing of the orbits in the logarithm of the viscosity.
const SPACING: f64 = 0.3;

impl<'a, M: TwoScales> Curve<'a, M> {
    fn new(model: &'a M, tolerance: f64, from: &Landing) -> Self {
        Self {
            model,
            tolerance,
            // The start lies between the two middle nodes of four.
            origin: model.viscosity(from.temperatures.film).ln() - 0.5 * SPACING,
            guess: from.eccentricity,
            nodes: BTreeMap::new(),
            slope: -Matrix2::identity(),
        }
    }

    fn at(&mut self, viscosity: f64) -> Result<Orbit, NoLeap> {
        let position = (viscosity.ln() - self.origin) / SPACING;
        if !position.is_finite() || position.abs() > 1e3 {
            return Err(NoLeap::NoOrbit(viscosity));
        }
        let cell = position.floor();
        let (s, k) = (position - cell, cell as i32);
        let weights = [
            -s * (s - 1.0) * (s - 2.0) / 6.0,
            (s + 1.0) * (s - 1.0) * (s - 2.0) / 2.0,
            -(s + 1.0) * s * (s - 2.0) / 2.0,
            (s + 1.0) * s * (s - 1.0) / 6.0,
        ];
        let mut blend = [0.0; 5];
        for (weight, offset) in weights.into_iter().zip(-1..) {
            let node = self.node(k + offset)?;
            for (sum, value) in blend.iter_mut().zip(node.0) {
                *sum += weight * value;
            }
        }
        Ok(Orbit(blend))
    }

    fn node(&mut self, k: i32) -> Result<Orbit, NoLeap> {
        if let Some(orbit) = self.nodes.get(&k) {
            return Ok(*orbit);
        }
        let viscosity = (self.origin + f64::from(k) * SPACING).exp();
        let orbit = self.search(viscosity, self.guess(k))?;
        self.nodes.insert(k, orbit);
        Ok(orbit)
    }

    /// Where the orbit of node `k` may begin: on the line through the two nearest nodes.
    fn guess(&self, k: i32) -> [f64; 2] {
        let mut known: Vec<_> = self.nodes.iter().collect();
        known.sort_by_key(|(j, _)| j.abs_diff(k));
        match known[..] {
            [] => self.guess,
            [(_, orbit)] => orbit.start(),
            [(&a, near), (&b, far), ..] => {
                let t = f64::from(k - a) / f64::from(b - a);
                let on_line = |i: usize| near.0[i] + t * (far.0[i] - near.0[i]);
                let guess = [on_line(0), on_line(1)];
                if guess[0].hypot(guess[1]) < 1.0 {
                    guess
                } else {
                    near.start()
                }
            }
        }
    }

    /// Finds the beginning that a turn returns to, by Broyden's method (Broyden 1965, Math. Comp. 19).
    fn search(&mut self, viscosity: f64, guess: [f64; 2]) -> Result<Orbit, NoLeap> {
        const TURNS: usize = 60;
        let close = (1e3 * self.tolerance).clamp(1e-9, 1e-3);
        let mut start = Vector2::from(guess);
        let (mut end, mut flows) = self.turn(viscosity, start)?;
        for _ in 0..TURNS {
            let miss = end - start;
            if miss.amax() < close {
                return Ok(Orbit::new(end, &flows));
            }
            let newton = self
                .slope
                .lu()
                .solve(&-miss)
                .filter(|step| (start + step).norm() < 1.0);
            let step = newton.unwrap_or(miss);
            start += step;
            (end, flows) = self.turn(viscosity, start)?;
            let change = (end - start) - miss;
            self.slope += (change - self.slope * step) * step.transpose() / step.norm_squared();
        }
        Err(NoLeap::NoOrbit(viscosity))
    }

    /// One turn at a fixed viscosity: where it ends, and its mean flows.
    fn turn(&self, viscosity: f64, start: Vector2<f64>) -> Result<(Vector2<f64>, Flows), Failure> {
        let period = self.model.period();
        let rates = |tau: f64, y: &[f64; 5]| {
            let (velocity, flows) = self.model.journal(tau, [y[0], y[1]], viscosity);
            [
                velocity[0],
                velocity[1],
                flows.viscous,
                flows.boundary,
                flows.side_flow,
            ]
        };
        // The integrated flows go along without a say in the step: they follow the journal.
        let integrator = DormandPrince {
            allowed: [
                self.tolerance,
                self.tolerance,
                f64::INFINITY,
                f64::INFINITY,
                f64::INFINITY,
            ],
            limit: 1_000_000,
        };
        let mut y = [start.x, start.y, 0.0, 0.0, 0.0];
        let mut step = period / 50.0;
        integrator.integrate(rates, &mut y, period, &mut step)?;
        let flows = Flows {
            viscous: y[2] / period,
            boundary: y[3] / period,
            side_flow: y[4] / period,
        };
        Ok((Vector2::new(y[0], y[1]), flows))
    }
}
