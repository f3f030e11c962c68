//! The answer of the pressure flow to the oil's viscosity and density over pressure, in the matrix.
//!
//! The conductance of an edge goes with the mean `ease` of its two cells, which depends on their pressures. When the
//! linearisation omits this, the iteration oscillates in oil that thickens much (`alpha p` of about one and more).

use super::super::upwind::edges;
use super::{LinearisedFilm, unknowns::Unknowns};
use crate::reynolds::ring::Ring;

/// Adds the derivatives of the flow over an edge, from its first cell to its second, over the pressures in `ease` of both to the
/// `diagonal`, and to the couplings of its first cell to its second and back.
fn add(
    diagonal: &mut [f64],
    [ahead, back]: [&mut f64; 2],
    ends: [usize; 2],
    conductance: f64,
    unknowns: &Unknowns,
    LinearisedFilm { liquid, field, .. }: &LinearisedFilm,
) {
    let [a, b] = ends;
    let flow = conductance * (field.pressure[a] - field.pressure[b]);
    let by_ease = flow / (liquid.ease[a] + liquid.ease[b]);
    let gains = ends.map(|cell| unknowns.full[cell] * by_ease * liquid.easing[cell]);
    let rows = ends.map(|cell| unknowns.balanced[cell]);
    diagonal[a] += rows[0] * gains[0];
    *ahead += rows[0] * gains[1];
    *back -= rows[1] * gains[0];
    diagonal[b] -= rows[1] * gains[1];
}

/// Adds the derivatives of all flows to the matrix.
pub fn thicken(ring: &mut Ring, unknowns: &Unknowns, base: &LinearisedFilm) {
    let LinearisedFilm { cells, liquid, field, balance, stage, .. } = *base;
    for (a, b) in edges(cells) {
        let couplings = [&mut ring.after[a], &mut ring.before[b]];
        add(&mut ring.diagonal, couplings, [a, b], balance.along[b], unknowns, base);
    }
    for b in 1..cells.count() {
        let a = b - 1;
        let couplings = [&mut ring.above[a], &mut ring.below[b]];
        add(&mut ring.diagonal, couplings, [a, b], balance.across[b], unknowns, base);
    }
    for cell in 0..cells.count() {
        let flow = balance.open[cell] * (field.pressure[cell] - stage.side);
        ring.diagonal[cell] += unknowns.full[cell] * flow * liquid.easing[cell] / liquid.ease[cell];
    }
}
