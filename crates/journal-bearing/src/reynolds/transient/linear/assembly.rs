//! The matrix of the linearised balances.

use super::super::sweeps::{change, fill};
use super::{LinearisedFilm, unknowns::Unknowns};
use crate::reynolds::ring::Ring;

/// Fills the matrix. `held` is scratch space of one value per cell.
pub fn assemble(ring: &mut Ring, unknowns: &Unknowns, held: &mut [f64], base: &LinearisedFilm) {
    let LinearisedFilm { cells, gap, balance, stage, .. } = *base;
    let (full, empty) = (&unknowns.full, &unknowns.empty);
    let (swell, balanced) = (&unknowns.swell, &unknowns.balanced);
    let rate = 1.0 / stage.duration;
    for (after, here) in cells.neighbours() {
        // The edges before and after the cells.
        let along = [here.clone(), after.clone()].map(|of| &balance.along[of]);
        let carried = [here.clone(), after.clone()].map(|of| &balance.carried[of]);
        let across = &balance.across[here.start..=here.end];
        // Conductance out of a cell in all directions.
        let diagonal = &mut ring.diagonal[here.clone()];
        let open = &balance.open[here.clone()];
        let edges = [along[0], along[1], across, &across[1..], open];
        fill(diagonal, edges, |[before, after, below, above, open]| (before + after) + (below + above) + open);
        if !cells.feed.is_empty() {
            change(diagonal, [&cells.feed[here.clone()]], |leak, [feed]| leak + feed);
        }
        // Storage and outward transport per unit of the oil in a cell's gap.
        let held = &mut held[here.clone()];
        let [area, h] = [&cells.area, &gap.cell].map(|of| &of[here.clone()]);
        let of = [area, h, carried[0], carried[1]];
        fill(held, of, |[area, h, before, after]| area * rate * h + (positive(after) + positive(-before)));
        // By the kind of the cell's unknown; one for cells without an unknown.
        let kind = [full, empty, swell].map(|of| &of[here.clone()]);
        let of = [kind[0], kind[1], held, kind[2]];
        change(diagonal, of, |leak, [full, empty, held, swell]| full * leak + held * swell + (1.0 - (full + empty)));
        // The neighbouring columns: flow by their pressure, and transport by the rotation as their oil grows.
        let couple =
            |[balanced, full, swell, along, carried]: [f64; 5]| -balanced * (full * along + swell * positive(carried));
        let row = &balanced[after.clone()];
        let from = [row, kind[0], kind[2], along[1], carried[1]];
        fill(&mut ring.before[after.clone()], from, couple);
        let [full, swell] = [full, swell].map(|of| &of[after.clone()]);
        let from = [&balanced[here.clone()], full, swell, along[1], carried[1]];
        fill(&mut ring.after[here], from, |[balanced, full, swell, along, carried]| {
            couple([balanced, full, swell, along, -carried])
        });
    }
    // The neighbouring rows: flow by their pressure.
    let n = full.len();
    let across = &balance.across[1..n];
    let (low, high) = (..n - 1, 1..n);
    let pass = |[balanced, full, across]: [f64; 3]| -balanced * full * across;
    let below = [&balanced[high.clone()], &full[low], across];
    fill(&mut ring.below[high.clone()], below, pass);
    let above = [&balanced[low], &full[high], across];
    fill(&mut ring.above[low], above, pass);
}

/// The positive part of a value.
fn positive(value: f64) -> f64 {
    if value > 0.0 { value } else { 0.0 }
}
