//! The gap between journal and bush, in units of the radial clearance.

use nalgebra::Vector2;

use super::cells::Cells;
use crate::{
    reynolds::lanes::{LANES, smallest},
    roughness::{NO_CONTACT, RoughFilm, Table, table},
};

/// All that shapes the gap apart from the eccentricity.
#[derive(Clone, Debug, Default)]
pub struct Form {
    /// Eccentricity ratio that the journal's tilt adds at `zeta = 1`.
    pub tilt: Vector2<f64>,
    /// Radial deviation of the bush less that of the journal at the columns' middles, in clearances; empty when round.
    pub middle: Vec<f64>,
    /// The same at the edges before the columns.
    pub edge: Vec<f64>,
    /// Roughness over clearance of surfaces whose film sees it; zero when smooth.
    pub roughness: f64,
    /// How the film sees it.
    pub rough_film: RoughFilm,
}

impl Form {
    /// Whether both surfaces are round and aligned.
    pub fn is_plain(&self) -> bool {
        self.tilt == Vector2::zeros() && self.middle.is_empty()
    }

    /// Whether the film feels the roughness when the mean planes are at least this far from each other, in clearances.
    pub fn feels(&self, distance: f64) -> bool {
        match self.rough_film {
            RoughFilm::FlowFactors { .. } => self.roughness > 0.0,
            _ => distance < NO_CONTACT * self.roughness,
        }
    }

    /// The distances of the mean planes in the middle of column `i`, and at the edge before it, at the eccentricity ratio `eps`.
    #[inline(always)]
    fn distances(&self, cells: &Cells, eps: Vector2<f64>, i: usize) -> [f64; 2] {
        let directions = &cells.directions;
        let normals = [&directions.mean[i], &directions.edge[i]];
        let deviations = [&self.middle, &self.edge].map(|of| of.get(i).copied().unwrap_or(0.0));
        std::array::from_fn(|k| 1.0 - eps.dot(normals[k]) + deviations[k])
    }

    /// The gap of content that the film has at a distance of the mean planes, and its slope, in clearances.
    pub fn content(&self, distance: f64) -> [f64; 2] {
        let seen = self.see(table(), distance);
        [seen.content, seen.bears]
    }

    /// The gaps that the film has at a distance of the mean planes, in clearances.
    #[inline(always)]
    fn see(&self, table: &Table, distance: f64) -> FilmGap {
        if !self.feels(distance) {
            return FilmGap { content: distance, bears: 1.0, flow: distance };
        }
        let ratio = distance / self.roughness;
        let [[content, flow], [bears, _]] = self.rough_film.gaps_in(table, ratio);
        FilmGap { content: content * self.roughness, bears, flow: flow * self.roughness }
    }
}

/// The gaps of the film at a place, in clearances.
#[derive(Clone, Copy)]
struct FilmGap {
    content: f64,
    /// The slope of the content over the distance of the mean planes: the share of the area on which the film bears.
    bears: f64,
    flow: f64,
}

/// The gap in every cell and at every edge between columns, column by column.
#[derive(Clone, Debug)]
pub struct Gap {
    /// Content per area of a full film: mean over each cell.
    pub cell: Vec<f64>,
    /// The same at the edge before each cell, in the middle of its row.
    pub edge: Vec<f64>,
    /// Derivative of `cell` over the distance of the mean planes: the share of the area on which the film bears; one for
    /// smooth surfaces.
    pub cell_apart: Vec<f64>,
    /// The gap whose third power the flow goes with, of cells and at edges; unused while the film does not feel the roughness.
    cell_flow: Vec<f64>,
    edge_flow: Vec<f64>,
    /// Derivatives of `edge` and of the flows' gaps, as [`differentiate`](Self::differentiate) computes them.
    pub edge_apart: Vec<f64>,
    pub cell_flow_apart: Vec<f64>,
    pub edge_flow_apart: Vec<f64>,
    /// Film ratio of rough surfaces in each cell and at each edge: distance of the mean planes over the roughness. Unused
    /// while the film does not feel the roughness. Between round, aligned surfaces it stands in the first cell of each column
    /// alone, unless the film has flow factors.
    pub ratio: Vec<f64>,
    pub edge_ratio: Vec<f64>,
    /// Area on which the film's pressure acts, per cell.
    pub pressed: Vec<f64>,
    /// The smallest gap of all cells and edges.
    pub smallest: f64,
    /// Whether the film feels the surfaces' roughness anywhere.
    pub rough: bool,
    /// How many cells in a row have the same gap: those of a column, unless the journal is tilted.
    alike: usize,
}

impl Gap {
    /// The gap of a centred journal.
    pub fn new(cells: &Cells) -> Self {
        let ones = || vec![1.0; cells.count()];
        Self {
            cell: ones(),
            edge: ones(),
            cell_apart: ones(),
            edge_apart: ones(),
            cell_flow: ones(),
            cell_flow_apart: ones(),
            edge_flow: ones(),
            edge_flow_apart: ones(),
            ratio: vec![0.0; cells.count()],
            edge_ratio: vec![0.0; cells.count()],
            pressed: cells.area.clone(),
            smallest: 1.0,
            rough: false,
            alike: cells.stride,
        }
    }

