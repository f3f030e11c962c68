//! The film's mass balance, cell by cell.
//!
//! A cell has the area `V`, the mass `m = rho theta H` per area (density relative to that at ambient pressure, content
//! `theta` in 0..1) and the pressure `P` above that of the cavities. Its balance is
//!
//! ```text
//! V (m - m_start) / dt + [omega H theta rho]_upstream + sum G (P - P_neighbour) = 0
//! P >= 0,  theta <= 1,  P (1 - theta) = 0
//! ```
//!
//! (Jakobsson & Floberg 1957, Olsson 1965; the complementarity as in Woloszynski, Podsiadlo & Stachowiak 2015, Tribol.
//! Lett. 58). In a full film the flux at an edge uses the gap at that edge, which is second order in the cell's size. The
//! content comes wholly from upstream, which is first order.
//!
//! Every flux is computed once, at its edge, and leaves one cell as it enters the next. The sum of the residuals is
//! therefore the mass error of the whole film.

use super::cells::Cells;
use super::gap::Gap;
use super::lanes::{dot, dot_of_sizes, sum, sum_of_sizes};
use super::liquid::Liquid;
use super::stage::Stage;
use super::state::Field;
use super::sweeps::{add, add_difference, multiply};
use super::upwind;
use crate::reynolds::roughness::shear_flow_factor;

/// Conductances, fluxes and residuals at one gap and field.
#[derive(Clone, Debug)]
pub struct Balance {
    /// Conductance of the edge to the column before each cell.
    pub along: Vec<f64>,
    /// Conductance of the edge to the row below each cell; one more at the end, zero.
    pub across: Vec<f64>,
    /// Conductance of each cell to the open ends.
    pub open: Vec<f64>,
    /// Flux that the surfaces carry over the edge before each cell when the cell upstream is full.
    pub carried: Vec<f64>,
    /// Density times content in each cell.
    pub fill: Vec<f64>,
    /// Mass per area in each cell.
    pub mass: Vec<f64>,
    /// Flux over the edge before each cell, in the direction of `theta`.
    around: Vec<f64>,
    /// Flux from the row below into each cell; one more at the end, zero.
    over: Vec<f64>,
    /// Flux out of each cell through the open ends.
    out: Vec<f64>,
    /// Error of each cell's balance, as a flux out of the cell.
    pub residual: Vec<f64>,
}

impl Balance {
    /// All zeros.
    pub fn new(cells: usize) -> Self {
        let zeros = || vec![0.0; cells];
        Self {
            along: zeros(),
            across: vec![0.0; cells + 1],
            open: zeros(),
            carried: zeros(),
            fill: zeros(),
            mass: zeros(),
            around: zeros(),
            over: vec![0.0; cells + 1],
            out: zeros(),
            residual: zeros(),
        }
    }

    /// Computes everything at the present gap, oil and field.
    pub fn update(
        &mut self,
        cells: &Cells,
        gap: &Gap,
        liquid: &Liquid,
        field: &Field,
        stage: &Stage<'_>,
    ) {
        self.weigh(gap, liquid, field);
        self.flow_around(cells, gap, liquid, field, stage);
        if liquid.compressible {
            upwind::centre(&mut self.around, &self.carried, cells, liquid, field);
        }
        self.flow_over(cells, gap, liquid, field, stage);
        self.add_up(cells, stage);
    }

    /// Computes the mass in each cell.
    pub fn weigh(&mut self, gap: &Gap, liquid: &Liquid, field: &Field) {
        multiply(&mut self.fill, &liquid.density, &field.content);
        multiply(&mut self.mass, &self.fill, &gap.cell);
    }

    /// Computes conductances `rho H^3 / mu` and fluxes between columns.
    fn flow_around(
        &mut self,
        cells: &Cells,
        gap: &Gap,
        liquid: &Liquid,
        field: &Field,
        stage: &Stage<'_>,
    ) {
        for (own, before) in cells.neighbours() {
            let along = &mut self.along[own.clone()];
            conduct(along, &cells.along[own.clone()], &gap.edge[own.clone()]);
            if !liquid.uniform {
                let both = [&liquid.ease[before.clone()], &liquid.ease[own.clone()]];
                ease(along, both);
            }
            carry(
                &mut self.carried[own.clone()],
                stage.rotation,
                &cells.share[own.clone()],
                &gap.edge[own.clone()],
            );
            if stage.shear != 0.0 {
                let carried = &mut self.carried[own.clone()];
                let edges = gap.edge_ratio[own.clone()]
                    .iter()
                    .zip(&cells.share[own.clone()]);
                for (carried, (&ratio, share)) in carried.iter_mut().zip(edges) {
                    *carried += stage.shear * share * shear_flow_factor(ratio);
                }
            }
            flow(
                &mut self.around[own.clone()],
                &self.along[own.clone()],
                [
                    &field.pressure[before.clone()],
                    &field.pressure[own.clone()],
                ],
            );
            add_carried(
                &mut self.around[own.clone()],
                &self.carried[own.clone()],
                [&self.fill[before.clone()], &self.fill[own.clone()]],
            );
        }
    }

