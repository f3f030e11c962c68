//! The matrix of the linearised balances.

use super::super::base::Base;
use super::ring::Ring;
use super::unknowns::Unknowns;

/// Fills the matrix. `held` is scratch space of one value per cell.
pub fn assemble(ring: &mut Ring, unknowns: &Unknowns, held: &mut [f64], base: &Base<'_>) {
    let Base {
        cells,
        gap,
        balance,
        stage,
        ..
    } = *base;
    let (full, empty) = (&unknowns.full, &unknowns.empty);
    let (swell, balanced) = (&unknowns.swell, &unknowns.balanced);
    for (after, own) in cells.neighbours() {
        // The edges before and after the cells.
        let along = [&balance.along[own.clone()], &balance.along[after.clone()]];
        let carried = [
            &balance.carried[own.clone()],
            &balance.carried[after.clone()],
        ];
        let across = &balance.across[own.start..=own.end];
        let diagonal = &mut ring.own[own.clone()];
        leak(
            diagonal,
            along,
            [across, &across[1..]],
            &balance.open[own.clone()],
        );
        let held = &mut held[own.clone()];
        let rate = 1.0 / stage.duration;
        hold(
            held,
            rate,
            &cells.area[own.clone()],
            &gap.cell[own.clone()],
            carried,
        );
        let [full_own, empty_own] = [full, empty].map(|of| &of[own.clone()]);
        choose(diagonal, full_own, empty_own, [held, &swell[own.clone()]]);

        let through = [along[1], carried[1]];
        let kind = [full, swell];
        let from = kind.map(|of| &of[own.clone()]);
        let row = &balanced[after.clone()];
        couple::<true>(&mut ring.before[after.clone()], row, from, through);
        let from = kind.map(|of| &of[after.clone()]);
        let row = &balanced[own.clone()];
        couple::<false>(&mut ring.after[own], row, from, through);
    }
    let n = full.len();
    let across = &balance.across[1..n];
    let (low, high) = (..n - 1, 1..n);
    let below = &mut ring.below[high.clone()];
    pass(below, &balanced[high.clone()], &full[low], across);
    let above = &mut ring.above[low];
    pass(above, &balanced[low], &full[high], across);
}

// The sweeps below follow the rule of `sweeps`: each writes to a single array.

/// Conductance out of a cell in all directions.
fn leak(diagonal: &mut [f64], along: [&[f64]; 2], across: [&[f64]; 2], open: &[f64]) {
    let n = diagonal.len();
    let (along, across, open) = (along.map(|a| &a[..n]), across.map(|a| &a[..n]), &open[..n]);
    for k in 0..n {
        diagonal[k] = (along[0][k] + along[1][k]) + (across[0][k] + across[1][k]) + open[k];
    }
}

/// Storage and outward transport per unit of the oil in a cell's gap.
fn hold(held: &mut [f64], rate: f64, area: &[f64], gap: &[f64], carried: [&[f64]; 2]) {
    let n = held.len();
    let (area, gap, carried) = (&area[..n], &gap[..n], carried.map(|c| &c[..n]));
    for k in 0..n {
        let leaving = positive(carried[1][k]) + positive(-carried[0][k]);
        held[k] = area[k] * rate * gap[k] + leaving;
    }
}

/// The diagonal entry by the kind of the cell's unknown; one for cells without an unknown.
fn choose(diagonal: &mut [f64], full: &[f64], empty: &[f64], held: [&[f64]; 2]) {
    let n = diagonal.len();
    let (full, empty, held) = (&full[..n], &empty[..n], held.map(|h| &h[..n]));
    for k in 0..n {
        let idle = 1.0 - (full[k] + empty[k]);
        diagonal[k] = full[k] * diagonal[k] + held[0][k] * held[1][k] + idle;
    }
}

/// The entry of the neighbouring column, the one before or the one after: flow by its pressure, and transport by the
/// rotation as its oil grows.
fn couple<const BEFORE: bool>(
    coupling: &mut [f64],
    balanced: &[f64],
    from: [&[f64]; 2],
    through: [&[f64]; 2],
) {
    let n = coupling.len();
    let ([full, swell], [along, carried]) = (from.map(|f| &f[..n]), through.map(|t| &t[..n]));
    let balanced = &balanced[..n];
    for k in 0..n {
        let carried = positive(if BEFORE { carried[k] } else { -carried[k] });
        coupling[k] = -balanced[k] * (full[k] * along[k] + swell[k] * carried);
    }
}

/// The entry of the neighbouring row: flow by its pressure.
fn pass(coupling: &mut [f64], balanced: &[f64], full: &[f64], across: &[f64]) {
    let n = coupling.len();
    let (balanced, full, across) = (&balanced[..n], &full[..n], &across[..n]);
    for k in 0..n {
        coupling[k] = -balanced[k] * full[k] * across[k];
    }
}

/// The positive part of a value.
fn positive(value: f64) -> f64 {
    if value > 0.0 { value } else { 0.0 }
}
