//! The matrix of the linearised balances and its right-hand sides.

use super::balance::{Balance, Stage};
use super::cells::Cells;
use super::field::Field;
use super::gap::Gap;
use super::linear::Linear;

impl Linear {
    /// Fills the matrix.
    pub(super) fn assemble(
        &mut self,
        cells: &Cells,
        gap: &Gap,
        balance: &Balance,
        stage: &Stage<'_>,
    ) {
        for (after, own) in cells.neighbours() {
            // The edges before and after the cells.
            let along = [&balance.along[own.clone()], &balance.along[after.clone()]];
            let carried = [
                &balance.carried[own.clone()],
                &balance.carried[after.clone()],
            ];
            let across = &balance.across[own.start..=own.end];
            let diagonal = &mut self.ring.own[own.clone()];
            leak(
                diagonal,
                along,
                [across, &across[1..]],
                &balance.open[own.clone()],
            );
            let held = &mut self.around[own.clone()];
            let rate = 1.0 / stage.duration;
            hold(
                held,
                rate,
                &cells.area[own.clone()],
                &gap.cell[own.clone()],
                carried,
            );
            let [full, empty] = [&self.full, &self.empty].map(|of| &of[own.clone()]);
            choose(diagonal, full, empty, [held, &self.swell[own.clone()]]);

            let through = [along[1], carried[1]];
            let kind = [&self.full, &self.swell];
            let from = kind.map(|of| &of[own.clone()]);
            let row = &self.balanced[after.clone()];
            couple::<true>(&mut self.ring.before[after.clone()], row, from, through);
            let from = kind.map(|of| &of[after.clone()]);
            let row = &self.balanced[own.clone()];
            couple::<false>(&mut self.ring.after[own], row, from, through);
        }
        let n = self.full.len();
        let across = &balance.across[1..n];
        let (low, high) = (..n - 1, 1..n);
        let below = &mut self.ring.below[high.clone()];
        pass(below, &self.balanced[high.clone()], &self.full[low], across);
        let above = &mut self.ring.above[low];
        pass(above, &self.balanced[low], &self.full[high], across);
    }

    /// The derivatives of the residuals over the eccentricity ratio: what each edge, and each cell, does with one more
    /// unit of gap, times how the eccentricity closes it.
    pub(super) fn slide(
        &mut self,
        cells: &Cells,
        gap: &Gap,
        field: &Field,
        balance: &Balance,
        stage: &Stage<'_>,
    ) {
        self.open_edges(cells, gap, field, balance);
        let p = &field.pressure;
        for (after, own) in cells.neighbours() {
            let kept = &mut self.step[own.clone()];
            let rate = 1.0 / stage.duration;
            multiply(
                kept,
                rate,
                &cells.area[own.clone()],
                &balance.fill[own.clone()],
            );
            let out = [&balance.open, p, &gap.cell].map(|of| &of[own.clone()]);
            open_end(kept, out, stage.side);
            scale(kept, &gap.cell_apart[own.clone()]);
            let over = &self.over[own.start..=own.end];
            add_difference(kept, [over, &over[1..]]);
            let around = [&self.around[own.clone()], &self.around[after.clone()]];
            let directions = [&cells.normal_x, &cells.normal_y];
            for (answer, normal) in self.answer.iter_mut().zip(directions) {
                let edges = [&normal.edge[own.clone()], &normal.edge[after.clone()]];
                let answer = &mut answer[own.clone()];
                turn(answer, [&normal.mean[own.clone()], kept], edges, around);
                scale(answer, &self.balanced[own.clone()]);
            }
        }
    }

    /// What one more unit of gap at each edge lets through.
    fn open_edges(&mut self, cells: &Cells, gap: &Gap, field: &Field, balance: &Balance) {
        for (own, before) in cells.neighbours() {
            let through = [&balance.along[own.clone()], &balance.carried[own.clone()]];
            let p = [
                &field.pressure[before.clone()],
                &field.pressure[own.clone()],
            ];
            let fill = [&balance.fill[before], &balance.fill[own.clone()]];
            let h = [&gap.edge[own.clone()], &gap.edge_apart[own.clone()]];
            open_edge(&mut self.around[own], through, p, fill, h);
        }
        let n = field.pressure.len();
        let (low, high) = (..n - 1, 1..n);
        let [p, h, apart] =
            [&field.pressure, &gap.cell, &gap.cell_apart].map(|of| [&of[low], &of[high.clone()]]);
        open_row(&mut self.over[1..n], &balance.across[1..n], p, h, apart);
    }
}

// The sweeps below each write to one array, which the compiler therefore knows to be apart from all that they read.

