//! The film's balance of mass, cell by cell.
//!
//! Per cell of a [`Grid`](super::grid::Grid), with the share `V` of the developed area, the mass
//! `m = rho theta H` (density relative to the oil's at ambient pressure, content `theta` in 0..1), and the pressure `P`
//! above that of the cavities,
//!
//! ```text
//! V (m - m_start) / dt + [omega H theta rho]_upstream + sum G (P - P_neighbour) = 0
//! P >= 0,  theta <= 1,  P (1 - theta) = 0
//! ```
//!
//! (Jakobsson & Floberg 1957, Olsson 1965; the complementarity as in Woloszynski, Podsiadlo &
//! Stachowiak 2015, Tribol. Lett. 58). In a full film the flux at an edge uses the edge's own gap, second
//! order in the cell's size; content comes from upstream, first order, and without any of it from downstream.
//!
//! Every flux is computed once, at its edge, and leaves one cell as it enters the next: what the cells' residuals
//! add up to is the whole film's error of mass.

use super::cells::Cells;
use super::field::Field;
use super::gap::Gap;
use super::lanes::{dot, dot_of_sizes, sum, sum_of_sizes};
use super::liquid::Liquid;
use super::roughness::shear_flow_factor;

/// What drives the film in one implicit Euler stage.
#[derive(Clone, Copy, Debug)]
pub(super) struct Stage<'a> {
    /// Duration, s.
    pub(super) duration: f64,
    /// Mass at its start, per cell.
    pub(super) mass: &'a [f64],
    /// Mean rotation, rad/s.
    pub(super) rotation: f64,
    /// What the sliding of rough surfaces carries at a shear flow factor of one, 1/s; else zero.
    pub(super) shear: f64,
    /// Pressure at the open ends above that of the cavities, 1/s.
    pub(super) side: f64,
}

/// Conductances, fluxes and residuals of the cells at one gap and field.
#[derive(Clone, Debug)]
pub(super) struct Balance {
    /// Conductance of the edge to the column before each cell.
    pub(super) along: Vec<f64>,
    /// Conductance of the edge to the row below each cell; with one more at the end, zero.
    pub(super) across: Vec<f64>,
    /// Conductance to the open ends.
    pub(super) open: Vec<f64>,
    /// What the surfaces carry over the edge before each cell if it is full upstream.
    pub(super) carried: Vec<f64>,
    /// Density times content in each cell.
    pub(super) fill: Vec<f64>,
    /// Mass in each cell.
    pub(super) mass: Vec<f64>,
    /// Flux over the edge before each cell, in the sense of rotation.
    pub(super) around: Vec<f64>,
    /// Flux from the row below into each cell; with one more at the end, zero.
    over: Vec<f64>,
    /// Flux out through the open ends.
    out: Vec<f64>,
    /// What each cell's balance misses, as a flux out of it.
    pub(super) residual: Vec<f64>,
}

impl Balance {
    pub(super) fn new(cells: usize) -> Self {
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

    /// Computes all of it.
    pub(super) fn update(
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
            self.centre(cells, liquid, field);
        }
        self.flow_over(cells, gap, liquid, field, stage);
        self.miss(cells, stage);
    }

    /// The mass in each cell.
    pub(super) fn weigh(&mut self, gap: &Gap, liquid: &Liquid, field: &Field) {
        multiply(&mut self.fill, &liquid.density, &field.content);
        multiply(&mut self.mass, &self.fill, &gap.cell);
    }

    /// Conductances `rho H^3 / mu` and fluxes between columns.
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

    /// Conductances and fluxes between rows and through the open ends.
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

    /// The residuals.
    fn miss(&mut self, cells: &Cells, stage: &Stage<'_>) {
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

    /// The size of the residuals of the cells that `counted` counts.
    pub(super) fn imbalance(&self, counted: &[f64]) -> f64 {
        dot_of_sizes(&self.residual, counted)
    }

    /// The mass in the film.
    pub(super) fn held(&self, cells: &Cells) -> f64 {
        dot(&cells.area, &self.mass)
    }

    /// What flows through the open ends.
    pub(super) fn end_flow(&self) -> EndFlow {
        let (net, size) = (sum(&self.out), sum_of_sizes(&self.out));
        EndFlow {
            out: 0.5 * (size + net),
            into: 0.5 * (size - net),
        }
    }
}

// The sweeps below each write to one array, which the compiler therefore knows to be apart from all that they read.

fn multiply(product: &mut [f64], a: &[f64], b: &[f64]) {
    let n = product.len();
    let (a, b) = (&a[..n], &b[..n]);
    for k in 0..n {
        product[k] = a[k] * b[k];
    }
}

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

/// Puts the mean ease of both sides into conductances.
fn ease(conductance: &mut [f64], ease: [&[f64]; 2]) {
    let n = conductance.len();
    let ease = ease.map(|e| &e[..n]);
    for k in 0..n {
        conductance[k] *= 0.5 * (ease[0][k] + ease[1][k]);
    }
}

fn carry(carried: &mut [f64], rotation: f64, share: &[f64], h: &[f64]) {
    let n = carried.len();
    let (share, h) = (&share[..n], &h[..n]);
    for k in 0..n {
        carried[k] = rotation * share[k] * h[k];
    }
}

fn flow(flux: &mut [f64], conductance: &[f64], p: [&[f64]; 2]) {
    let n = flux.len();
    let (conductance, p) = (&conductance[..n], p.map(|p| &p[..n]));
    for k in 0..n {
        flux[k] = conductance[k] * (p[0][k] - p[1][k]);
    }
}

fn flow_out(flux: &mut [f64], conductance: &[f64], p: &[f64], side: f64) {
    let n = flux.len();
    let (conductance, p) = (&conductance[..n], &p[..n]);
    for k in 0..n {
        flux[k] = conductance[k] * (p[k] - side);
    }
}

/// Adds what is carried, filled as upstream.
fn add_carried(flux: &mut [f64], carried: &[f64], fill: [&[f64]; 2]) {
    let n = flux.len();
    let (carried, fill) = (&carried[..n], fill.map(|f| &f[..n]));
    for k in 0..n {
        let (before, own) = (fill[0][k], fill[1][k]);
        flux[k] += carried[k] * if carried[k] > 0.0 { before } else { own };
    }
}

/// The rate of storage.
fn store(flux: &mut [f64], rate: f64, area: &[f64], mass: [&[f64]; 2]) {
    let n = flux.len();
    let (area, mass) = (&area[..n], mass.map(|m| &m[..n]));
    for k in 0..n {
        flux[k] = area[k] * rate * (mass[1][k] - mass[0][k]);
    }
}

/// Adds what leaves less what enters.
fn add_difference(flux: &mut [f64], through: [&[f64]; 2]) {
    let n = flux.len();
    let through = through.map(|t| &t[..n]);
    for k in 0..n {
        flux[k] += through[1][k] - through[0][k];
    }
}

fn add(flux: &mut [f64], more: &[f64]) {
    for (flux, more) in flux.iter_mut().zip(more) {
        *flux += more;
    }
}

/// Rates of flow through the open ends, outwards and inwards.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct EndFlow {
    pub(super) out: f64,
    pub(super) into: f64,
}

impl EndFlow {
    pub(super) fn weighted(self, weight: f64) -> Self {
        Self {
            out: self.out * weight,
            into: self.into * weight,
        }
    }

    pub(super) fn and(self, other: Self) -> Self {
        Self {
            out: self.out + other.out,
            into: self.into + other.into,
        }
    }
}
