//! Leaping over whole turns: the journal's orbit repeats itself in 0.2 s while the temperatures drift
//! over minutes, so a long communication step need not resolve every turn.
//!
//! At a given film viscosity the journal runs on a periodic orbit. Its heat, averaged over the turn, is a
//! smooth function of the viscosity alone, as long as speed and load repeat themselves. So a few orbits
//! span a curve, and the temperatures follow the averaged heat with a stiff solver and error control
//! (the averaging principle: Sanders, Verhulst & Murdock 2007, Averaging Methods in Nonlinear
//! Dynamical Systems, ch. 2). The turn at the end is for the caller to resolve.

use crate::bearing::Flows;
use crate::solver::{DormandPrince, Failure, Quadrature, Rodas3};
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
        let viscosity = model.viscosity(t[0]);
        curve.borrow_mut().at(viscosity).map(|o| o.flows())
    };
    let rates = |t: &Vector4, flows: &Flows| vector(&model.thermal_rates(&temperatures(t), flows));
    // The flows depend on the first unknown, the film's temperature, alone.
    let linear = |t: &Vector4| -> Result<_, NoLeap> {
        let here = flows(t)?;
        let at_here = rates(t, &here);
        let mut jacobian = SMatrix::<f64, 4, 4>::zeros();
        for column in 0..4 {
            let mut beside = *t;
            beside[column] += NUDGE;
            let changed = if column == 0 { flows(&beside)? } else { here };
            jacobian.set_column(column, &((rates(&beside, &changed) - at_here) / NUDGE));
        }
        Ok((at_here, jacobian))
    };
    let integrator = Rodas3 {
        allowed: [DRIFT_ERROR * tolerance; 4],
        limit: 100_000,
    };
    let mut t = vector(&from.temperatures);
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
    let near = curve.at(viscosity)?.start();
    Ok(Landing {
        eccentricity: curve.search(viscosity, near, Aim::Place)?.start(),
        temperatures: temperatures(&t),
    })
}

/// The change of a temperature from which derivatives are taken, K.
const NUDGE: f64 = 1e-3;
/// The error allowed in each temperature per step, K, at a relative tolerance of one.
const DRIFT_ERROR: f64 = 1000.0;

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

    /// A sum of orbits with weights.
    fn blend<'a>(parts: impl Iterator<Item = (f64, &'a Self)>) -> Self {
        let mut sum = [0.0; 5];
        for (weight, orbit) in parts {
            for (sum, value) in sum.iter_mut().zip(orbit.0) {
                *sum += weight * value;
            }
        }
        Self(sum)
    }
}

/// Orbits over the logarithm of the viscosity, found where they are needed and interpolated by cubics.
struct Curve<'a, M> {
    model: &'a M,
    tolerance: f64,
    origin: f64,
    spacing: f64,
    nodes: BTreeMap<i32, Orbit>,
    /// The cell that was asked for last, and its four nodes.
    cell: Option<(i32, [Orbit; 4])>,
    /// Where the journal is before any orbit is known.
    guess: [f64; 2],
    /// Approximate derivative of a turn's end over its beginning, minus one.
    slope: Matrix2<f64>,
    /// Mean heat of the last turn, W.
    heat: f64,
    /// The step within a turn to try next, s.
    step: f64,
}