    /// Computes the gap at the eccentricity ratio `eps` of the middle plane.
    pub fn update(&mut self, cells: &Cells, form: &Form, eps: Vector2<f64>) {
        self.alike = if form.tilt == Vector2::zeros() { cells.stride } else { 1 };
        let was_rough = self.rough;
        if form.is_plain() {
            // The narrowest point may lie between two grid points.
            self.smallest = 1.0 - eps.norm();
            self.rough = form.feels(self.smallest);
        }
        // Such a column gets the gaps between its asperities at once.
        if !(form.is_plain() && self.rough) {
            self.part(cells, form, eps);
        }
        if !form.is_plain() {
            self.smallest = smallest(&self.cell).min(smallest(&self.edge));
            self.rough = form.feels(self.smallest);
        }
        if self.rough {
            self.smallest = form.content(self.smallest)[0];
            self.roughen(cells, form, eps);
        } else if was_rough {
            let aparts =
                [&mut self.cell_apart, &mut self.edge_apart, &mut self.cell_flow_apart, &mut self.edge_flow_apart];
            for apart in aparts {
                apart.fill(1.0);
            }
            self.pressed.copy_from_slice(&cells.area);
        }
    }

    /// Computes the distances of the mean planes.
    fn part(&mut self, cells: &Cells, form: &Form, eps: Vector2<f64>) {
        let columns = self.cell.chunks_exact_mut(cells.stride);
        let columns = columns.zip(self.edge.chunks_exact_mut(cells.stride));
        for (i, (cell, edge)) in columns.enumerate() {
            let [middle, before] = form.distances(cells, eps, i);
            spread(cell, middle);
            spread(edge, before);
            if form.tilt != Vector2::zeros() {
                let directions = &cells.directions;
                let slope = form.tilt.dot(&directions.mean[i]);
                let slope_edge = form.tilt.dot(&directions.edge[i]);
                for ((cell, edge), zeta) in cell.iter_mut().zip(edge).zip(&cells.zeta) {
                    *cell -= zeta * slope;
                    *edge -= zeta * slope_edge;
                }
            }
        }
    }

    /// The gap whose third power the flow goes with, of cells and at edges.
    pub fn flow(&self) -> [&[f64]; 2] {
        if self.rough { [&self.cell_flow, &self.edge_flow] } else { [&self.cell, &self.edge] }
    }

    /// The film ratio of rough surfaces in a cell.
    pub fn film_ratio(&self, cell: usize) -> f64 {
        self.ratio[cell - cell % self.alike]
    }

    /// Computes the derivatives over the distance of the mean planes.
    pub fn differentiate(&mut self, form: &Form) {
        if !self.rough {
            return;
        }
        let stride = self.alike;
        let table = table();
        let slopes = |ratio: f64| form.rough_film.gaps_in(table, ratio)[1];
        for first in (0..self.cell.len()).step_by(stride) {
            let column = first..first + stride;
            let [_, flow] = slopes(self.ratio[first]);
            let [apart, edge_flow] = slopes(self.edge_ratio[first]);
            spread(&mut self.cell_flow_apart[column.clone()], flow);
            spread(&mut self.edge_apart[column.clone()], apart);
            spread(&mut self.edge_flow_apart[column], edge_flow);
        }
    }

    /// Replaces the distances of rough surfaces by the gaps that the film sees.
    fn roughen(&mut self, cells: &Cells, form: &Form, eps: Vector2<f64>) {
        if self.alike == 1 {
            self.roughen_cells(cells, form);
        } else {
            self.roughen_columns(cells, form, eps);
        }
    }

    /// The same in each cell of a tilted journal.
    fn roughen_cells(&mut self, cells: &Cells, form: &Form) {
        let table = table();
        for cell in 0..self.cell.len() {
            let [here, edge] = [self.cell[cell], self.edge[cell]];
            self.ratio[cell] = here / form.roughness;
            self.edge_ratio[cell] = edge / form.roughness;
            let [here, edge] = [form.see(table, here), form.see(table, edge)];
            (self.cell[cell], self.cell_flow[cell]) = (here.content, here.flow);
            (self.edge[cell], self.edge_flow[cell]) = (edge.content, edge.flow);
            self.cell_apart[cell] = here.bears;
            self.pressed[cell] = cells.area[cell] * here.bears;
        }
    }

    /// The same in each column of an aligned one.
    fn roughen_columns(&mut self, cells: &Cells, form: &Form, eps: Vector2<f64>) {
        let (stride, table) = (self.alike / LANES, table());
        let area = cells.area.as_chunks::<LANES>().0;
        let [cell, cell_apart, pressed, cell_flow, edge, edge_flow] = [
            &mut self.cell,
            &mut self.cell_apart,
            &mut self.pressed,
            &mut self.cell_flow,
            &mut self.edge,
            &mut self.edge_flow,
        ]
        .map(|values| values.as_chunks_mut::<LANES>().0);
        for (i, column) in cells.columns() {
            let [here, before] = form.distances(cells, eps, i);
            self.ratio[column.start] = here / form.roughness;
            self.edge_ratio[column.start] = before / form.roughness;
            let [here, before] = [form.see(table, here), form.see(table, before)];
            for lane in i * stride..(i + 1) * stride {
                cell[lane] = [here.content; LANES];
                cell_apart[lane] = [here.bears; LANES];
                pressed[lane] = area[lane].map(|area| area * here.bears);
                cell_flow[lane] = [here.flow; LANES];
                edge[lane] = [before.content; LANES];
                edge_flow[lane] = [before.flow; LANES];
            }
        }
        if !form.is_plain() || matches!(form.rough_film, RoughFilm::FlowFactors { .. }) {
            for ratios in [&mut self.ratio, &mut self.edge_ratio] {
                for column in ratios.chunks_exact_mut(self.alike) {
                    spread(column, column[0]);
                }
            }
        }
    }
}

/// Gives all cells of a column the same value.
#[inline]
fn spread(values: &mut [f64], value: f64) {
    for lane in values.as_chunks_mut::<LANES>().0 {
        *lane = [value; LANES];
    }
}
