//! Derivatives of the residuals over the eccentricity ratio, as the journal closes or opens the gap.

use super::super::sweeps::{add_difference, change, fill};
use super::LinearisedFilm;

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
        Self { around: vec![0.0; cells], over: vec![0.0; cells + 1], kept: vec![0.0; cells] }
    }

    /// A buffer of one value per cell that is free between calls.
    pub fn scratch(&mut self) -> &mut [f64] {
        &mut self.around
    }

    /// Computes the derivatives of the balances marked in `balanced` over the components of the eccentricity ratio.
    pub fn differentiate(&mut self, base: &LinearisedFilm, balanced: &[f64], derivatives: &mut [Vec<f64>; 2]) {
        self.open_edges(base);
        let LinearisedFilm { cells, gap, field, balance, stage, .. } = *base;
        let (rate, [flow, _]) = (1.0 / stage.duration, gap.flow());
        for (after, here) in cells.neighbours() {
            // Storage, and the flux out of the open ends, per unit of gap.
            let kept = &mut self.kept[here.clone()];
            let [area, oil] = [&cells.area, &balance.fill].map(|of| &of[here.clone()]);
            let apart = &gap.cell_apart[here.clone()];
            fill(kept, [area, oil, apart], |[area, oil, apart]| rate * area * oil * apart);
            let out = [&balance.open, &field.pressure, flow, &gap.cell_flow_apart];
            let out = out.map(|of| &of[here.clone()]);
            change(kept, out, |kept, [open, p, flow, apart]| kept + 3.0 * open * (p - stage.side) * apart / flow);
            let over = &self.over[here.start..=here.end];
            add_difference(kept, [over, &over[1..]]);
            let around = [here.clone(), after.clone()].map(|of| &self.around[of]);
            for (derivative, normal) in derivatives.iter_mut().zip(&cells.normal) {
                // The eccentricity closes the cell and its edges by the components of their normals.
                let derivative = &mut derivative[here.clone()];
                let mean = &normal.mean[here.clone()];
                let edges = [here.clone(), after.clone()].map(|of| &normal.edge[of]);
                let of = [edges[0], around[0], edges[1], around[1], mean, kept];
                fill(derivative, of, |[before, enters, after, leaves, mean, kept]| {
                    before * enters - after * leaves - mean * kept
                });
                change(derivative, [&balanced[here.clone()]], product);
            }
        }
    }

    /// Computes the fluxes' derivatives over the gap at their edges.
    fn open_edges(&mut self, base: &LinearisedFilm) {
        let (gap, balance) = (base.gap, base.balance);
        let (pressure, [cell_flow, flow]) = (&base.field.pressure[..], gap.flow());
        for (behind, before) in base.cells.neighbours() {
            let [along, carried, h, apart] =
                [&balance.along, &balance.carried, &gap.edge, &gap.edge_apart].map(|of| &of[behind.clone()]);
            let p = [before.clone(), behind.clone()].map(|of| &pressure[of]);
            let oil = [before, behind.clone()].map(|of| &balance.fill[of]);
            let around = &mut self.around[behind.clone()];
            if !gap.rough {
                let of = [along, carried, p[0], p[1], oil[0], oil[1], h];
                fill(around, of, |[along, carried, p_before, p, before, behind, h]| {
                    let oil = if carried > 0.0 { before } else { behind };
                    (carried * oil + 3.0 * along * (p_before - p)) / h
                });
                continue;
            }
            let of = [carried, oil[0], oil[1], h, apart];
            fill(around, of, |[carried, before, behind, h, apart]| {
                let oil = if carried > 0.0 { before } else { behind };
                carried * oil * apart / h
            });
            let [flow, widens] = [flow, &gap.edge_flow_apart].map(|of| &of[behind.clone()]);
            let of = [along, p[0], p[1], flow, widens];
            change(around, of, |around, [along, p_before, p, flow, widens]| {
                around + 3.0 * along * (p_before - p) * widens / flow
            });
        }
        let n = pressure.len();
        let (low, high) = (..n - 1, 1..n);
        let [p, h, apart] = [pressure, cell_flow, &gap.cell_flow_apart].map(|of| [&of[low], &of[high.clone()]]);
        let across = &balance.across[1..n];
        let of = [across, p[0], p[1], h[0], h[1], apart[0], apart[1]];
        fill(&mut self.over[1..n], of, |[across, p_below, p, below, above, apart_below, apart]| {
            let opening = (apart_below + apart) / (below + above);
            3.0 * across * (p_below - p) * opening
        });
    }
}

fn product(value: f64, [by]: [f64; 1]) -> f64 {
    value * by
}
