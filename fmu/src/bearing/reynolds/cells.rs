//! The film's balance of mass, cell by cell, and its linearisation.
//!
//! Per cell of a [`Grid`], with the share `V` of the developed area, the mass `m = rho theta H` (density
//! relative to the oil's, content `theta` in 0..1), and the pressure `P` above that of the cavities,
//!
//! ```text
//! V (m - m_start) / dt + [omega H theta rho]_upstream + sum G (P - P_neighbour) = 0
//! P >= 0,  theta <= 1,  P (1 - theta) = 0
//! ```
//!
//! (Jakobsson & Floberg 1957, Olsson 1965; the complementarity as in Woloszynski, Podsiadlo &
//! Stachowiak 2015, Tribol. Lett. 58). A full cell's unknown is its pressure, a cavitated
//! cell's its content: which is which is the active set, found by a semismooth Newton method. In a full
//! film the flux at an edge uses the edge's own gap, second order in the cell's size; content comes
//! from upstream, first order, and without any of it from downstream.

use nalgebra::Vector2;

use super::gap::{Directions, Gap};
use super::grid::Grid;
use super::profile_lu::ProfileLu;

/// What happens to oil where the film ruptures.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub enum Cavitation {
    /// Its mass is conserved: the film reforms when enough has flowed in.
    #[default]
    MassConserving,
    /// It is not asked for: `p >= 0`, and oil is at hand wherever the pressure rises.
    NonNegative,
}

/// Which edge of the grid, as seen from a cell.
#[derive(Clone, Copy, Debug)]
struct Coupling {
    /// The neighbouring cell.
    cell: usize,
    /// The conductance for pressure.
    conductance: f64,
    /// The volume rate, per content, that comes in from there with the mean rotation; else 0.
    entering: f64,
}

/// One film's cells: geometry, present linearisation and solution.
#[derive(Clone, Debug)]
pub(super) struct Cells {
    pub(super) grid: Grid,
    pub(super) directions: Directions,
    cavitation: Cavitation,
    /// Share of the width of each row, summing to one.
    pub(super) share: Vec<f64>,
    /// Conductance across the edge before each row (and after the last), per angle, at `H = 1`.
    pub(super) across: Vec<f64>,
    /// Reciprocal of the distance between the columns' middles.
    along: Vec<f64>,
    /// Density relative to the oil's, per cell.
    pub(super) density: Vec<f64>,
    /// The oil's viscosity over the cell's, per cell.
    pub(super) fluidity: Vec<f64>,
    /// Pressure above that of the cavities, per cell, 1/s.
    pub(super) pressure: Vec<f64>,
    /// Content, per cell.
    pub(super) content: Vec<f64>,
    /// Which cells are full (in the set).
    pub(super) full: Vec<bool>,
    /// How often each cell has moved into or out of the set in this stage.
    moves: Vec<u8>,
    /// Conductances of the edge before each cell around the bush.
    conduct_along: Vec<f64>,
    /// Conductances of the edge before each cell's row, and a last row's to the open end.
    conduct_across: Vec<f64>,
    matrix: ProfileLu,
    /// Solution, its derivatives over the eccentricity (x, y), and nothing.
    columns: Vec<[f64; 4]>,
    /// The place of each column in the linear system.
    place: Vec<usize>,
}

/// A share of the clearance that is lost in rounding: less inflow or suction than makes this much in a stage
/// does not move a cell into or out of the set.
const ROUNDING: f64 = 1e-13;

/// A cell changes sides at most this often in a stage.
const MOVES: u8 = 6;

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

/// The load carried and its derivative over the eccentricity ratio, both through the pressures.
#[derive(Clone, Copy, Debug)]
pub(super) struct Response {
    pub(super) load: Vector2<f64>,
    /// The sum of the sizes of what adds up to the load.
    pub(super) size: f64,
    pub(super) slope: nalgebra::Matrix2<f64>,
}

