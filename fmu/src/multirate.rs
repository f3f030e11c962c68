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
    let rates = |t: &Vector4, flows: &Flows| vector(&model.thermal_rates(&temperatures(t), flows));
    // The flows depend on the first unknown, the film's temperature, alone.
    let jacobian = |t: &Vector4| -> Result<_, NoLeap> {
        let here = flows(t)?;
        let at_here = rates(t, &here);
        let mut matrix = SMatrix::<f64, 4, 4>::zeros();
        for column in 0..4 {
            let mut beside = *t;
            beside[column] += NUDGE;
            let changed = if column == 0 { flows(&beside)? } else { here };
            matrix.set_column(column, &((rates(&beside, &changed) - at_here) / NUDGE));
        }
        Ok(matrix)
    };
    let integrator = Rodas3 {
        allowed: [DRIFT_ERROR * tolerance; 4],
        limit: 100_000,
    };
    let mut t = vector(&from.temperatures);
    let span = turns as f64 * model.period();
    integrator.integrate(
        |t| Ok(rates(t, &flows(t)?)),
        jacobian,
        &mut t,
        span,
        model.period(),
    )?;
    let viscosity = model.viscosity(t[0]);
    let mut curve = curve.into_inner();
    let near = curve.at(viscosity)?.start();
    Ok(Landing {
        eccentricity: curve.search(viscosity, near, Aim::Place)?.start(),
        temperatures: temperatures(&t),
    })
}

/// The change of a temperature from which derivatives are taken, K.
const NUDGE: f64 = 1e-3;
/// The error allowed in each temperature per step, K, at a relative tolerance of one.
const DRIFT_ERROR: f64 = 300.0;

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

    /// Logarithm of the whole heat.
    fn log_heat(&self) -> f64 {
        let flows = self.flows();
        (flows.viscous + flows.boundary).ln()
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
    spacing: f64,
    guess: [f64; 2],
    nodes: BTreeMap<i32, Orbit>,
    /// Approximate derivative of a turn's end over its beginning, minus one.
    slope: Matrix2<f64>,
}

/// Spacing of the orbits in the logarithm of the viscosity, at first; it is halved where they bend.
const SPACING: f64 = 0.35;
/// The most halvings.
const HALVINGS: i32 = 4;
/// The third difference of the heat's logarithm from which on the spacing is halved.
const BEND: f64 = 0.1;

/// What an orbit is wanted for, which says how closely a turn must come back to its beginning.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Aim {
    /// For its heat, which feels the place the less the wider the film.
    Heat,
    /// For the place itself.
    Place,
}

impl Aim {
    /// How far a turn is from coming back.
    fn distance(self, start: Vector2<f64>, end: Vector2<f64>) -> f64 {
        let miss = (end - start).norm();
        match self {
            // The film's shear goes as 1/sqrt(1 - e^2), contact as a power of 1/(1 - e).
            Self::Heat => {
                let e = start.norm().max(end.norm());
                miss * e / (1.0 - e).max(1e-6)
            }
            Self::Place => miss,
        }
    }
}

impl<'a, M: TwoScales> Curve<'a, M> {
    fn new(model: &'a M, tolerance: f64, from: &Landing) -> Self {
        Self {
            model,
            tolerance,
            // The start lies between the two middle nodes of four.
            origin: model.viscosity(from.temperatures.film).ln() - 0.5 * SPACING,
            spacing: SPACING,
            guess: from.eccentricity,
            nodes: BTreeMap::new(),
            slope: -Matrix2::identity(),
        }
    }

    fn at(&mut self, viscosity: f64) -> Result<Orbit, NoLeap> {
        loop {
            let position = (viscosity.ln() - self.origin) / self.spacing;
            if !position.is_finite() || position.abs() > 1e3 {
                return Err(NoLeap::NoOrbit(viscosity));
            }
            let cell = position.floor();
            let (s, k) = (position - cell, cell as i32);
            let nodes = [
                self.node(k - 1)?,
                self.node(k)?,
                self.node(k + 1)?,
                self.node(k + 2)?,
            ];
            let [a, b, c, d] = nodes.map(|node| node.log_heat());
            let bend = (d - a - 3.0 * (c - b)).abs();
            if bend > BEND && self.spacing > SPACING * 0.5f64.powi(HALVINGS) {
                self.halve();
                continue;
            }
            let weights = [
                -s * (s - 1.0) * (s - 2.0) / 6.0,
                (s + 1.0) * (s - 1.0) * (s - 2.0) / 2.0,
                -(s + 1.0) * s * (s - 2.0) / 2.0,
                (s + 1.0) * s * (s - 1.0) / 6.0,
            ];
            let mut blend = [0.0; 5];
            for (weight, node) in weights.into_iter().zip(nodes) {
                for (sum, value) in blend.iter_mut().zip(node.0) {
                    *sum += weight * value;
                }
            }
            return Ok(Orbit(blend));
        }
    }

    /// Halves the spacing; the orbits stay where they are.
    fn halve(&mut self) {
        self.spacing *= 0.5;
        let nodes = std::mem::take(&mut self.nodes);
        self.nodes = nodes.into_iter().map(|(k, orbit)| (2 * k, orbit)).collect();
    }

    fn node(&mut self, k: i32) -> Result<Orbit, NoLeap> {
        if let Some(orbit) = self.nodes.get(&k) {
            return Ok(*orbit);
        }
        let viscosity = (self.origin + f64::from(k) * self.spacing).exp();
        let orbit = self.search(viscosity, self.guess(k), Aim::Heat)?;
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
    fn search(&mut self, viscosity: f64, guess: [f64; 2], aim: Aim) -> Result<Orbit, NoLeap> {
        const TURNS: usize = 60;
        let close = match aim {
            Aim::Heat => (1e3 * self.tolerance).clamp(1e-9, 1e-2),
            Aim::Place => (1e2 * self.tolerance).clamp(1e-9, 1e-3),
        };
        let mut start = Vector2::from(guess);
        let (mut end, mut flows) = self.turn(viscosity, start)?;
        for _ in 0..TURNS {
            let miss = end - start;
            if aim.distance(start, end) < close {
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
