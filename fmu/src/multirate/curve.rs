//! The journal's orbits over the film's viscosity: found where they are needed, with polynomials between them.

use super::{
    Departure, NoLeap, TwoScales,
    orbit::{Orbit, Piece},
    reach, stiff,
};
use crate::{
    bearing::Flows,
    solver::{Budget, DormandPrince, Failure},
};
use nalgebra::{Matrix2, SMatrix, Vector2};

/// Orbits over the logarithm of the viscosity.
pub struct Curve<'a, M> {
    model: &'a M,
    /// The clearance of all its orbits, m.
    clearance: f64,
    tolerance: f64,
    /// Pairs of ln(viscosity) and orbit, in ascending order.
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
    /// The internal steps that all turns together may still take.
    left: usize,
    /// Whether turns take implicit steps.
    stiff: bool,
}

/// The distance of the second orbit in the logarithm of the viscosity.
const PROBE: f64 = 0.06;
/// Factor by which the distance between orbits grows from one to the next.
const WIDENING: f64 = 4.0;
/// The largest distance of two orbits.
const FARTHEST: f64 = 0.5;
/// No orbits are found closer together than this.
const CLOSEST: f64 = 0.01;
/// Internal steps in all turns of a leap, at the most, for each of the shaft's turns in one: a leap takes some thousands.
const MOST_STEPS: usize = 200_000;
/// A turn of the shaft that takes more explicit steps than this is stiff.
const MOST_EXPLICIT: usize = 5_000;
/// Steps per turn of the shaft with which the first turn begins.
const FIRST_STEPS: f64 = 6.0;
/// Error allowed in the place per step within a turn, at a relative tolerance of one.
const PLACE_ERROR: f64 = 100.0;
/// The same of the mean heat of one of the shaft's turns, as a part of it.
const HEAT_ERROR: f64 = 100.0;
/// The same of what the last term of the polynomial between the orbits contributes to it.
const CURVE_ERROR: f64 = 500.0;

/// A leap is longer than the journal's approach to its orbit by this factor, so that nothing is left of it at the end, and the
/// longer the further the journal is off, so that the approach's heat hardly matters.
const AT_THE_END: f64 = 2.0;
const FOR_THE_HEAT: f64 = 100.0;
/// The last term of a place on the polynomial that will do.
const POLYNOMIAL_PLACE: f64 = 1e3;