impl Cells {
    pub(super) fn new(grid: Grid, width_to_diameter: f64, cavitation: Cavitation) -> Self {
        let (columns, rows) = (grid.columns(), grid.rows());
        let length = grid.zeta_edge(rows) - grid.zeta_edge(0);
        let slenderness = width_to_diameter.powi(-2);
        let end = 1.0 / grid.end_distance();
        let first = if grid.is_whole_width() { end } else { 0.0 };
        let across = [first]
            .into_iter()
            .chain((1..rows).map(|j| 1.0 / grid.zeta_distance(j)))
            .chain([end])
            .map(|inverse| slenderness * inverse / length)
            .collect();
        let along = (0..columns)
            .map(|i| {
                let before = grid.theta_width((i + columns - 1) % columns);
                2.0 / (before + grid.theta_width(i))
            })
            .collect();
        let cells = columns * rows;
        Self {
            directions: Directions::new(&grid),
            cavitation,
            share: (0..rows).map(|j| grid.zeta_width(j) / length).collect(),
            across,
            along,
            density: vec![1.0; cells],
            fluidity: vec![1.0; cells],
            pressure: vec![0.0; cells],
            content: vec![1.0; cells],
            full: vec![true; cells],
            moves: vec![0; cells],
            conduct_along: vec![0.0; cells],
            conduct_across: vec![0.0; columns * (rows + 1)],
            matrix: ProfileLu::default(),
            columns: vec![[0.0; 4]; cells],
            place: vec![0; columns],
            grid,
        }
    }

    pub(super) fn count(&self) -> usize {
        self.pressure.len()
    }

    pub(super) fn conserves_mass(&self) -> bool {
        self.cavitation == Cavitation::MassConserving
    }

    /// The share of the developed area (angle times share of width) of a cell in column `i`, row `j`.
    pub(super) fn area(&self, i: usize, j: usize) -> f64 {
        self.grid.theta_width(i) * self.share[j]
    }

    /// Conductance across the edge before the cell, around the bush.
    pub(super) fn conductance_along(&self, cell: usize) -> f64 {
        self.conduct_along[cell]
    }

    /// Conductance across the edge before row `j` (`0..=rows`) of column `i`.
    pub(super) fn conductance_across(&self, i: usize, j: usize) -> f64 {
        self.conduct_across[i * (self.grid.rows() + 1) + j]
    }

    /// The mass in each cell at the gap.
    pub(super) fn masses(&self, gap: &Gap, mass: &mut Vec<f64>) {
        mass.clear();
        mass.extend((0..self.count()).map(|c| self.density[c] * self.content[c] * gap.cell[c]));
    }

    /// Computes the conductances at the gap: `rho H^3 / mu` over the distance.
    pub(super) fn conduct(&mut self, gap: &Gap) {
        let (columns, rows) = (self.grid.columns(), self.grid.rows());
        for i in 0..columns {
            let left = (i + columns - 1) % columns * rows;
            let width = self.grid.theta_width(i);
            for j in 0..rows {
                let (cell, before) = (i * rows + j, left + j);
                let oil = 0.5
                    * (self.fluidity[cell] * self.density[cell]
                        + self.fluidity[before] * self.density[before]);
                self.conduct_along[cell] =
                    oil * gap.edge[cell].powi(3) * self.along[i] * self.share[j];
            }
            for j in 0..=rows {
                let (below, above) = (i * rows + j.saturating_sub(1), i * rows + j.min(rows - 1));
                let oil = 0.5
                    * (self.fluidity[below] * self.density[below]
                        + self.fluidity[above] * self.density[above]);
                let h = 0.5 * (gap.cell[below] + gap.cell[above]);
                self.conduct_across[i * (rows + 1) + j] = oil * h.powi(3) * self.across[j] * width;
            }
        }
    }

    /// Solves the linearised balances at the gap for the present set, with derivatives over the
    /// eccentricity. False when the system is singular.
    pub(super) fn solve(&mut self, gap: &Gap, stage: &Stage<'_>) -> bool {
        self.arrange();
        self.declare(stage.rotation);
        self.assemble(gap, stage);
        if !self.matrix.factorise() {
            return false;
        }
        self.matrix.solve(&mut self.columns);
        true
    }

    /// The response of the present linear solution.
    pub(super) fn response(&self) -> Response {
        let rows = self.grid.rows();
        let mut sums = Response {
            load: Vector2::zeros(),
            size: 0.0,
            slope: nalgebra::Matrix2::zeros(),
        };
        for (i, mean) in self.directions.mean.iter().enumerate() {
            let mut sum = [0.0; 3];
            for j in 0..rows {
                if self.full[i * rows + j] {
                    let x = &self.columns[self.place[i] * rows + j];
                    for q in 0..3 {
                        sum[q] += self.share[j] * x[q];
                    }
                }
            }
            let normal = mean * self.grid.theta_width(i);
            sums.load += normal * sum[0];
            sums.size += (sum[0] * self.grid.theta_width(i)).abs();
            sums.slope -= normal * Vector2::new(sum[1], sum[2]).transpose();
        }
        sums
    }