/// What pressure drives out of a cell.
fn leak(diagonal: &mut [f64], along: [&[f64]; 2], across: [&[f64]; 2], open: &[f64]) {
    let n = diagonal.len();
    let (along, across, open) = (along.map(|a| &a[..n]), across.map(|a| &a[..n]), &open[..n]);
    for k in 0..n {
        diagonal[k] = (along[0][k] + along[1][k]) + (across[0][k] + across[1][k]) + open[k];
    }
}

/// What is stored and carried out of a cell as its oil grows.
fn hold(held: &mut [f64], rate: f64, area: &[f64], gap: &[f64], carried: [&[f64]; 2]) {
    let n = held.len();
    let (area, gap, carried) = (&area[..n], &gap[..n], carried.map(|c| &c[..n]));
    for k in 0..n {
        let leaving = positive(carried[1][k]) + positive(-carried[0][k]);
        held[k] = area[k] * rate * gap[k] + leaving;
    }
}

/// The diagonal by what the cell's unknown does; one where it has none.
fn choose(diagonal: &mut [f64], full: &[f64], empty: &[f64], held: [&[f64]; 2]) {
    let n = diagonal.len();
    let (full, empty, held) = (&full[..n], &empty[..n], held.map(|h| &h[..n]));
    for k in 0..n {
        let idle = 1.0 - (full[k] + empty[k]);
        diagonal[k] = full[k] * diagonal[k] + held[0][k] * held[1][k] + idle;
    }
}

/// What comes from a neighbouring column, the one before or the one after: by its pressure, and by the rotation as its
/// oil grows.
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

/// What comes from a neighbouring row.
fn pass(coupling: &mut [f64], balanced: &[f64], full: &[f64], across: &[f64]) {
    let n = coupling.len();
    let (balanced, full, across) = (&balanced[..n], &full[..n], &across[..n]);
    for k in 0..n {
        coupling[k] = -balanced[k] * full[k] * across[k];
    }
}

fn multiply(product: &mut [f64], factor: f64, a: &[f64], b: &[f64]) {
    let n = product.len();
    let (a, b) = (&a[..n], &b[..n]);
    for k in 0..n {
        product[k] = factor * a[k] * b[k];
    }
}

fn scale(values: &mut [f64], by: &[f64]) {
    for (value, by) in values.iter_mut().zip(by) {
        *value *= by;
    }
}

/// Adds what one more unit of gap lets out through the open ends.
fn open_end(kept: &mut [f64], out: [&[f64]; 3], side: f64) {
    let n = kept.len();
    let [open, p, h] = out.map(|o| &o[..n]);
    for k in 0..n {
        kept[k] += 3.0 * open[k] * (p[k] - side) / h[k];
    }
}

fn add_difference(flux: &mut [f64], through: [&[f64]; 2]) {
    let n = flux.len();
    let through = through.map(|t| &t[..n]);
    for k in 0..n {
        flux[k] += through[1][k] - through[0][k];
    }
}

/// What a component of the eccentricity does, that closes the cell and its edges by their normals.
fn turn(answer: &mut [f64], own: [&[f64]; 2], normal: [&[f64]; 2], around: [&[f64]; 2]) {
    let n = answer.len();
    let (own, normal) = (own.map(|o| &o[..n]), normal.map(|n_| &n_[..n]));
    let around = around.map(|a| &a[..n]);
    for k in 0..n {
        answer[k] =
            normal[0][k] * around[0][k] - normal[1][k] * around[1][k] - own[0][k] * own[1][k];
    }
}

fn open_edge(
    around: &mut [f64],
    through: [&[f64]; 2],
    p: [&[f64]; 2],
    fill: [&[f64]; 2],
    h: [&[f64]; 2],
) {
    let n = around.len();
    let (p, fill) = (p.map(|p| &p[..n]), fill.map(|f| &f[..n]));
    let ([along, carried], [h, apart]) = (through.map(|t| &t[..n]), h.map(|h| &h[..n]));
    for k in 0..n {
        let (before, own) = (fill[0][k], fill[1][k]);
        let fill = if carried[k] > 0.0 { before } else { own };
        let flux = carried[k] * fill + 3.0 * along[k] * (p[0][k] - p[1][k]);
        around[k] = flux * apart[k] / h[k];
    }
}

fn open_row(over: &mut [f64], across: &[f64], p: [&[f64]; 2], h: [&[f64]; 2], apart: [&[f64]; 2]) {
    let n = over.len();
    let (p, h, apart) = (
        p.map(|p| &p[..n]),
        h.map(|h| &h[..n]),
        apart.map(|a| &a[..n]),
    );
    let across = &across[..n];
    for k in 0..n {
        let opening = (apart[0][k] + apart[1][k]) / (h[0][k] + h[1][k]);
        over[k] = 3.0 * across[k] * (p[0][k] - p[1][k]) * opening;
    }
}

/// The value where it is positive, else zero.
fn positive(value: f64) -> f64 {
    if value > 0.0 { value } else { 0.0 }
}
