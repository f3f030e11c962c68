//! Density at the edges between columns: the mean of both sides, times the content upstream.
//!
//! The balance takes density and content from upstream, which is first order in the cell's size. For the density of a full
//! film that would lose much of its effect on the pressure. The correction here makes the density second order; it has no
//! jump where a cell fills or ruptures.

use super::{cells::Cells, liquid::Liquid, state::Field};

/// An edge over which the surfaces carry oil.
pub struct Edge {
    pub upstream: usize,
    pub downstream: usize,
    /// Half of the flux that the surfaces carry.
    pub half: f64,
}

impl Edge {
    /// The edge between the cells `before` and `behind`; `carried` is positive from the first to the second.
    pub fn new(before: usize, behind: usize, carried: f64) -> Self {
        let (upstream, downstream) = if carried > 0.0 { (before, behind) } else { (behind, before) };
        Self { upstream, downstream, half: 0.5 * carried.abs() }
    }
}

/// All edges between columns, as the cells before and after them.
pub fn edges(cells: &Cells) -> impl Iterator<Item = (usize, usize)> {
    let pairs = cells.neighbours().into_iter();
    pairs.flat_map(|(behind, before)| before.zip(behind))
}

/// Corrects the flux over each edge.
pub fn centre(around: &mut [f64], carried: &[f64], cells: &Cells, liquid: &Liquid, field: &Field) {
    for (before, behind) in edges(cells) {
        let edge = Edge::new(before, behind, carried[behind]);
        let difference = liquid.density[edge.downstream] - liquid.density[edge.upstream];
        let more = edge.half * field.content[edge.upstream] * difference;
        around[behind] += if edge.upstream == before { more } else { -more };
    }
}
