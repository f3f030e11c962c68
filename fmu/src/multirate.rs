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
        limit: 100_000,
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
    let near = curve.at(viscosity)?.place();
    Ok(Landing {
        eccentricity: curve.search(viscosity, near, Aim::Place)?.place().into(),
        temperatures: temperatures(&t),
    })
}

/// The change of a temperature from which derivatives are taken, K.
const NUDGE: f64 = 1e-3;
/// The error allowed in each temperature per step, K, at a relative tolerance of one.
const DRIFT_ERROR: f64 = 3000.0;

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
struct Orbit(SVector<f64, 5>);

/// Boundary heat is stored on top of this part of the viscous heat: a logarithm wants no zero.
const PEDESTAL: f64 = 1e-3;
/// The least viscous heat, W, and side flow, m³/s, for the same reason.
const LEAST: f64 = 1e-18;

impl Orbit {
    fn new(place: [f64; 2], flows: &Flows) -> Self {
        let viscous = flows.viscous.max(LEAST);
        let boundary = flows.boundary.max(0.0) + PEDESTAL * viscous;
        let side_flow = flows.side_flow.max(0.0) + LEAST;
        let [x, y] = place;
        Self([x, y, viscous.ln(), boundary.ln(), side_flow.ln()].into())
    }

    fn place(&self) -> Vector2<f64> {
        self.0.fixed_rows::<2>(0).into()
    }

    fn flows(&self) -> Flows {
        let viscous = self.0[2].exp();
        Flows {
            viscous,
            boundary: self.0[3].exp() - PEDESTAL * viscous,
            side_flow: self.0[4].exp() - LEAST,
        }
    }

    /// By how much of the whole heat, or of the side flow, a small difference of orbits changes them.
    fn weigh(&self, difference: &SVector<f64, 5>) -> f64 {
        let flows = self.flows();
        let heat = flows.viscous + flows.boundary;
        let on_pedestal = flows.boundary + PEDESTAL * flows.viscous;
        let of_heat = (difference[2] * (flows.viscous - PEDESTAL * flows.viscous)
            + difference[3] * on_pedestal)
            / heat;
        of_heat.abs().max(difference[4].abs())
    }
}

/// Orbits over the logarithm of the viscosity, found where they are needed, with polynomials between them.
struct Curve<'a, M> {
    model: &'a M,
    tolerance: f64,
    /// By the logarithm of the viscosity.
    nodes: Vec<(f64, Orbit)>,
    /// Where the last one was found.
    latest: f64,
    /// The polynomial that was used last.
    piece: Option<Piece>,
    /// Approximate derivative of a turn's end and flows over its beginning.
    slope: SMatrix<f64, 5, 2>,
    /// Mean heat of the last turn, W.
    heat: f64,
    /// The step within a turn to try next, s.
    step: f64,
}

/// A polynomial through the nodes next to a gap between nodes, in Newton's form.
#[derive(Clone, Copy, Debug)]
struct Piece {
    /// How many nodes are below the gap.
    gap: usize,
    /// How many nodes it passes through.
    count: usize,
    /// Those nodes, those at the gap first.
    x: [f64; 4],
    /// The divided differences.
    coefficients: [SVector<f64, 5>; 4],
    nearest: Orbit,
}

/// The distance of the second orbit in the logarithm of the viscosity.
const PROBE: f64 = 0.05;
/// Each further one is so many times as far from the last one as that is from the one before.
const WIDENING: f64 = 3.0;
/// The largest distance of two orbits.
const FARTHEST: f64 = 0.5;
/// No orbits are found closer together than this.
const CLOSEST: f64 = 0.01;
/// Error allowed in the place per step within a turn, at a relative tolerance of one.
const PLACE_ERROR: f64 = 100.0;
/// The same of a turn's mean heat, as a part of it.
const HEAT_ERROR: f64 = 100.0;
/// The same of what the last term of the polynomial between the orbits contributes to it.
const CURVE_ERROR: f64 = 500.0;