    /// Takes over the solution for a step `change` of the eccentricity and moves cells into and out
    /// of the set. The number of cells that moved.
    pub(super) fn accept(&mut self, change: Vector2<f64>, gap: &Gap, stage: &Stage<'_>) -> usize {
        let rows = self.grid.rows();
        for (i, &place) in self.place.iter().enumerate() {
            for j in 0..rows {
                let cell = i * rows + j;
                let x = &self.columns[place * rows + j];
                let value = x[0] - x[1] * change.x - x[2] * change.y;
                if self.full[cell] {
                    self.pressure[cell] = value;
                } else if self.cavitation == Cavitation::MassConserving {
                    self.content[cell] = value;
                }
            }
        }
        match self.cavitation {
            Cavitation::MassConserving => self.move_by_content(stage),
            Cavitation::NonNegative => self.move_by_inflow(gap, stage),
        }
    }

    fn move_by_content(&mut self, stage: &Stage<'_>) -> usize {
        let mut moved = 0;
        let tension = -ROUNDING / stage.duration;
        for cell in 0..self.count() {
            if self.full[cell] {
                if self.pressure[cell] < tension && self.may_move(cell) {
                    self.full[cell] = false;
                    moved += 1;
                }
            } else if self.content[cell] > 1.0 + ROUNDING && self.may_move(cell) {
                self.full[cell] = true;
                moved += 1;
            }
            if self.full[cell] {
                self.content[cell] = 1.0;
            } else {
                self.pressure[cell] = 0.0;
            }
        }
        moved
    }

    fn move_by_inflow(&mut self, gap: &Gap, stage: &Stage<'_>) -> usize {
        let rows = self.grid.rows();
        let mut moved = 0;
        for i in 0..self.grid.columns() {
            for j in 0..rows {
                let cell = i * rows + j;
                let fills = if self.full[cell] {
                    self.pressure[cell] > 0.0
                } else {
                    let mut inflow = self.source(i, j, gap, stage);
                    for side in self.couplings(i, j, gap, stage.rotation) {
                        inflow += side.conductance * self.pressure[side.cell];
                    }
                    inflow > ROUNDING * self.area(i, j) / stage.duration
                };
                let fills = if fills != self.full[cell] && self.may_move(cell) {
                    moved += 1;
                    fills
                } else {
                    self.full[cell]
                };
                // The flag of this pass; `full` must stay as it is until all cells are seen.
                self.content[cell] = if fills { 1.0 } else { 0.0 };
            }
        }
        for cell in 0..self.count() {
            self.full[cell] = self.content[cell] > 0.0;
            self.content[cell] = 1.0;
            if !self.full[cell] {
                self.pressure[cell] = 0.0;
            }
        }
        moved
    }

    /// Begins a stage: every cell may move again.
    pub(super) fn begin(&mut self) {
        self.moves.fill(0);
    }

    /// Whether a cell that should change sides may: one that keeps going to and fro, on the brink of
    /// rupture, stays where it is for the rest of the stage. Its balance is solved all the same.
    fn may_move(&mut self, cell: usize) -> bool {
        self.moves[cell] = self.moves[cell].saturating_add(1);
        self.moves[cell] <= MOVES
    }

    /// Volume rate that would have to leave a full cell by pressure alone.
    fn source(&self, i: usize, j: usize, gap: &Gap, stage: &Stage<'_>) -> f64 {
        let (columns, rows) = (self.grid.columns(), self.grid.rows());
        let cell = i * rows + j;
        let after = (i + 1) % columns * rows + j;
        let rate = self.area(i, j) / stage.duration;
        let wedge = stage.rotation * self.share[j] * (gap.edge[cell] - gap.edge[after]);
        let ends = self.end_conductance(i, j) * stage.side;
        rate * (stage.mass[cell] - self.density[cell] * gap.cell[cell])
            + wedge * self.density[cell]
            + ends
    }

    /// Conductance from the cell to the open end or ends.
    fn end_conductance(&self, i: usize, j: usize) -> f64 {
        let rows = self.grid.rows();
        let mut sum = 0.0;
        if j == 0 && self.grid.is_whole_width() {
            sum += self.conductance_across(i, 0);
        }
        if j + 1 == rows {
            sum += self.conductance_across(i, rows);
        }
        sum
    }

