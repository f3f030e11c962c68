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

use std::ops::Range;

use super::{
    cells::Cells,
    gap::Gap,
    liquid::Liquid,
    stage::FilmStage,
    state::Field,
    sweeps::{add_difference, change, fill},
    upwind,
};
use crate::{
    reynolds::lanes::{dot, sum_of},
    roughness::shear_flow_factor,
};

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
    /// Flux out of each cell into the supply of a feed; empty without feeds.
    fed: Vec<f64>,
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
            fed: Vec::new(),
            residual: zeros(),
        }
    }

    /// Computes everything at the present gap, oil and field.
    pub fn update(&mut self, cells: &Cells, gap: &Gap, liquid: &Liquid, field: &Field, stage: &FilmStage) {
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
        let product = |[a, b]: [f64; 2]| a * b;
        fill(&mut self.fill, [&liquid.density, &field.content], product);
        fill(&mut self.mass, [&self.fill, &gap.cell], product);
    }

    /// Computes conductances `rho H^3 / mu` and fluxes between columns.
    fn flow_around(&mut self, cells: &Cells, gap: &Gap, liquid: &Liquid, field: &Field, stage: &FilmStage) {
        let [_, flows] = gap.flow();
        for (behind, before) in cells.neighbours() {
            let (h, share) = (&gap.edge[behind.clone()], &cells.share[behind.clone()]);
            let along = &mut self.along[behind.clone()];
            let flow = &flows[behind.clone()];
            fill(along, [&cells.along[behind.clone()], flow], at_gap);
            if !liquid.uniform {
                let ease = [before.clone(), behind.clone()].map(|of| &liquid.ease[of]);
                change(along, ease, eased);
            }
            let carried = &mut self.carried[behind.clone()];
            fill(carried, [share, h], |[share, h]| stage.rotation * share * h);
            if stage.shear != 0.0 {
                let edges = [share, &gap.edge_ratio[behind.clone()]];
                change(carried, edges, |carried, [share, ratio]| {
                    carried + stage.shear * share * shear_flow_factor(ratio)
                });
            }
            let around = &mut self.around[behind.clone()];
            let p = [before.clone(), behind.clone()].map(|of| &field.pressure[of]);
            fill(around, [along, p[0], p[1]], |[g, a, b]| driven(g, a, b));
            // The oil comes from the cell upstream.
            let upstream = [carried, &self.fill[before], &self.fill[behind]];
            change(around, upstream, |flux, [carried, before, behind]| {
                flux + carried * if carried > 0.0 { before } else { behind }
            });
        }
    }

    /// Computes conductances and fluxes between rows and through the open ends.
    fn flow_over(&mut self, cells: &Cells, gap: &Gap, liquid: &Liquid, field: &Field, stage: &FilmStage) {
        let n = self.mass.len();
        let ([h, _], p, ease) = (gap.flow(), &field.pressure[..], &liquid.ease[..]);
        let (below, above) = (..n - 1, 1..n);
        let across = &mut self.across[1..n];
        let both = [&cells.across[1..n], &h[below], &h[above.clone()]];
        fill(across, both, |[at_one, below, above]| at_gap([at_one, 0.5 * (below + above)]));
        fill(&mut self.open, [&cells.open, h], at_gap);
        if !liquid.uniform {
            change(across, [&ease[below], &ease[above.clone()]], eased);
            change(&mut self.open, [ease; 2], eased);
        }
        fill(&mut self.over[1..n], [across, &p[below], &p[above]], |[g, a, b]| driven(g, a, b));
        fill(&mut self.out, [&self.open, p], |[conductance, p]| conductance * (p - stage.side));
        self.fed.resize(cells.feed.len(), 0.0);
        if !self.fed.is_empty() {
            fill(&mut self.fed, [&cells.feed, p], |[conductance, p]| conductance * (p - stage.feed));
        }
    }

    /// Adds up the residuals.
    fn add_up(&mut self, cells: &Cells, stage: &FilmStage) {
        let rate = 1.0 / stage.duration;
        for (after, here) in cells.neighbours() {
            let residual = &mut self.residual[here.clone()];
            let masses = [&cells.area, stage.mass, &self.mass].map(|of| &of[here.clone()]);
            fill(residual, masses, |[area, start, mass]| area * rate * (mass - start));
            let around = [&self.around[here.clone()], &self.around[after]];
            add_difference(residual, around);
            let over = &self.over[here.start..=here.end];
            add_difference(residual, [over, &over[1..]]);
            change(residual, [&self.out[here.clone()]], |residual, [out]| residual + out);
            if !self.fed.is_empty() {
                change(residual, [&self.fed[here]], |residual, [fed]| residual + fed);
            }
        }
    }

    /// The sum of the residuals' absolute values, weighted by `counted`.
    pub fn imbalance(&self, counted: &[f64]) -> f64 {
        sum_of([&self.residual, counted], |[residual, counted]| residual.abs() * counted)
    }

    /// The mass in the whole film.
    pub fn held(&self, cells: &Cells) -> f64 {
        dot(&cells.area, &self.mass)
    }

    /// The flows of the column with these cells.
    pub fn flows(&self, cells: Range<usize>) -> ColumnFlows {
        let out_and_in = |flows: &[f64]| {
            let both = flows.iter().map(|flow| [flow.max(0.0), (-flow).max(0.0)]);
            both.fold([0.0; 2], |sum, flow| [sum[0] + flow[0], sum[1] + flow[1]])
        };
        ColumnFlows {
            around: self.around[cells.clone()].iter().sum(),
            ends: out_and_in(&self.out[cells.clone()]),
            feed: out_and_in(self.fed.get(cells).unwrap_or_default()),
        }
    }

    /// The flows through the open ends.
    pub fn end_flow(&self) -> EndFlow {
        let net = sum_of([&self.out], |[out]| out);
        let size = sum_of([&self.out], |[out]| out.abs());
        EndFlow { out: 0.5 * (size + net), into: 0.5 * (size - net), fed: -self.fed.iter().sum::<f64>() }
    }
}

/// Flows of a column: over the edge before it, out of the ends and in, out into feeds and in.
#[derive(Clone, Copy, Debug)]
pub struct ColumnFlows {
    pub around: f64,
    pub ends: [f64; 2],
    pub feed: [f64; 2],
}

/// Conductance of an edge, from that at `H = 1` and its gap.
fn at_gap([at_one, h]: [f64; 2]) -> f64 {
    at_one * (h * h * h)
}

/// A conductance at the mean ease of both sides.
fn eased(conductance: f64, [before, behind]: [f64; 2]) -> f64 {
    conductance * (0.5 * (before + behind))
}

/// The flux from the cell before an edge to the one behind it, by their difference in pressure.
fn driven(conductance: f64, before: f64, behind: f64) -> f64 {
    conductance * (before - behind)
}

/// Flows through the open ends, outwards and inwards, and into the film through feeds.
#[derive(Clone, Copy, Debug)]
pub struct EndFlow {
    pub out: f64,
    pub into: f64,
    pub fed: f64,
}

impl EndFlow {
    /// The sum of all.
    pub fn through(&self) -> f64 {
        self.out + self.into + self.fed.abs()
    }
}
