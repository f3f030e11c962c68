//! The journal's orbits over the film's viscosity and the clearance: a curve over the viscosity at each of some clearances,
//! with polynomials between them.
//!
//! Temperatures and wear change the clearance as slowly as the viscosity. The curves stand at clearances of equal ratios,
//! counted from that of the departure; each is made where it is first needed. A clearance that stays is one curve.

use super::curve::Curve;
use super::orbit::Orbit;
use super::{Departure, NoLeap, TwoScales};
use nalgebra::{Matrix2, Vector2};

/// Curves over the logarithm of the clearance.
pub(super) struct Curves<'a, M> {
    /// The logarithm of the departure's clearance.
    middle: f64,
    /// The distance of neighbouring curves in the logarithm of the clearance.
    spacing: f64,
    /// Each with its number; the departure's has the number zero and comes first.
    curves: Vec<(i32, Curve<'a, M>)>,
    /// The place in `curves` of the one that was used last.
    latest: usize,
}

/// Curves that a polynomial passes through.
const THROUGH: i32 = 4;
/// The distance of two curves at a tolerance of [`USUAL`]. The error of a cubic goes as its fourth power.
const SPACING: f64 = 0.1;
const USUAL: f64 = 1e-6;

impl<'a, M: TwoScales> Curves<'a, M> {
    /// The curve at the clearance of the departure, with its first orbit.
    pub(super) fn new(
        model: &'a M,
        tolerance: f64,
        from: &Departure,
    ) -> Result<(Self, Orbit), NoLeap> {
        let clearance = model.clearance(&from.temperatures, from.worn);
        let (curve, first) = Curve::new(model, tolerance, clearance, from)?;
        let curves = Self {
            middle: clearance.ln(),
            spacing: SPACING * (tolerance / USUAL).powf(0.25).min(1.0),
            curves: vec![(0, curve)],
            latest: 0,
        };
        Ok((curves, first))
    }

    /// The orbit at a viscosity and a clearance.
    pub(super) fn at(&mut self, viscosity: f64, clearance: f64) -> Result<Orbit, NoLeap> {
        let x = (clearance.ln() - self.middle) / self.spacing;
        if x == 0.0 {
            self.latest = 0;
            return self.curves[0].1.at(viscosity);
        }
        let lowest = x.floor() as i32 - 1;
        let mut sum = Orbit::default();
        // From the middle outwards, so that a new curve has a neighbour.
        for j in [1, 2, 0, 3] {
            let curve = self.curve(lowest + j, viscosity)?;
            sum.0 += curve.at(viscosity)?.0 * weight(x - f64::from(lowest), j);
        }
        Ok(sum)
    }

    /// Where the orbit at a viscosity and a clearance begins.
    pub(super) fn place(&mut self, viscosity: f64, clearance: f64) -> Result<Vector2<f64>, NoLeap> {
        let near = self.at(viscosity, clearance)?.place();
        let curve = &mut self.curves[self.latest].1;
        if curve.clearance() == clearance {
            return curve.place(viscosity);
        }
        curve.beside(clearance, viscosity, near)?.place(viscosity)
    }

    /// Approximate derivative of a turn's end over its beginning, at the latest orbit.
    pub(super) fn slope(&self) -> Matrix2<f64> {
        self.curves[self.latest].1.slope()
    }

    /// The curve with this number; it begins at this viscosity if it is new.
    fn curve(&mut self, number: i32, viscosity: f64) -> Result<&mut Curve<'a, M>, NoLeap> {
        let known = self.curves.iter().position(|(known, _)| *known == number);
        let index = match known {
            Some(index) => index,
            None => {
                let clearance = (self.middle + f64::from(number) * self.spacing).exp();
                let nearest = self
                    .curves
                    .iter_mut()
                    .min_by_key(|(known, _)| known.abs_diff(number));
                let Some((_, neighbour)) = nearest else {
                    return Err(NoLeap::NoOrbit(viscosity));
                };
                let guess = neighbour.at(viscosity)?.place();
                let curve = neighbour.beside(clearance, viscosity, guess)?;
                self.curves.push((number, curve));
                self.curves.len() - 1
            }
        };
        self.latest = index;
        Ok(&mut self.curves[index].1)
    }
}

/// Lagrange's weight of the node `j` of [`THROUGH`] nodes at 0, 1, ..., at the place `x`.
fn weight(x: f64, j: i32) -> f64 {
    (0..THROUGH)
        .filter(|k| *k != j)
        .map(|k| (x - f64::from(k)) / f64::from(j - k))
        .product()
}