    /// A cell's neighbours: before and after around the bush, then below and above over the width
    /// (a cell without one is its own, without conductance).
    fn couplings(&self, i: usize, j: usize, gap: &Gap, rotation: f64) -> [Coupling; 4] {
        let (columns, rows) = (self.grid.columns(), self.grid.rows());
        let cell = i * rows + j;
        let before = (i + columns - 1) % columns * rows + j;
        let after = (i + 1) % columns * rows + j;
        let carried = rotation * self.share[j];
        let around = |neighbour: usize, edge: usize, entering: f64| Coupling {
            cell: neighbour,
            conductance: self.conduct_along[edge],
            entering: entering.max(0.0) * gap.edge[edge] * self.density[neighbour],
        };
        let over = |inside: bool, neighbour: usize, edge: usize| Coupling {
            cell: if inside { neighbour } else { cell },
            conductance: if inside {
                self.conductance_across(i, edge)
            } else {
                0.0
            },
            entering: 0.0,
        };
        [
            around(before, cell, carried),
            around(after, after, -carried),
            over(j > 0, cell.wrapping_sub(1), j),
            over(j + 1 < rows, cell + 1, j + 1),
        ]
    }

    /// Places the columns: from one without pressure on when there is one, so that the ring closes
    /// through one triangle of the matrix only, else folded so that neighbours stay within two places.
    fn arrange(&mut self) {
        let (columns, rows) = (self.grid.columns(), self.grid.rows());
        let empty = |i: usize| !self.full[i * rows..(i + 1) * rows].contains(&true);
        match (0..columns).find(|&i| empty(i)) {
            Some(cut) => {
                for (i, place) in self.place.iter_mut().enumerate() {
                    *place = (i + columns - cut) % columns;
                }
            }
            None => {
                for (i, place) in self.place.iter_mut().enumerate() {
                    *place = if 2 * i <= columns && i > 0 {
                        2 * i - 1
                    } else {
                        2 * ((columns - i) % columns)
                    };
                }
            }
        }
    }

    /// Whether `cell`'s balance holds the unknown of the neighbour.
    fn coupled(&self, cell: usize, neighbour: usize, upstream: bool) -> bool {
        match self.cavitation {
            Cavitation::MassConserving => self.full[neighbour] || upstream,
            Cavitation::NonNegative => self.full[cell] && self.full[neighbour],
        }
    }

    /// Declares the entries of the matrix.
    fn declare(&mut self, rotation: f64) {
        let (columns, rows) = (self.grid.columns(), self.grid.rows());
        self.matrix.reset(self.count());
        for i in 0..columns {
            let after = (i + 1) % columns;
            let (place, place_after) = (self.place[i] * rows, self.place[after] * rows);
            for j in 0..rows {
                let (cell, next) = (i * rows + j, after * rows + j);
                if self.coupled(cell, next, rotation < 0.0) {
                    self.matrix.reach(place + j, place_after + j);
                }
                if self.coupled(next, cell, rotation > 0.0) {
                    self.matrix.reach(place_after + j, place + j);
                }
                if j + 1 < rows {
                    if self.coupled(cell, cell + 1, false) {
                        self.matrix.reach(place + j, place + j + 1);
                    }
                    if self.coupled(cell + 1, cell, false) {
                        self.matrix.reach(place + j + 1, place + j);
                    }
                }
            }
        }
        self.matrix.allocate();
    }

