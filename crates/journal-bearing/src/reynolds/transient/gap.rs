//! The gap between journal and bush, in units of the radial clearance.

use nalgebra::Vector2;

use super::cells::Cells;
use crate::reynolds::lanes::smallest;
use crate::roughness::{NO_CONTACT, RoughFilm};

/// All that shapes the gap apart from the eccentricity.
#[derive(Clone, Debug, Default, PartialEq)]
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

    /// The gap of content that the film has at a distance of the mean planes, and its slope, in clearances.
    pub fn content(&self, distance: f64) -> [f64; 2] {
        if !self.feels(distance) {
            return [distance, 1.0];
        }
        let [[content, apart], _] = self.rough_film.gaps(distance / self.roughness);
        [content * self.roughness, apart]
    }
}

/// The gap in every cell and at every edge between columns, column by column.
#[derive(Clone, Debug, PartialEq)]
pub struct Gap {
    /// Content per area of a full film: mean over each cell.
    pub cell: Vec<f64>,
    /// The same at the edge before each cell, in the middle of its row.
    pub edge: Vec<f64>,
    /// Derivative of `cell` over the distance of the mean planes: the share of the area on which the film bears; one for
    /// smooth surfaces.
    pub cell_apart: Vec<f64>,
    /// The same of `edge`.
    pub edge_apart: Vec<f64>,
    /// The gap whose third power the flow goes with, and its derivative over the distance of the mean planes.
    pub cell_flow: Vec<f64>,
    pub cell_flow_apart: Vec<f64>,
    /// The same at the edges.
    pub edge_flow: Vec<f64>,
    pub edge_flow_apart: Vec<f64>,
    /// Film ratio of rough surfaces in each cell and at each edge: distance of the mean planes over the roughness. Unused
    /// while the film does not feel the roughness.
    pub ratio: Vec<f64>,
    pub edge_ratio: Vec<f64>,
    /// Area on which the film's pressure acts, per cell.
    pub pressed: Vec<f64>,
    /// The smallest gap of all cells and edges.
    pub smallest: f64,
    /// Whether the film feels the surfaces' roughness anywhere.
    pub rough: bool,
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
        }
    }

    /// Computes the gap at the eccentricity ratio `eps` of the middle plane.
    pub fn update(&mut self, cells: &Cells, form: &Form, eps: Vector2<f64>) {
        let columns = self.cell.chunks_exact_mut(cells.stride);
        let columns = columns.zip(self.edge.chunks_exact_mut(cells.stride));
        for (i, (cell, edge)) in columns.enumerate() {
            let (n, n_edge) = (cells.directions.mean[i], cells.directions.edge[i]);
            let deviation = |of: &[f64]| of.get(i).copied().unwrap_or(0.0);
            cell.fill(1.0 - eps.dot(&n) + deviation(&form.middle));
            edge.fill(1.0 - eps.dot(&n_edge) + deviation(&form.edge));
            if form.tilt != Vector2::zeros() {
                let (slope, slope_edge) = (form.tilt.dot(&n), form.tilt.dot(&n_edge));
                for ((cell, edge), zeta) in cell.iter_mut().zip(edge).zip(&cells.zeta) {
                    *cell -= zeta * slope;
                    *edge -= zeta * slope_edge;
                }
            }
        }
        self.smallest = if form.is_plain() {
            // The narrowest point may lie between two grid points.
            1.0 - eps.norm()
        } else {
            smallest(&self.cell).min(smallest(&self.edge))
        };
        let was_rough = self.rough;
        self.rough = form.feels(self.smallest);
        if self.rough {
            self.smallest = form.content(self.smallest)[0];
            self.roughen(cells, form);
            return;
        }
        if was_rough {
            let aparts = [
                &mut self.cell_apart,
                &mut self.edge_apart,
                &mut self.cell_flow_apart,
                &mut self.edge_flow_apart,
            ];
            for apart in aparts {
                apart.fill(1.0);
            }
            self.pressed.copy_from_slice(&cells.area);
        }
        self.cell_flow.copy_from_slice(&self.cell);
        self.edge_flow.copy_from_slice(&self.edge);
    }

    /// Replaces the distances of rough surfaces by the gaps that the film sees.
    fn roughen(&mut self, cells: &Cells, form: &Form) {
        let per_roughness = 1.0 / form.roughness;
        // The gap is the same over the width of an aligned bearing.
        let alike = if form.tilt == Vector2::zeros() {
            cells.stride
        } else {
            1
        };
        let of_cells = [
            &mut self.cell,
            &mut self.cell_apart,
            &mut self.cell_flow,
            &mut self.cell_flow_apart,
            &mut self.ratio,
        ];
        let of_edges = [
            &mut self.edge,
            &mut self.edge_apart,
            &mut self.edge_flow,
            &mut self.edge_flow_apart,
            &mut self.edge_ratio,
        ];
        for [gap, apart, flow, flow_apart, ratios] in [of_cells, of_edges] {
            for first in (0..gap.len()).step_by(alike) {
                let range = first..first + alike;
                let distance = gap[first];
                let ratio = distance * per_roughness;
                ratios[range.clone()].fill(ratio);
                let [[content, bears], [passed, widens]] = form.rough_film.gaps(ratio);
                gap[range.clone()].fill(content * form.roughness);
                apart[range.clone()].fill(bears);
                flow[range.clone()].fill(passed * form.roughness);
                flow_apart[range].fill(widens);
            }
        }
        let areas = cells.area.iter().zip(&self.cell_apart);
        for (pressed, (area, apart)) in self.pressed.iter_mut().zip(areas) {
            *pressed = area * apart;
        }
    }
}