impl Piece {
    /// Through up to four of the nodes next to the gap above the first `gap` of them.
    fn new(nodes: &[(f64, Orbit)], gap: usize) -> Self {
        // From the gap outwards, the nearer one first.
        let (mut below, mut above) = (gap, gap);
        let (mut x, mut coefficients) = ([0.0; 4], [SVector::zeros(); 4]);
        let mut count = 0;
        let bounds = [gap.saturating_sub(1), gap.min(nodes.len() - 1)];
        let middle = 0.5 * (nodes[bounds[0]].0 + nodes[bounds[1]].0);
        while count < 4 && (below > 0 || above < nodes.len()) {
            let down = below > 0
                && nodes
                    .get(above)
                    .is_none_or(|(x, _)| x - middle >= middle - nodes[below - 1].0);
            let index = if down {
                below -= 1;
                below
            } else {
                above += 1;
                above - 1
            };
            (x[count], coefficients[count]) = (nodes[index].0, nodes[index].1.0);
            count += 1;
        }
        let nearest = Orbit(coefficients[0]);
        for order in 1..count {
            for i in (order..count).rev() {
                coefficients[i] = (coefficients[i] - coefficients[i - 1]) / (x[i] - x[i - order]);
            }
        }
        Self {
            gap,
            count,
            x,
            coefficients,
            nearest,
        }
    }

    /// The orbit at `x`, and what the highest order adds.
    fn at(&self, x: f64) -> (Orbit, SVector<f64, 5>) {
        let (mut sum, mut last) = (self.coefficients[0], self.coefficients[0]);
        let mut product = 1.0;
        for i in 1..self.count {
            product *= x - self.x[i - 1];
            last = self.coefficients[i] * product;
            sum += last;
        }
        (Orbit(sum), last)
    }
}

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

    /// The distance that will do: what remains is extrapolated with the slope, which is known to some
    /// tenths.
    fn close(self, tolerance: f64) -> f64 {
        match self {
            Self::Heat => (3e3 * tolerance).clamp(1e-9, 1e-2),
            Self::Place => (5e3 * tolerance).clamp(1e-9, 1e-2),
        }
    }
}

impl<'a, M: TwoScales> Curve<'a, M> {
    /// A curve with its first orbit.
    fn new(model: &'a M, tolerance: f64, from: &Departure) -> Result<(Self, Orbit), NoLeap> {
        let viscosity = model.viscosity(from.temperatures.film);
        let end = Vector2::from(from.eccentricity);
        let (_, flows) = model.journal(0.0, from.eccentricity, viscosity);
        let mut curve = Self {
            model,
            tolerance,
            nodes: Vec::new(),
            latest: viscosity.ln(),
            piece: None,
            slope: SMatrix::zeros(),
            heat: flows.viscous + flows.boundary,
            step: model.period() / 50.0,
        };
        // What the resolved turn tells of the slope.
        let turn = curve.turn(viscosity, end)?;
        let step = end - Vector2::from(from.before);
        if step.norm() > curve.noise() {
            let change = turn.place() - end;
            // In half-speed whirl a turn ends where it began, mirrored and shrunk; where the film is
            // stiff, it forgets its beginning. Both are nearly multiples of the identity.
            let part = change.dot(&step) / step.norm_squared();
            let rest = change - step * part;
            let slope = Matrix2::identity() * part + rest * step.transpose() / step.norm_squared();
            curve.slope.fixed_rows_mut::<2>(0).copy_from(&slope);
        }
        let first = curve.search_from(viscosity, end, turn, Aim::Heat)?;
        curve.nodes.push((viscosity.ln(), first));
        Ok((curve, first))
    }

    /// From less than a turn's own error nothing is to be learnt about the slope.
    fn noise(&self) -> f64 {
        10.0 * PLACE_ERROR * self.tolerance
    }

    /// The orbit at a viscosity; finds further orbits until the polynomial's last term hardly matters.
    fn at(&mut self, viscosity: f64) -> Result<Orbit, NoLeap> {
        const MOST: usize = 100;
        let x = viscosity.ln();
        while self.nodes.len() < MOST && x.is_finite() {
            let gap = self.nodes.partition_point(|(node, _)| *node <= x);
            let piece = match self.piece {
                Some(piece) if piece.gap == gap => piece,
                _ => *self.piece.insert(Piece::new(&self.nodes, gap)),
            };
            let (orbit, last) = piece.at(x);
            let close = piece.nearest.weigh(&last) < CURVE_ERROR * self.tolerance;
            if x == piece.x[0] || piece.count > 2 && close && self.reaches(x) {
                return Ok(orbit);
            }
            let Some(missing) = self.missing(x, gap) else {
                return Ok(orbit);
            };
            let guess = Piece::new(&self.nodes, gap).at(missing).0.place();
            let guess = if guess.norm() < 1.0 {
                guess
            } else {
                piece.nearest.place()
            };
            let found = self.search(missing.exp(), guess, Aim::Heat)?;
            let index = self.nodes.partition_point(|(node, _)| *node <= missing);
            self.nodes.insert(index, (missing, found));
            self.latest = missing;
            self.piece = None;
        }
        Err(NoLeap::NoOrbit(viscosity))
    }

