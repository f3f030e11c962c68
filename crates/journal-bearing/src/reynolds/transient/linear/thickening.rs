//! The answer of the pressure flow to the oil's viscosity and density over pressure, in the matrix.
//!
//! The conductance of an edge goes with the mean `ease` of its two cells, which depends on their pressures. When the
//! linearisation omits this, the iteration oscillates in oil that thickens much (`alpha p` of about one and more).

use super::super::{liquid::Liquid, state::Field};
use super::{Base, unknowns::Unknowns};
use crate::reynolds::ring::Ring;

/// Derivatives of the flow over an edge, from its first cell to its second, over the pressures in `ease` of both.
fn gains(conductance: f64, ends: [usize; 2], full: &[f64], liquid: &Liquid, field: &Field) -> [f64; 2] {
    let [a, b] = ends;
    let flow = conductance * (field.pressure[a] - field.pressure[b]);
    let by_ease = flow / (liquid.ease[a] + liquid.ease[b]);
    ends.map(|cell| full[cell] * by_ease * liquid.easing[cell])
}

/// Adds these derivatives to the matrix.
pub fn thicken(ring: &mut Ring, unknowns: &Unknowns, base: &Base<'_>) {
    let Base { cells, liquid, field, balance, stage, .. } = *base;
    for (behind, before) in cells.neighbours() {
        for (behind, before) in behind.zip(before) {
            let ends = [before, behind];
            let gains = gains(balance.along[behind], ends, &unknowns.full, liquid, field);
            let rows = ends.map(|cell| unknowns.balanced[cell]);
            ring.diagonal[before] += rows[0] * gains[0];
            ring.after[before] += rows[0] * gains[1];
            ring.before[behind] -= rows[1] * gains[0];
            ring.diagonal[behind] -= rows[1] * gains[1];
        }
    }
    for cell in 1..cells.count() {
        let below = cell - 1;
        let ends = [below, cell];
        let gains = gains(balance.across[cell], ends, &unknowns.full, liquid, field);
        let rows = ends.map(|cell| unknowns.balanced[cell]);
        ring.diagonal[below] += rows[0] * gains[0];
        ring.above[below] += rows[0] * gains[1];
        ring.below[cell] -= rows[1] * gains[0];
        ring.diagonal[cell] -= rows[1] * gains[1];
    }
    for cell in 0..cells.count() {
        let flow = balance.open[cell] * (field.pressure[cell] - stage.side);
        ring.diagonal[cell] += unknowns.full[cell] * flow * liquid.easing[cell] / liquid.ease[cell];
    }
}
