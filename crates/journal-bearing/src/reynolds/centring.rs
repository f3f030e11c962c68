//! Density at the edges between columns: the mean of both sides, times the content upstream.
//!
//! Content comes from upstream, first order in the cell's size; for the density of a full film that would cost a good
//! part of the effect that it has on the pressure. What is added here to the flux over an edge and to its derivatives
//! makes it second order. It has no jump where a cell fills or ruptures.

use super::balance::Balance;
use super::cells::Cells;
use super::field::Field;
use super::linear::Linear;
use super::liquid::Liquid;

/// An edge over which oil is carried.
struct Edge {
    upstream: usize,
    downstream: usize,
    /// Half of what the surfaces carry.
    half: f64,
}

impl Edge {
    fn new(before: usize, own: usize, carried: f64) -> Self {
        let (upstream, downstream) = if carried > 0.0 {
            (before, own)
        } else {
            (own, before)
        };
        Self {
            upstream,
            downstream,
            half: 0.5 * carried.abs(),
        }
    }
}

/// The edges as the cells before and after.
fn edges(cells: &Cells) -> impl Iterator<Item = (usize, usize)> {
    let pairs = cells.neighbours().into_iter();
    pairs.flat_map(|(own, before)| before.zip(own))
}

impl Balance {
    /// Adds to the flux over each edge.
    pub(super) fn centre(&mut self, cells: &Cells, liquid: &Liquid, field: &Field) {
        for (before, own) in edges(cells) {
            let edge = Edge::new(before, own, self.carried[own]);
            let difference = liquid.density[edge.downstream] - liquid.density[edge.upstream];
            let more = edge.half * field.content[edge.upstream] * difference;
            self.around[own] += if edge.upstream == before { more } else { -more };
        }
    }
}

impl Linear {
    /// Adds to the matrix.
    pub(super) fn centre(
        &mut self,
        cells: &Cells,
        liquid: &Liquid,
        field: &Field,
        balance: &Balance,
    ) {
        for (before, own) in edges(cells) {
            let edge = Edge::new(before, own, balance.carried[own]);
            let (up, down) = (edge.upstream, edge.downstream);
            // The flow downstream over the unknowns of both cells.
            let by_up = self.empty[up] * (liquid.density[down] - liquid.density[up])
                - self.full[up] * liquid.swelling[up];
            let by_down = self.full[down] * field.content[up] * liquid.swelling[down];
            let [by_up, by_down] = [by_up, by_down].map(|by| edge.half * by);
            let (to_down, to_up) = if up == before {
                (&mut self.ring.before[own], &mut self.ring.after[before])
            } else {
                (&mut self.ring.after[before], &mut self.ring.before[own])
            };
            *to_down -= self.balanced[down] * by_up;
            *to_up += self.balanced[up] * by_down;
            self.ring.own[down] -= self.balanced[down] * by_down;
            self.ring.own[up] += self.balanced[up] * by_up;
        }
    }
}