    /// Whether `x` is not further from the nodes than these are from each other.
    fn reaches(&self, x: f64) -> bool {
        let [Some((first, _)), Some((last, _))] = [self.nodes.first(), self.nodes.last()] else {
            return false;
        };
        (first - x).max(x - last) <= last - first
    }

    /// Where the next orbit would help most for `x`, above the first `gap` nodes; none when those about
    /// it are close enough together.
    fn missing(&self, x: f64, gap: usize) -> Option<f64> {
        let nodes = &self.nodes;
        let (first, last) = (nodes.first()?.0, nodes.last()?.0);
        let edge = match gap {
            0 => first,
            _ if gap == nodes.len() => last,
            // A third one further ahead: it will be needed there.
            _ if nodes.len() == 2 => self.latest,
            _ => {
                let (below, above) = (nodes[gap - 1].0, nodes[gap].0);
                return (above - below > 2.0 * CLOSEST).then_some(0.5 * (below + above));
            }
        };
        let outwards = match &nodes[..] {
            [_] => (PROBE / WIDENING).copysign(x - edge),
            [(a, _), (b, _), ..] if edge == *a => a - b,
            [.., (a, _), (b, _)] => b - a,
            [] => return None,
        };
        let distance = (WIDENING * outwards.abs()).min(FARTHEST);
        let beyond = (x - edge) * outwards.signum();
        Some(edge + distance.max(beyond).copysign(outwards))
    }

    /// Finds the beginning that a turn returns to.
    fn search(&mut self, viscosity: f64, guess: Vector2<f64>, aim: Aim) -> Result<Orbit, NoLeap> {
        let turn = self.turn(viscosity, guess)?;
        self.search_from(viscosity, guess, turn, aim)
    }

    /// The same, with the turn that begins at the guess, by Broyden's method (Broyden 1965, Math. Comp. 19).
    fn search_from(
        &mut self,
        viscosity: f64,
        guess: Vector2<f64>,
        turn: Orbit,
        aim: Aim,
    ) -> Result<Orbit, NoLeap> {
        const TURNS: usize = 60;
        let (mut start, mut turn) = (guess, turn);
        for _ in 0..TURNS {
            let miss = turn.place() - start;
            let step = self.newton(miss).filter(|step| (start + step).norm() < 1.0);
            if aim.distance(start, turn.place()) < aim.close(self.tolerance) {
                return Ok(step.map_or(turn, |step| Orbit(turn.0 + self.slope * step)));
            }
            let step = step.unwrap_or(miss);
            start += step;
            let next = self.turn(viscosity, start)?;
            if step.norm() > self.noise() {
                let change = next.0 - turn.0;
                self.slope += (change - self.slope * step) * step.transpose() / step.norm_squared();
            }
            turn = next;
        }
        Err(NoLeap::NoOrbit(viscosity))
    }

    /// The change of a turn's beginning that makes up for its miss.
    fn newton(&self, miss: Vector2<f64>) -> Option<Vector2<f64>> {
        let system = Matrix2::identity() - self.slope.fixed_rows::<2>(0);
        system.try_inverse().map(|inverse| inverse * miss)
    }

    /// One turn at a fixed viscosity: where it ends, and its mean flows.
    fn turn(&mut self, viscosity: f64, start: Vector2<f64>) -> Result<Orbit, Failure> {
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
        let mut y = start.into();
        let (_, integrals) =
            integrator.integrate_along(rates, &mut y, along, period, &mut self.step)?;
        let [viscous, boundary, side_flow] = integrals.map(|integral| integral / period);
        self.heat = viscous + boundary;
        Ok(Orbit::new(
            y,
            &Flows {
                viscous,
                boundary,
                side_flow,
            },
        ))
    }
}