/// Spacing of the orbits in the logarithm of the viscosity, at first; it is halved where they bend.
const SPACING: f64 = 0.35;
/// The most halvings.
const HALVINGS: i32 = 4;
/// The third difference of the heat's logarithm from which on the spacing is halved.
const BEND: f64 = 0.1;
/// Error allowed in the place per step within a turn, at a relative tolerance of one.
const PLACE_ERROR: f64 = 100.0;
/// The same of a turn's mean heat, as a part of it.
const HEAT_ERROR: f64 = 100.0;

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
        let viscosity = model.viscosity(from.temperatures.film);
        let (_, flows) = model.journal(0.0, from.eccentricity, viscosity);
        Self {
            model,
            tolerance,
            // The start lies between the two middle nodes of four.
            origin: viscosity.ln() - 0.5 * SPACING,
            spacing: SPACING,
            nodes: BTreeMap::new(),
            cell: None,
            guess: from.eccentricity,
            slope: -Matrix2::identity(),
            heat: flows.viscous + flows.boundary,
            step: model.period() / 50.0,
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
            let Some(nodes) = self.cell(k)? else { continue };
            let weights = [
                -s * (s - 1.0) * (s - 2.0) / 6.0,
                (s + 1.0) * (s - 1.0) * (s - 2.0) / 2.0,
                -(s + 1.0) * s * (s - 2.0) / 2.0,
                (s + 1.0) * s * (s - 1.0) / 6.0,
            ];
            return Ok(Orbit::blend(weights.into_iter().zip(&nodes)));
        }
    }

    /// The nodes about the cell from node `k` to the next; none when they bend so much that the spacing
    /// was halved.
    fn cell(&mut self, k: i32) -> Result<Option<[Orbit; 4]>, NoLeap> {
        if let Some((_, nodes)) = self.cell.filter(|(known, _)| *known == k) {
            return Ok(Some(nodes));
        }
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
            return Ok(None);
        }
        self.cell = Some((k, nodes));
        Ok(Some(nodes))
    }

    /// Halves the spacing; the orbits stay where they are.
    fn halve(&mut self) {
        self.spacing *= 0.5;
        self.cell = None;
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

    /// Where the orbit of node `k` may begin: on the parabola through the three nearest nodes.
    fn guess(&self, k: i32) -> [f64; 2] {
        let mut known: Vec<_> = self.nodes.iter().collect();
        known.sort_by_key(|(j, _)| j.abs_diff(k));
        known.truncate(3);
        let Some((_, nearest)) = known.first() else {
            return self.guess;
        };
        let weight = |j: i32| -> f64 {
            let others = known.iter().filter(|(i, _)| **i != j);
            let part = |(i, _): &(&i32, _)| f64::from(k - **i) / f64::from(j - **i);
            others.map(part).product()
        };
        let guess = Orbit::blend(known.iter().map(|(j, orbit)| (weight(**j), *orbit))).start();
        if guess[0].hypot(guess[1]) < 1.0 {
            guess
        } else {
            nearest.start()
        }
    }

    /// Finds the beginning that a turn returns to, by Broyden's method (Broyden 1965, Math. Comp. 19).
    fn search(&mut self, viscosity: f64, guess: [f64; 2], aim: Aim) -> Result<Orbit, NoLeap> {
        const TURNS: usize = 60;
        let close = match aim {
            Aim::Heat => (1e3 * self.tolerance).clamp(1e-9, 1e-2),
            Aim::Place => (1e3 * self.tolerance).clamp(1e-9, 1e-3),
        };
        // Within a turn's own error nothing is to be learnt about the slope.
        let noise = 10.0 * PLACE_ERROR * self.tolerance;
        let mut start = Vector2::from(guess);
        let (mut end, mut flows) = self.turn(viscosity, start)?;
        for _ in 0..TURNS {
            let miss = end - start;
            let newton = self
                .slope
                .lu()
                .solve(&-miss)
                .filter(|step| (start + step).norm() < 1.0);
            let step = newton.unwrap_or(miss);
            if aim.distance(start, end) < close {
                return Ok(Orbit::new(start + step, &flows));
            }
            start += step;
            (end, flows) = self.turn(viscosity, start)?;
            if step.norm() > noise {
                let change = (end - start) - miss;
                self.slope += (change - self.slope * step) * step.transpose() / step.norm_squared();
            }
        }
        Err(NoLeap::NoOrbit(viscosity))
    }

    /// One turn at a fixed viscosity: where it ends, and its mean flows.
    fn turn(
        &mut self,
        viscosity: f64,
        start: Vector2<f64>,
    ) -> Result<(Vector2<f64>, Flows), Failure> {
        let period = self.model.period();
        let rates = |tau: f64, y: &[f64; 2]| {
            let (velocity, flows) = self.model.journal(tau, *y, viscosity);
            (velocity, [flows.viscous, flows.boundary, flows.side_flow])
        };
        let integrator = DormandPrince {
            allowed: [PLACE_ERROR * self.tolerance; 2],
            limit: 1_000_000,
        };
        let heat_error = HEAT_ERROR * self.tolerance * self.heat * period;
        let along = Quadrature {
            allowed: [heat_error, heat_error, f64::INFINITY],
        };
        let mut y = [start.x, start.y];
        let (_, means) =
            integrator.integrate_along(rates, &mut y, along, period, &mut self.step)?;
        let [viscous, boundary, side_flow] = means.map(|integral| integral / period);
        self.heat = viscous + boundary;
        let flows = Flows {
            viscous,
            boundary,
            side_flow,
        };
        Ok((y.into(), flows))
    }
}