/// The use of an orbit. It decides how closely a turn must come back to its beginning.
#[derive(Clone, Copy, Debug, PartialEq)]
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
                // Mean planes of rough surfaces may cross (e > 1). Then the heat changes over the height of the roughness, here
                // a hundredth of the clearance.
                let gap = if e < 1.0 { (1.0 - e).max(1e-6) } else { 1e-2 };
                miss * e / gap
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
    /// A curve at a clearance, m, with its first orbit.
    pub fn new(model: &'a M, tolerance: f64, clearance: f64, from: &Departure) -> Result<(Self, Orbit), NoLeap> {
        let viscosity = model.viscosity(from.temperatures.film);
        let end = Vector2::from(from.eccentricity);
        let (_, flows) = model.journal(clearance)(0.0, from.eccentricity, viscosity);
        let mut curve = Self {
            model,
            clearance,
            tolerance,
            nodes: Vec::new(),
            latest: viscosity.ln(),
            piece: None,
            slope: SMatrix::zeros(),
            heat: flows.viscous + flows.boundary,
            step: model.period() / (model.turns() as f64 * FIRST_STEPS),
            left: MOST_STEPS * model.turns(),
            stiff: false,
        };
        // The resolved turn gives a better slope.
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

    /// In how many turns the journal comes to its first orbit from the departure, if these are too many for a leap over `turns`.
    pub fn far(&self, from: &Departure, turns: usize) -> Result<Option<f64>, Failure> {
        let [start, first] = [Vector2::from(from.eccentricity), self.nodes[0].1.place()];
        let off = first - start;
        if off.norm() <= self.noise() {
            return Ok(None);
        }
        let needed = |shrinking: f64| {
            let needed = (off.norm() / (PLACE_ERROR * self.tolerance)).ln() / shrinking.max(1.0).ln();
            Some(needed).filter(|needed| needed * (AT_THE_END + FOR_THE_HEAT * off.norm()) > turns as f64)
        };
        let slope = self.slope.fixed_rows::<2>(0);
        if needed(off.norm() / (slope * off).norm()).is_none() {
            return Ok(None);
        }
        // The slope may be a guess. Turns at one viscosity tell.
        let mut curve = self.at_clearance(self.clearance, 1.0);
        let viscosity = self.model.viscosity(from.temperatures.film);
        let next = curve.turn(viscosity, start)?.place();
        let last = curve.turn(viscosity, next)?.place();
        Ok(needed((next - start).norm() / (last - next).norm()))
    }

    /// The same at another clearance, m, and `slack` times the tolerance, still without orbits.
    pub fn at_clearance(&self, clearance: f64, slack: f64) -> Self {
        Self { clearance, tolerance: slack * self.tolerance, nodes: Vec::new(), piece: None, ..*self }
    }

    /// The same at another clearance, m, with an orbit at a viscosity that begins near `guess`.
    pub fn with_orbit(&self, clearance: f64, viscosity: f64, guess: Vector2<f64>) -> Result<Self, NoLeap> {
        let mut curve = self.at_clearance(clearance, 1.0);
        let first = curve.orbit(viscosity, guess)?;
        curve.latest = viscosity.ln();
        curve.nodes.push((curve.latest, first));
        Ok(curve)
    }

    /// The orbit at a viscosity that begins near `guess`, searched for.
    pub fn orbit(&mut self, viscosity: f64, guess: Vector2<f64>) -> Result<Orbit, NoLeap> {
        self.search(viscosity, guess, Aim::Heat)
    }

    /// The clearance, m.
    pub fn clearance(&self) -> f64 {
        self.clearance
    }

    /// From less than a turn's own error nothing is to be learnt about the slope.
    fn noise(&self) -> f64 {
        10.0 * PLACE_ERROR * self.tolerance
    }

    /// The orbit at a viscosity; finds further orbits until the polynomial's last term hardly matters.
    pub fn at(&mut self, viscosity: f64) -> Result<Orbit, NoLeap> {
        const MOST: usize = 100;
        let x = viscosity.ln();
        while self.nodes.len() < MOST && x.is_finite() {
            let gap = self.nodes.partition_point(|(node, _)| *node <= x);
            let piece = match self.piece {
                Some(piece) if piece.gap == gap => piece,
                _ => *self.piece.insert(Piece::new(&self.nodes, gap)),
            };
            let (orbit, last) = piece.at(x);
            let close = piece.weigh(&last) < CURVE_ERROR * self.tolerance;
            if x == piece.x[0] || piece.count > 2 && close && self.reaches(x) {
                return Ok(orbit);
            }
            let Some(missing) = self.missing(x, gap) else {
                return Ok(orbit);
            };
            let guess = Piece::new(&self.nodes, gap).at(missing).0.place();
            let guess = if guess.norm() < 1.0 { guess } else { piece.nearest.place() };
            let orbit = self.search(missing.exp(), guess, Aim::Heat)?;
            let index = self.nodes.partition_point(|(node, _)| *node <= missing);
            self.nodes.insert(index, (missing, orbit));
            self.latest = missing;
            self.piece = None;
        }
        Err(NoLeap::NoOrbit(viscosity))
    }

    /// Where the journal is when the orbit at a viscosity begins: on the polynomial where its last term hardly matters
    /// there, too, else searched for.
    pub fn place(&mut self, viscosity: f64) -> Result<Vector2<f64>, NoLeap> {
        let near = self.at(viscosity)?.place();
        if let Some(piece) = &self.piece {
            let (orbit, last) = piece.at(viscosity.ln());
            let last: Vector2<f64> = last.fixed_rows::<2>(0).into();
            if piece.count > 2 && last.norm() < POLYNOMIAL_PLACE * self.tolerance {
                return Ok(orbit.place());
            }
        }
        Ok(self.search(viscosity, near, Aim::Place)?.place())
    }

    /// Approximate derivative of a turn's end and flows over its beginning, at the latest orbit.
    pub fn slope(&self) -> SMatrix<f64, 5, 2> {
        self.slope
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
    fn search_from(&mut self, viscosity: f64, guess: Vector2<f64>, turn: Orbit, aim: Aim) -> Result<Orbit, NoLeap> {
        const TURNS: usize = 60;
        let (mut start, mut turn) = (guess, turn);
        for _ in 0..TURNS {
            let miss = turn.place() - start;
            let reach = reach(start, turn.place());
            let step = self.newton(miss).filter(|step| (start + step).norm() < reach);
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
        let steps = self.left.min(MOST_EXPLICIT * self.model.turns());
        let journal = self.model.journal(self.clearance);
        let rates = |tau: f64, y: &[f64; 2]| {
            let (velocity, flows) = journal(tau, *y, viscosity);
            (velocity, [flows.viscous, flows.boundary, flows.side_flow])
        };
        let integrator = DormandPrince { allowed: [PLACE_ERROR * self.tolerance; 2], budget: Budget::of(steps) };
        let heat_error = HEAT_ERROR * self.tolerance * self.heat * period / self.model.turns() as f64;
        let along = [heat_error; 2];
        let mut y = start.into();
        let explicit = if self.stiff {
            None
        } else {
            let step = self.step;
            let done = integrator.integrate_along(rates, &mut y, along, period, &mut self.step);
            match done {
                Err(Failure::TooManySteps { .. }) if steps < self.left => {
                    (self.stiff, self.step) = (true, step);
                    self.left -= steps;
                    None
                }
                done => Some(done?),
            }
        };
        let (work, integrals) = match explicit {
            Some(done) => done,
            None => {
                let at = [viscosity, self.clearance];
                let allowed = [PLACE_ERROR * self.tolerance, heat_error];
                let (end, integrals, work) = stiff::turn(self.model, at, start.into(), allowed, self.left, self.step)?;
                y = end;
                (work, integrals)
            }
        };
        self.left = self.left.saturating_sub(work.accepted + work.rejected);
        let [viscous, boundary, side_flow] = integrals.map(|integral| integral / period);
        self.heat = viscous + boundary;
        Ok(Orbit::new(y, &Flows { viscous, boundary, side_flow, feed: 0.0 }))
    }
}