    /// Fills the matrix and the right-hand sides.
    fn assemble(&mut self, gap: &Gap, stage: &Stage<'_>) {
        let (columns, rows) = (self.grid.columns(), self.grid.rows());
        let conserving = self.cavitation == Cavitation::MassConserving;
        for i in 0..columns {
            let after = (i + 1) % columns;
            let row = self.place[i] * rows;
            let mean = self.directions.mean[i];
            let (n_before, n_after) = (self.directions.edge[i], self.directions.edge[after]);
            for j in 0..rows {
                let (cell, own) = (i * rows + j, row + j);
                let full = self.full[cell];
                if !full && !conserving {
                    self.matrix.add(own, own, 1.0);
                    self.columns[own] = [0.0; 4];
                    continue;
                }
                let sides = self.couplings(i, j, gap, stage.rotation);
                let rate = self.area(i, j) / stage.duration;
                let density = self.density[cell];
                // What leaves downstream, per content.
                let out_edge = if stage.rotation > 0.0 {
                    after * rows + j
                } else {
                    cell
                };
                let leaving = stage.rotation.abs() * self.share[j] * density;
                let held = density
                    * (if full || !conserving {
                        1.0
                    } else {
                        self.content[cell]
                    });
                let mut known = rate * stage.mass[cell];
                let mut diagonal = 0.0;
                // Derivative of the balance over the eccentricity, at the last solution.
                let mut slope = -mean * (rate * held);
                let n_out = if stage.rotation > 0.0 {
                    n_after
                } else {
                    n_before
                };
                slope -= n_out * (leaving * held / density);
                let kept = rate * density * gap.cell[cell] + leaving * gap.edge[out_edge];
                if full {
                    known -= kept;
                } else {
                    diagonal += kept;
                }
                let p = self.pressure[cell];
                for (k, side) in sides.iter().enumerate() {
                    let q = side.cell;
                    if full {
                        diagonal += side.conductance;
                    }
                    let n_edge = [n_before, n_after, mean, mean][k];
                    let h_edge = match k {
                        0 => gap.edge[cell],
                        1 => gap.edge[after * rows + j],
                        2 | 3 if q != cell => 0.5 * (gap.cell[cell] + gap.cell[q]),
                        _ => 1.0,
                    };
                    slope -= n_edge * (3.0 / h_edge * side.conductance * (p - self.pressure[q]));
                    let other = self.place[q / rows] * rows + q % rows;
                    if self.full[q] {
                        if side.conductance > 0.0 && q != cell {
                            self.matrix.add(own, other, -side.conductance);
                        }
                        known += side.entering;
                    } else if conserving {
                        if side.entering > 0.0 {
                            self.matrix.add(own, other, -side.entering);
                        }
                    } else {
                        known += side.entering;
                    }
                    let content = if conserving { self.content[q] } else { 1.0 };
                    let carried = side.entering / h_edge;
                    slope += n_edge * (carried * content);
                }
                let end = self.end_conductance(i, j);
                if full {
                    diagonal += end;
                }
                known += end * stage.side;
                slope -= mean * (3.0 / gap.cell[cell] * end * (p - stage.side));
                self.matrix.add(own, own, diagonal);
                self.columns[own] = [known, slope.x, slope.y, 0.0];
            }
        }
    }

    /// Whether no cell is under pressure.
    pub(super) fn is_empty(&self) -> bool {
        !self.full.contains(&true)
    }

    /// Takes all pressure off.
    pub(super) fn empty(&mut self) {
        self.full.fill(false);
        self.pressure.fill(0.0);
    }

    /// Where a film without conserved mass is empty, lets a load find something to press on.
    pub(super) fn fill_towards(&mut self, load: Vector2<f64>) {
        if self.cavitation == Cavitation::NonNegative {
            let rows = self.grid.rows();
            for (i, mean) in self.directions.mean.iter().enumerate() {
                self.full[i * rows..(i + 1) * rows].fill(mean.dot(&load) > 0.0);
            }
        }
    }

    /// What flows through the open ends.
    pub(super) fn end_flow(&self, side: f64) -> EndFlow {
        let rows = self.grid.rows();
        let mut flow = EndFlow::default();
        for i in 0..self.grid.columns() {
            let mut through = |j: usize, conductance: f64| {
                let rate = conductance * (self.pressure[i * rows + j] - side);
                if rate > 0.0 {
                    flow.out += rate;
                } else {
                    flow.into -= rate;
                }
            };
            through(rows - 1, self.conductance_across(i, rows));
            if self.grid.is_whole_width() {
                through(0, self.conductance_across(i, 0));
            }
        }
        flow
    }

    /// The mass stored since the cells held `start`.
    pub(super) fn stored_since(&self, gap: &Gap, start: &[f64]) -> f64 {
        let rows = self.grid.rows();
        (0..self.count())
            .map(|c| {
                let mass = self.density[c] * self.content[c] * gap.cell[c];
                self.area(c / rows, c % rows) * (mass - start[c])
            })
            .sum()
    }

    /// The flow that the mean rotation carries around, averaged over the columns.
    pub(super) fn circulating(&self, gap: &Gap, rotation: f64) -> f64 {
        rotation.abs() * self.held(gap) / std::f64::consts::TAU
    }

    /// The mass in the film.
    pub(super) fn held(&self, gap: &Gap) -> f64 {
        let rows = self.grid.rows();
        (0..self.count())
            .map(|c| {
                self.area(c / rows, c % rows) * self.density[c] * self.content[c] * gap.cell[c]
            })
            .sum()
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
