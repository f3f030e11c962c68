//! Differences between the journal's orbits at one clearance and those at another, over the viscosity. They change little with it, so
//! that few orbits tell them.

use super::{NoLeap, TwoScales, curve::Curve, orbit::Orbit};
use nalgebra::SVector;

/// The differences at one clearance.
pub struct Differences<'a, M> {
    curve: Curve<'a, M>,
    /// Pairs of ln(viscosity) and difference, in ascending order, with straight lines between them.
    nodes: Vec<(f64, SVector<f64, 5>)>,
}

/// A difference serves for viscosities up to this far beyond the outermost ones, in their logarithm.
const REACH: f64 = 0.4;
/// The tolerance of these orbits over that of the others: their weights are small.
const ASIDE: f64 = 5.0;

impl<'a, M: TwoScales> Differences<'a, M> {
    /// The differences at a clearance, m, from the departure's curve.
    pub fn new(departure: &Curve<'a, M>, clearance: f64) -> Self {
        Self { curve: departure.at_clearance(clearance, ASIDE), nodes: Vec::new() }
    }

    /// The difference at a viscosity from the departure's orbit there; `guess` tells it where none is known yet.
    pub fn at(
        &mut self,
        viscosity: f64,
        departure: &Orbit,
        guess: impl FnOnce() -> SVector<f64, 5>,
    ) -> Result<SVector<f64, 5>, NoLeap> {
        let x = viscosity.ln();
        let known = match (self.nodes.first(), self.nodes.last()) {
            (Some((first, _)), Some((last, _))) => {
                let line = self.line(x);
                if (first - x).max(x - last) <= REACH {
                    return Ok(line);
                }
                line
            }
            _ => guess(),
        };
        let near = Orbit(departure.0 + known).place();
        let near = if near.norm() < 1.0 { near } else { departure.place() };
        let difference = self.curve.orbit(viscosity, near)?.0 - departure.0;
        let index = self.nodes.partition_point(|(node, _)| *node <= x);
        self.nodes.insert(index, (x, difference));
        Ok(difference)
    }

    /// On the line through the two nodes next to `x`, or at the only one.
    pub fn line(&self, x: f64) -> SVector<f64, 5> {
        let nodes = &self.nodes;
        let above = nodes.partition_point(|(node, _)| *node <= x);
        match nodes.get(above.clamp(1, nodes.len().max(2) - 1) - 1..) {
            Some([(a, from), (b, to), ..]) => from + (to - from) * ((x - a) / (b - a)),
            Some([(_, only)]) => *only,
            _ => SVector::zeros(),
        }
    }
}
