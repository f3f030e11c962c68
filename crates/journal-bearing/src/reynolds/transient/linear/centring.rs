//! The second-order density of [`upwind`](crate::reynolds::transient::upwind) in the matrix.

use super::super::upwind::{Edge, edges};
use super::{LinearisedFilm, unknowns::Unknowns};
use crate::reynolds::ring::Ring;

/// Adds the derivatives of the flux corrections to the matrix.
pub fn centre(ring: &mut Ring, unknowns: &Unknowns, base: &LinearisedFilm) {
    let (liquid, field) = (base.liquid, base.field);
    for (before, behind) in edges(base.cells) {
        let edge = Edge::new(before, behind, base.balance.carried[behind]);
        let (up, down) = (edge.upstream, edge.downstream);
        // Derivatives of the downstream flow over the unknowns of both cells.
        let by_up =
            unknowns.empty[up] * (liquid.density[down] - liquid.density[up]) - unknowns.full[up] * liquid.swelling[up];
        let by_down = unknowns.full[down] * field.content[up] * liquid.swelling[down];
        let [by_up, by_down] = [by_up, by_down].map(|by| edge.half * by);
        let (to_down, to_up) = if up == before {
            (&mut ring.before[behind], &mut ring.after[before])
        } else {
            (&mut ring.after[before], &mut ring.before[behind])
        };
        *to_down -= unknowns.balanced[down] * by_up;
        *to_up += unknowns.balanced[up] * by_down;
        ring.diagonal[down] -= unknowns.balanced[down] * by_down;
        ring.diagonal[up] += unknowns.balanced[up] * by_up;
    }
}