    /// Computes conductances and fluxes between rows and through the open ends.
    fn flow_over(
        &mut self,
        cells: &Cells,
        gap: &Gap,
        liquid: &Liquid,
        field: &Field,
        stage: &Stage<'_>,
    ) {
        let n = self.mass.len();
        let (h, p) = (&gap.cell[..], &field.pressure[..]);
        let (below, above) = (..n - 1, 1..n);
        let across = &mut self.across[1..n];
        let both = [&h[below], &h[above.clone()]];
        conduct_between(across, &cells.across[1..n], both);
        conduct(&mut self.open, &cells.open, h);
        if !liquid.uniform {
            let of = &liquid.ease[..];
            ease(across, [&of[below], &of[above.clone()]]);
            ease(&mut self.open, [of; 2]);
        }
        flow(
            &mut self.over[1..n],
            &self.across[1..n],
            [&p[below], &p[above]],
        );
        flow_out(&mut self.out, &self.open, p, stage.side);
    }

    /// Adds up the residuals.
    fn add_up(&mut self, cells: &Cells, stage: &Stage<'_>) {
        for (after, own) in cells.neighbours() {
            let residual = &mut self.residual[own.clone()];
            store(
                residual,
                1.0 / stage.duration,
                &cells.area[own.clone()],
                [&stage.mass[own.clone()], &self.mass[own.clone()]],
            );
            let around = [&self.around[own.clone()], &self.around[after]];
            add_difference(residual, around);
            let over = &self.over[own.start..=own.end];
            add_difference(residual, [over, &over[1..]]);
            add(residual, &self.out[own]);
        }
    }

    /// The sum of the residuals' absolute values, weighted by `counted`.
    pub fn imbalance(&self, counted: &[f64]) -> f64 {
        dot_of_sizes(&self.residual, counted)
    }

    /// The mass in the whole film.
    pub fn held(&self, cells: &Cells) -> f64 {
        dot(&cells.area, &self.mass)
    }

    /// The flows through the open ends.
    pub fn end_flow(&self) -> EndFlow {
        let (net, size) = (sum(&self.out), sum_of_sizes(&self.out));
        EndFlow {
            out: 0.5 * (size + net),
            into: 0.5 * (size - net),
        }
    }
}

// The sweeps below follow the rule of `sweeps`: each writes to a single array.

/// Conductance of edges at their gap.
fn conduct(conductance: &mut [f64], at_one: &[f64], h: &[f64]) {
    let n = conductance.len();
    let (at_one, h) = (&at_one[..n], &h[..n]);
    for k in 0..n {
        conductance[k] = at_one[k] * (h[k] * h[k] * h[k]);
    }
}

/// Conductance of edges at the mean gap of both sides.
fn conduct_between(conductance: &mut [f64], at_one: &[f64], h: [&[f64]; 2]) {
    let n = conductance.len();
    let (at_one, h) = (&at_one[..n], h.map(|h| &h[..n]));
    for k in 0..n {
        let h = 0.5 * (h[0][k] + h[1][k]);
        conductance[k] = at_one[k] * (h * h * h);
    }
}

/// Multiplies conductances by the mean ease of both sides.
fn ease(conductance: &mut [f64], ease: [&[f64]; 2]) {
    let n = conductance.len();
    let ease = ease.map(|e| &e[..n]);
    for k in 0..n {
        conductance[k] *= 0.5 * (ease[0][k] + ease[1][k]);
    }
}

/// The flux that the mean rotation carries at full content.
fn carry(carried: &mut [f64], rotation: f64, share: &[f64], h: &[f64]) {
    let n = carried.len();
    let (share, h) = (&share[..n], &h[..n]);
    for k in 0..n {
        carried[k] = rotation * share[k] * h[k];
    }
}

/// The flux that a pressure difference drives.
fn flow(flux: &mut [f64], conductance: &[f64], p: [&[f64]; 2]) {
    let n = flux.len();
    let (conductance, p) = (&conductance[..n], p.map(|p| &p[..n]));
    for k in 0..n {
        flux[k] = conductance[k] * (p[0][k] - p[1][k]);
    }
}

/// The flux out to the bath.
fn flow_out(flux: &mut [f64], conductance: &[f64], p: &[f64], side: f64) {
    let n = flux.len();
    let (conductance, p) = (&conductance[..n], &p[..n]);
    for k in 0..n {
        flux[k] = conductance[k] * (p[k] - side);
    }
}

/// Adds the flux that the surfaces carry, with the fill of the upstream cell.
fn add_carried(flux: &mut [f64], carried: &[f64], fill: [&[f64]; 2]) {
    let n = flux.len();
    let (carried, fill) = (&carried[..n], fill.map(|f| &f[..n]));
    for k in 0..n {
        let (before, own) = (fill[0][k], fill[1][k]);
        flux[k] += carried[k] * if carried[k] > 0.0 { before } else { own };
    }
}

/// The rate at which mass is stored.
fn store(flux: &mut [f64], rate: f64, area: &[f64], mass: [&[f64]; 2]) {
    let n = flux.len();
    let (area, mass) = (&area[..n], mass.map(|m| &m[..n]));
    for k in 0..n {
        flux[k] = area[k] * rate * (mass[1][k] - mass[0][k]);
    }
}

/// Flows through the open ends, outwards and inwards.
#[derive(Clone, Copy, Debug, Default)]
pub struct EndFlow {
    pub out: f64,
    pub into: f64,
}

impl EndFlow {
    /// Both flows times a weight.
    pub fn weighted(self, weight: f64) -> Self {
        Self {
            out: self.out * weight,
            into: self.into * weight,
        }
    }

    /// The sum with other flows.
    pub fn and(self, other: Self) -> Self {
        Self {
            out: self.out + other.out,
            into: self.into + other.into,
        }
    }
}
