//! The journal's orbits over the film's viscosity and the clearance: a curve over the viscosity at each of some clearances,
//! with polynomials between them.
//!
//! Temperatures and wear change the clearance as slowly as the viscosity. The curves stand at clearances of equal ratios,
//! counted from that of the departure; each is made where it is first needed. A clearance that stays is one curve.
//!
//! A steady start needs less: turns that are resolved refine its temperatures. There, parabolas pass through the
//! [differences](super::differences) between the orbits at three clearances.

use super::{Departure, NoLeap, TwoScales, curve::Curve, differences::Differences, orbit::Orbit};
use nalgebra::{SMatrix, SVector, Vector2};

/// The quantity between the clearances.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Across {
    /// Parabolas through differences from the departure's curve, which need few orbits: for temperatures that resolved turns
    /// refine.
    Parabolas,
    /// Cubic polynomials through curves.
    Cubics,
}

/// Curves over the logarithm of the clearance.
pub struct Curves<'a, M> {
    /// The logarithm of the departure's clearance.
    middle: f64,
    /// The distance of neighbouring curves in the logarithm of the clearance.
    spacing: f64,
    across: Across,
    /// The number of the clearance in the middle of the last parabola.
    centre: i32,
    /// At each clearance of a parabola but the departure's, by its number.
    differences: Vec<(i32, Differences<'a, M>)>,
    /// Each with its number; the departure's has the number zero and comes first.
    curves: Vec<(i32, Curve<'a, M>)>,
    /// The place in `curves` of the one that was used last.
    latest: usize,
}

/// A parabola serves up to this distance from its middle, in distances of curves. From half of one on, the next would serve, too:
/// so Newton's method never jumps to and fro between two.
const KEPT: f64 = 0.75;
/// Curves that a polynomial passes through.
const THROUGH: i32 = 4;
/// The distance of two curves at a tolerance of [`USUAL`]. The error of a cubic goes as its fourth power.
const SPACING: f64 = 0.1;
const USUAL: f64 = 1e-6;

impl<'a, M: TwoScales> Curves<'a, M> {
    /// The curve at the clearance of the departure, with its first orbit.
    pub fn new(model: &'a M, tolerance: f64, across: Across, from: &Departure) -> Result<(Self, Orbit), NoLeap> {
        let clearance = model.clearance(&from.temperatures, from.worn);
        let (curve, first) = Curve::new(model, tolerance, clearance, from)?;
        let curves = Self {
            middle: clearance.ln(),
            spacing: SPACING * (tolerance / USUAL).powf(0.25).min(1.0),
            across,
            centre: 0,
            differences: Vec::new(),
            curves: vec![(0, curve)],
            latest: 0,
        };
        Ok((curves, first))
    }

    /// The orbit at a viscosity and a clearance.
    pub fn at(&mut self, viscosity: f64, clearance: f64) -> Result<Orbit, NoLeap> {
        let x = (clearance.ln() - self.middle) / self.spacing;
        if x == 0.0 {
            self.latest = 0;
            return self.curves[0].1.at(viscosity);
        }
        if self.across == Across::Parabolas {
            return self.on_parabola(viscosity, x);
        }
        let lowest = x.floor() as i32 - 1;
        let mut sum = Orbit::default();
        // From the middle outwards, so that a new curve has a neighbour.
        for j in [1, 2, 0, 3] {
            let curve = self.curve(lowest + j, viscosity)?;
            sum.0 += curve.at(viscosity)?.0 * weight(x - f64::from(lowest), j, THROUGH);
        }
        Ok(sum)
    }

    /// The orbit at a viscosity and at the place `x` among the clearances, on a parabola.
    fn on_parabola(&mut self, viscosity: f64, x: f64) -> Result<Orbit, NoLeap> {
        if (x - f64::from(self.centre)).abs() > KEPT {
            self.centre = x.round() as i32;
        }
        self.latest = 0;
        let departure = self.curves[0].1.at(viscosity)?;
        let lowest = self.centre - 1;
        let mut sum = departure;
        // From the middle outwards, so that each has a neighbour that tells where to search.
        for j in [1, 0, 2] {
            let number = lowest + j;
            if number != 0 {
                let difference = self.difference(number, viscosity, &departure)?;
                sum.0 += difference * weight(x - f64::from(lowest), j, 3);
            }
        }
        Ok(sum)
    }

    /// The difference at the clearance with this number from the departure's orbit.
    fn difference(&mut self, number: i32, viscosity: f64, departure: &Orbit) -> Result<SVector<f64, 5>, NoLeap> {
        let place = self.differences.iter().position(|(n, _)| *n == number);
        let index = match place {
            Some(index) => index,
            None => {
                let clearance = (self.middle + f64::from(number) * self.spacing).exp();
                let differences = Differences::new(&self.curves[0].1, clearance);
                self.differences.push((number, differences));
                self.differences.len() - 1
            }
        };
        let (others, rest) = self.differences.split_at_mut(index);
        let ((_, differences), more) = rest.split_first_mut().expect("it is in the list");
        let x = viscosity.ln();
        // The differences go nearly as the distance from the departure's clearance.
        let guess = || {
            let known = others.iter().chain(more.iter());
            let nearest = known.min_by_key(|(n, _)| n.abs_diff(number));
            nearest.map_or(SVector::zeros(), |(n, near)| near.line(x) * (f64::from(number) / f64::from(*n)))
        };
        differences.at(viscosity, departure, guess)
    }

    /// Where the journal is when the orbit at a viscosity and a clearance begins.
    pub fn place(&mut self, viscosity: f64, clearance: f64) -> Result<Vector2<f64>, NoLeap> {
        let near = self.at(viscosity, clearance)?.place();
        let curve = &mut self.curves[self.latest].1;
        if curve.clearance() == clearance {
            return curve.place(viscosity);
        }
        curve.with_orbit(clearance, viscosity, near)?.place(viscosity)
    }

    /// In how many turns the journal comes to its orbit from the departure, if these are too many for a leap over `turns`.
    pub fn far(&self, from: &Departure, turns: usize) -> Result<Option<f64>, NoLeap> {
        Ok(self.curves[0].1.far(from, turns)?)
    }

    /// Approximate derivative of a turn's end and flows over its beginning, at the latest orbit.
    pub fn slope(&self) -> SMatrix<f64, 5, 2> {
        self.curves[self.latest].1.slope()
    }

    /// The curve with this number; it begins at this viscosity if it is new.
    fn curve(&mut self, number: i32, viscosity: f64) -> Result<&mut Curve<'a, M>, NoLeap> {
        let known = self.curves.iter().position(|(known, _)| *known == number);
        let index = match known {
            Some(index) => index,
            None => {
                let clearance = (self.middle + f64::from(number) * self.spacing).exp();
                let nearest = self.curves.iter_mut().min_by_key(|(known, _)| known.abs_diff(number));
                let (_, neighbour) = nearest.expect("the departure's curve is there");
                let guess = neighbour.at(viscosity)?.place();
                let curve = neighbour.with_orbit(clearance, viscosity, guess)?;
                self.curves.push((number, curve));
                self.curves.len() - 1
            }
        };
        self.latest = index;
        Ok(&mut self.curves[index].1)
    }
}

/// Lagrange's weight of the node `j` of so many nodes at 0, 1, ..., at the place `x`.
fn weight(x: f64, j: i32, through: i32) -> f64 {
    (0..through).filter(|k| *k != j).map(|k| (x - f64::from(k)) / f64::from(j - k)).product()
}
