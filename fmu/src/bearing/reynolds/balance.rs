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

/// What drives the film in one implicit Euler stage.
#[derive(Clone, Copy, Debug)]
pub(super) struct Stage<'a> {
    /// Duration, s.
    pub(super) duration: f64,
    /// Mass at its start, per cell.
    pub(super) mass: &'a [f64],
    /// Mean rotation, rad/s.
    pub(super) rotation: f64,
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
    /// What the mean rotation carries over the edge before each cell if it is full upstream.
    pub(super) carried: Vec<f64>,
    /// Density times content in each cell.
    pub(super) fill: Vec<f64>,
    /// Mass in each cell.
    pub(super) mass: Vec<f64>,
    /// Flux over the edge before each cell, in the sense of rotation.
    around: Vec<f64>,
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
        self.flow_over(cells, gap, liquid, field, stage);
        self.miss(cells, stage);
    }

    /// The mass in each cell.
    pub(super) fn weigh(&mut self, gap: &Gap, liquid: &Liquid, field: &Field) {
        let n = self.mass.len();
        let (h, density, content) = (&gap.cell[..n], &liquid.density[..n], &field.content[..n]);
        let fill = &mut self.fill[..n];
        for c in 0..n {
            fill[c] = density[c] * content[c];
            self.mass[c] = fill[c] * h[c];
        }
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
            let n = own.len();
            let (h, share) = (&gap.edge[own.clone()][..n], &cells.share[own.clone()][..n]);
            let at_one = &cells.along[own.clone()][..n];
            let [ease, p, fill] = [&liquid.ease, &field.pressure, &self.fill]
                .map(|of| [&of[before.clone()][..n], &of[own.clone()][..n]]);
            let along = &mut self.along[own.clone()][..n];
            let carried = &mut self.carried[own.clone()][..n];
            let around = &mut self.around[own][..n];
            for k in 0..n {
                along[k] = 0.5 * (ease[0][k] + ease[1][k]) * at_one[k] * (h[k] * h[k] * h[k]);
                carried[k] = stage.rotation * share[k] * h[k];
                let fill = if carried[k] > 0.0 {
                    fill[0][k]
                } else {
                    fill[1][k]
                };
                around[k] = carried[k] * fill + along[k] * (p[0][k] - p[1][k]);
            }
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
        let (h, ease, p) = (&gap.cell[..n], &liquid.ease[..n], &field.pressure[..n]);
        let at_one = &cells.across[1..n];
        let (across, over) = (&mut self.across[1..n], &mut self.over[1..n]);
        for c in 0..n - 1 {
            let middle = 0.5 * (h[c] + h[c + 1]);
            across[c] = 0.5 * (ease[c] + ease[c + 1]) * at_one[c] * (middle * middle * middle);
            over[c] = across[c] * (p[c] - p[c + 1]);
        }
        let (at_one, open, out) = (&cells.open[..n], &mut self.open[..n], &mut self.out[..n]);
        for c in 0..n {
            open[c] = ease[c] * at_one[c] * (h[c] * h[c] * h[c]);
            out[c] = open[c] * (p[c] - stage.side);
        }
    }

    /// The residuals.
    fn miss(&mut self, cells: &Cells, stage: &Stage<'_>) {
        let rate = 1.0 / stage.duration;
        for (after, own) in cells.neighbours() {
            let n = own.len();
            let (mass, start) = (&self.mass[own.clone()][..n], &stage.mass[own.clone()][..n]);
            let area = &cells.area[own.clone()][..n];
            let (entering, leaving) = (&self.around[own.clone()][..n], &self.around[after][..n]);
            let over = &self.over[own.start..own.end + 1][..n + 1];
            let out = &self.out[own.clone()][..n];
            let residual = &mut self.residual[own][..n];
            for k in 0..n {
                residual[k] = area[k] * rate * (mass[k] - start[k])
                    + (leaving[k] - entering[k])
                    + (over[k + 1] - over[k])
                    + out[k];
            }
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
