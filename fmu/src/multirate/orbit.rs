//! Periodic orbits of the journal, and polynomials between them.

use crate::bearing::Flows;
use nalgebra::{SVector, Vector2};

/// A periodic orbit: where it begins, and the logarithms of its flows averaged over the turn. The flows
/// go nearly as powers of the viscosity, so their logarithms are nearly straight over its logarithm.
#[derive(Clone, Copy, Debug, Default)]
pub struct Orbit(pub SVector<f64, 5>);

/// Boundary heat is stored on top of this part of the viscous heat: a logarithm wants no zero.
const PEDESTAL: f64 = 1e-3;
/// The least viscous heat, W, and side flow, m³/s, for the same reason.
const LEAST: f64 = 1e-18;

impl Orbit {
    /// Of the place where it begins, and its flows averaged over the turn.
    pub fn new(place: [f64; 2], flows: &Flows) -> Self {
        let viscous = flows.viscous.max(LEAST);
        let boundary = flows.boundary.max(0.0) + PEDESTAL * viscous;
        let side_flow = flows.side_flow.max(0.0) + LEAST;
        let [x, y] = place;
        Self([x, y, viscous.ln(), boundary.ln(), side_flow.ln()].into())
    }

    /// The eccentricity-ratio vector at its beginning, 1.
    pub fn place(&self) -> Vector2<f64> {
        self.0.fixed_rows::<2>(0).into()
    }

    /// The flows averaged over the turn.
    pub fn flows(&self) -> Flows {
        let viscous = self.0[2].exp();
        Flows { viscous, boundary: self.0[3].exp() - PEDESTAL * viscous, side_flow: self.0[4].exp() - LEAST, feed: 0.0 }
    }

    /// The parts of the whole heat by which a change of the two heats' logarithms changes it.
    fn weights(&self) -> [f64; 2] {
        let flows = self.flows();
        let heat = flows.viscous + flows.boundary;
        let pedestal = PEDESTAL * flows.viscous;
        [flows.viscous - pedestal, flows.boundary + pedestal].map(|part| part / heat)
    }
}

/// A polynomial through the nodes next to a gap between nodes, in Newton's form.
#[derive(Clone, Copy, Debug)]
pub struct Piece {
    /// How many nodes are below the gap.
    pub gap: usize,
    /// How many nodes it passes through.
    pub count: usize,
    /// Places of these nodes, the ones next to the gap first.
    pub x: [f64; 4],
    /// The divided differences.
    coefficients: [SVector<f64, 5>; 4],
    /// The node next to the gap.
    pub nearest: Orbit,
    /// Weights of viscous and boundary friction in the heat of the nearest orbit.
    weights: [f64; 2],
}

impl Piece {
    /// Through up to four of the nodes next to the gap above the first `gap` of them.
    pub fn new(nodes: &[(f64, Orbit)], gap: usize) -> Self {
        // From the gap outwards, the nearer one first.
        let (mut below, mut above) = (gap, gap);
        let (mut x, mut coefficients) = ([0.0; 4], [SVector::zeros(); 4]);
        let mut count = 0;
        let bounds = [gap.saturating_sub(1), gap.min(nodes.len() - 1)];
        let middle = 0.5 * (nodes[bounds[0]].0 + nodes[bounds[1]].0);
        while count < 4 && (below > 0 || above < nodes.len()) {
            let down = below > 0 && nodes.get(above).is_none_or(|(x, _)| x - middle >= middle - nodes[below - 1].0);
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
        Self { gap, count, x, coefficients, nearest, weights: nearest.weights() }
    }

    /// Relative change of the heat or of the side flow, whichever is larger, by a small difference of orbits.
    pub fn weigh(&self, difference: &SVector<f64, 5>) -> f64 {
        let [viscous, boundary] = self.weights;
        let of_heat = difference[2] * viscous + difference[3] * boundary;
        of_heat.abs().max(difference[4].abs())
    }

    /// The orbit at `x`, and what the highest order adds.
    pub fn at(&self, x: f64) -> (Orbit, SVector<f64, 5>) {
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
