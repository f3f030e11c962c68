//! The power balance of a film whose density rises with pressure.
//!
//! Divided by its density, a cell's mass balance becomes a balance of volume with a term for the oil's compression. With
//! the volume fluxes `q` over the edges and the densities `r` there, it is
//!
//! ```text
//! V (H - m_start / rho) / dt + sum q + sum q (r / rho - 1) = 0
//! ```
//!
//! Multiplied by the pressure and summed over the cells, the middle term is the work of the surfaces less the viscous
//! dissipation. The other terms are stored, or lost where oil fills an emptier gap.

use super::{stage::FilmStage, upwind::edges, workspace::Workspace};

/// The powers of a film, dimensionless.
#[derive(Clone, Copy, Debug, Default)]
pub struct Powers {
    /// Dissipated by viscosity and by filling.
    pub loss: f64,
    /// Stored in the oil's compression.
    pub stored: f64,
    /// Spent by the bath's pressure.
    pub bath: f64,
}

/// A cell that starts emptier by this share was not full; less is rounding.
const LACK: f64 = 1e-9;

/// The powers at the end of a stage. `squeeze` computes how fast the surfaces approach in a column.
pub fn powers(work: &Workspace, stage: &FilmStage, squeeze: impl Fn(usize) -> f64) -> Powers {
    let mut powers = Powers::default();
    let cells = &work.geometry.cells;
    for (before, behind) in edges(cells) {
        powers.flow(work, [before, behind], work.balance.along[behind]);
        powers.carry(work, [before, behind], work.balance.carried[behind]);
    }
    for cell in 1..cells.count() {
        powers.flow(work, [cell - 1, cell], work.balance.across[cell]);
    }
    for (column, range) in cells.columns() {
        let squeeze = squeeze(column);
        for cell in range {
            powers.hold(work, stage, cell, squeeze);
            powers.leave(work, stage, cell);
        }
    }
    powers
}

impl Powers {
    /// Adds the pressure flow over an edge.
    fn flow(&mut self, work: &Workspace, ends: [usize; 2], conductance: f64) {
        let p = ends.map(|cell| work.state.field.pressure[cell]);
        let mean = mean_density(work, ends);
        let flow = conductance * (p[0] - p[1]) / mean;
        self.loss += flow * (p[0] - p[1]);
        self.stored += taken(work, ends, flow, mean);
    }

    /// Adds the flow that the rotation carries over an edge.
    fn carry(&mut self, work: &Workspace, ends: [usize; 2], carried: f64) {
        let upstream = ends[usize::from(carried <= 0.0)];
        let content = work.state.field.content[upstream];
        let mean = mean_density(work, ends);
        let power = taken(work, ends, carried, content * mean);
        if content < 1.0 {
            self.loss += power;
        } else {
            self.stored += power;
        }
    }

    /// Adds the change of a cell's mass.
    fn hold(&mut self, work: &Workspace, stage: &FilmStage, cell: usize, squeeze: f64) {
        let (p, area) = (work.state.field.pressure[cell], work.geometry.cells.area[cell]);
        let start = work.geometry.gap.cell[cell] + squeeze * work.geometry.gap.cell_apart[cell] * stage.duration;
        let mass = stage.mass[cell];
        let taken = p * area * (start - mass / work.liquid.density[cell]) / stage.duration;
        if mass < (1.0 - LACK) * start {
            self.loss += taken;
        } else {
            self.stored += taken;
        }
    }

    /// Adds the flow out of the open ends.
    fn leave(&mut self, work: &Workspace, stage: &FilmStage, cell: usize) {
        let over = work.state.field.pressure[cell] - stage.side;
        let flow = work.balance.open[cell] * over / work.liquid.density[cell];
        self.loss += flow * over;
        self.bath -= flow * stage.side;
    }
}

/// The mean density on both sides of an edge.
fn mean_density(work: &Workspace, [before, behind]: [usize; 2]) -> f64 {
    let density = &work.liquid.density;
    0.5 * (density[before] + density[behind])
}

/// The power that a flow over an edge, from the first of its ends to the second, takes to change to their densities.
fn taken(work: &Workspace, ends: [usize; 2], flow: f64, density: f64) -> f64 {
    let [before, behind] =
        ends.map(|cell| work.state.field.pressure[cell] * (density / work.liquid.density[cell] - 1.0));
    flow * (before - behind)
}
