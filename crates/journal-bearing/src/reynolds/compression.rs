//! The power balance of a film whose density rises with pressure.
//!
//! Divided by its density, a cell's balance of mass is one of volume, plus what the oil's compression takes: with edges'
//! volume fluxes `q` and densities `r`,
//!
//! ```text
//! V (H - m_start / rho) / dt + sum q + sum q (r / rho - 1) = 0
//! ```
//!
//! Times the pressure and summed over the cells, the middle term is the work of the surfaces less what viscosity
//! dissipates, and the others are stored, or lost where oil fills an emptier gap.

use super::balance::Stage;
use super::film::ReynoldsFilm;

/// Powers, dimensionless.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Powers {
    /// Dissipated.
    pub(super) loss: f64,
    /// Stored in the oil's compression.
    pub(super) stored: f64,
    /// Brought in by the bath's pressure.
    pub(super) bath: f64,
}

/// A cell that starts this much emptier than full was so.
const ROUNDING: f64 = 1e-9;

/// The powers at the end of a stage; `squeeze` gives how fast the surfaces approach in a column.
pub(super) fn powers(
    film: &ReynoldsFilm,
    stage: &Stage<'_>,
    squeeze: impl Fn(usize) -> f64,
) -> Powers {
    let mut powers = Powers::default();
    let cells = &film.cells;
    for (own, before) in cells.neighbours() {
        for (own, before) in own.zip(before) {
            powers.flow(film, [before, own], film.balance.along[own]);
            powers.carry(film, [before, own], film.balance.carried[own]);
        }
    }
    for cell in 1..cells.count() {
        powers.flow(film, [cell - 1, cell], film.balance.across[cell]);
    }
    for (column, range) in cells.columns() {
        let squeeze = squeeze(column);
        for cell in range {
            powers.hold(film, stage, cell, squeeze);
            powers.leave(film, stage, cell);
        }
    }
    powers
}

impl Powers {
    /// Adds what pressure drives over an edge.
    fn flow(&mut self, film: &ReynoldsFilm, ends: [usize; 2], conductance: f64) {
        let p = ends.map(|cell| film.state.field.pressure[cell]);
        let mean = 0.5
            * ends
                .map(|cell| film.liquid.density[cell])
                .iter()
                .sum::<f64>();
        let flow = conductance * (p[0] - p[1]) / mean;
        self.loss += flow * (p[0] - p[1]);
        self.stored += taken(film, ends, flow, mean);
    }

    /// Adds what the rotation carries over an edge.
    fn carry(&mut self, film: &ReynoldsFilm, ends: [usize; 2], carried: f64) {
        let upstream = ends[usize::from(carried <= 0.0)];
        let content = film.state.field.content[upstream];
        let mean = 0.5
            * ends
                .map(|cell| film.liquid.density[cell])
                .iter()
                .sum::<f64>();
        let power = taken(film, ends, carried, content * mean);
        if content < 1.0 {
            self.loss += power;
        } else {
            self.stored += power;
        }
    }

    /// Adds what a cell's gap takes up.
    fn hold(&mut self, film: &ReynoldsFilm, stage: &Stage<'_>, cell: usize, squeeze: f64) {
        let (p, area) = (film.state.field.pressure[cell], film.cells.area[cell]);
        let start = film.gap.cell[cell] + squeeze * film.gap.cell_apart[cell] * stage.duration;
        let mass = stage.mass[cell];
        let taken = p * area * (start - mass / film.liquid.density[cell]) / stage.duration;
        if mass < (1.0 - ROUNDING) * start {
            self.loss += taken;
        } else {
            self.stored += taken;
        }
    }

    /// Adds what leaves through the open ends.
    fn leave(&mut self, film: &ReynoldsFilm, stage: &Stage<'_>, cell: usize) {
        let over = film.state.field.pressure[cell] - stage.side;
        let flow = film.balance.open[cell] * over / film.liquid.density[cell];
        self.loss += flow * over;
        self.bath -= flow * stage.side;
    }
}

/// What a flow over an edge, from the first of its ends to the second, takes to come to their densities.
fn taken(film: &ReynoldsFilm, ends: [usize; 2], flow: f64, density: f64) -> f64 {
    let [before, own] = ends
        .map(|cell| film.state.field.pressure[cell] * (density / film.liquid.density[cell] - 1.0));
    flow * (before - own)
}
