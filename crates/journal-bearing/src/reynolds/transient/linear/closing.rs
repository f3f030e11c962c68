//! Derivatives of the residuals over the eccentricity ratio, as the journal closes or opens the gap.

use super::super::base::Base;
use super::super::sweeps::{add_difference, scale};

/// The fluxes' derivatives over the gap at the edges, and buffers for them.
#[derive(Clone, Debug)]
pub struct Closing {
    /// At the edge before each cell.
    around: Vec<f64>,
    /// At the edge below each cell; one more at the end, zero.
    over: Vec<f64>,
    /// The derivative of a cell's own balance over its gap.
    kept: Vec<f64>,
}

impl Closing {
    /// For a number of cells.
    pub fn new(cells: usize) -> Self {
        Self {
            around: vec![0.0; cells],
            over: vec![0.0; cells + 1],
            kept: vec![0.0; cells],
        }
    }

    /// A buffer of one value per cell that is free between calls.
    pub fn scratch(&mut self) -> &mut [f64] {
        &mut self.around
    }

    /// Computes the derivatives of the balances marked in `balanced` over the components of the eccentricity ratio.
    pub fn differentiate(
        &mut self,
        base: &Base<'_>,
        balanced: &[f64],
        derivatives: &mut [Vec<f64>; 2],
    ) {
        self.open_edges(base);
        let Base {
            cells,
            gap,
            field,
            balance,
            stage,
            ..
        } = *base;
        let p = &field.pressure;
        for (after, own) in cells.neighbours() {
            let kept = &mut self.kept[own.clone()];
            let rate = 1.0 / stage.duration;
            store(
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
            for (derivative, normal) in derivatives.iter_mut().zip(directions) {
                let edges = [&normal.edge[own.clone()], &normal.edge[after.clone()]];
                let derivative = &mut derivative[own.clone()];
                close(derivative, [&normal.mean[own.clone()], kept], edges, around);
                scale(derivative, &balanced[own.clone()]);
            }
        }
    }

    /// Computes the fluxes' derivatives over the gap at their edges.
    fn open_edges(&mut self, base: &Base<'_>) {
        let (gap, balance) = (base.gap, base.balance);
        let pressure = &base.field.pressure;
        for (own, before) in base.cells.neighbours() {
            let through = [&balance.along[own.clone()], &balance.carried[own.clone()]];
            let p = [&pressure[before.clone()], &pressure[own.clone()]];
            let fill = [&balance.fill[before], &balance.fill[own.clone()]];
            let h = [&gap.edge[own.clone()], &gap.edge_apart[own.clone()]];
            open_edge(&mut self.around[own], through, p, fill, h);
        }
        let n = pressure.len();
        let (low, high) = (..n - 1, 1..n);
        let [p, h, apart] =
            [pressure, &gap.cell, &gap.cell_apart].map(|of| [&of[low], &of[high.clone()]]);
        open_row(&mut self.over[1..n], &balance.across[1..n], p, h, apart);
    }
}

// The sweeps below follow the rule of `sweeps`: each writes to a single array.

/// Storage per unit of gap.
fn store(kept: &mut [f64], rate: f64, area: &[f64], fill: &[f64]) {
    let n = kept.len();
    let (area, fill) = (&area[..n], &fill[..n]);
    for k in 0..n {
        kept[k] = rate * area[k] * fill[k];
    }
}

/// Adds the flux out of the open ends per unit of gap.
fn open_end(kept: &mut [f64], out: [&[f64]; 3], side: f64) {
    let n = kept.len();
    let [open, p, h] = out.map(|o| &o[..n]);
    for k in 0..n {
        kept[k] += 3.0 * open[k] * (p[k] - side) / h[k];
    }
}

/// A component of the eccentricity closes the cell and its edges by the component of their normals.
fn close(derivative: &mut [f64], own: [&[f64]; 2], normal: [&[f64]; 2], around: [&[f64]; 2]) {
    let n = derivative.len();
    let (own, normal) = (own.map(|o| &o[..n]), normal.map(|n_| &n_[..n]));
    let around = around.map(|a| &a[..n]);
    for k in 0..n {
        derivative[k] =
            normal[0][k] * around[0][k] - normal[1][k] * around[1][k] - own[0][k] * own[1][k];
    }
}

/// The derivative of the flux between columns.
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

/// The derivative of the flux between rows.
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
