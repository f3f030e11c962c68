//! How the flow answers to what pressure does to the oil's viscosity and density.
//!
//! The conductance of an edge goes with the mean `ease` of its cells. Left out of the linearisation, its change over the
//! pressure makes the iteration go to and fro where the oil thickens much (`alpha p` of about one and more).

use super::balance::{Balance, Stage};
use super::cells::Cells;
use super::field::Field;
use super::linear::Linear;
use super::liquid::Liquid;

/// What the flow over an edge, from its first cell to its second, gains by the ease of each, per unit of their pressures.
fn gains(
    conductance: f64,
    ends: [usize; 2],
    full: &[f64],
    liquid: &Liquid,
    field: &Field,
) -> [f64; 2] {
    let [a, b] = ends;
    let flow = conductance * (field.pressure[a] - field.pressure[b]);
    let by_ease = flow / (liquid.ease[a] + liquid.ease[b]);
    ends.map(|cell| full[cell] * by_ease * liquid.easing[cell])
}

impl Linear {
    /// Adds it to the matrix.
    pub(super) fn thicken(
        &mut self,
        cells: &Cells,
        liquid: &Liquid,
        field: &Field,
        balance: &Balance,
        stage: &Stage<'_>,
    ) {
        let ring = &mut self.ring;
        for (own, before) in cells.neighbours() {
            for (own, before) in own.zip(before) {
                let ends = [before, own];
                let gains = gains(balance.along[own], ends, &self.full, liquid, field);
                let rows = ends.map(|cell| self.balanced[cell]);
                ring.own[before] += rows[0] * gains[0];
                ring.after[before] += rows[0] * gains[1];
                ring.before[own] -= rows[1] * gains[0];
                ring.own[own] -= rows[1] * gains[1];
            }
        }
        for own in 1..cells.count() {
            let below = own - 1;
            let ends = [below, own];
            let gains = gains(balance.across[own], ends, &self.full, liquid, field);
            let rows = ends.map(|cell| self.balanced[cell]);
            ring.own[below] += rows[0] * gains[0];
            ring.above[below] += rows[0] * gains[1];
            ring.below[own] -= rows[1] * gains[0];
            ring.own[own] -= rows[1] * gains[1];
        }
        for cell in 0..cells.count() {
            let flow = balance.open[cell] * (field.pressure[cell] - stage.side);
            ring.own[cell] += self.full[cell] * flow * liquid.easing[cell] / liquid.ease[cell];
        }
    }
}
