//! The gap between journal and bush, in units of the radial clearance.

use nalgebra::Vector2;

use super::cells::Cells;
use crate::reynolds::lanes::smallest;
use crate::reynolds::roughness::mean_gap;

/// All that shapes the gap apart from the eccentricity.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Form {
    /// Eccentricity ratio that the journal's tilt adds at `zeta = 1`.
    pub tilt: Vector2<f64>,
    /// Radial deviation of the bush less that of the journal at the columns' middles, in clearances; empty when round.
    pub middle: Vec<f64>,
    /// The same at the edges before the columns.
    pub edge: Vec<f64>,
    /// Roughness over clearance of surfaces whose film sees their mean gap; zero when smooth.
    pub roughness: f64,
}

impl Form {
    /// Whether both surfaces are round, aligned and smooth.
    pub fn is_plain(&self) -> bool {
        self.tilt == Vector2::zeros() && self.middle.is_empty() && self.roughness == 0.0
    }
}

/// The gap in every cell and at every edge between columns, column by column.
#[derive(Clone, Debug, PartialEq)]
pub struct Gap {
    /// Mean over each cell.
    pub cell: Vec<f64>,
    /// At the edge before each cell, in the middle of its row.
    pub edge: Vec<f64>,
    /// Derivative of `cell` over the distance of the mean planes: the share of the area where rough surfaces do not touch;
    /// one for smooth surfaces.
    pub cell_apart: Vec<f64>,
    /// The same of `edge`.
    pub edge_apart: Vec<f64>,
    /// Film ratio of rough surfaces in each cell and at each edge: distance of the mean planes over the roughness. Unused for
    /// smooth surfaces.
    pub ratio: Vec<f64>,
    pub edge_ratio: Vec<f64>,
    /// Area on which the film's pressure acts, per cell.
    pub pressed: Vec<f64>,
    /// The smallest gap of all cells and edges.
    pub smallest: f64,
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
            ratio: vec![0.0; cells.count()],
            edge_ratio: vec![0.0; cells.count()],
            pressed: cells.area.clone(),
            smallest: 1.0,
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
        if form.roughness > 0.0 {
            self.fill_valleys(cells, form.roughness);
        }
        self.smallest = if form.is_plain() {
            // The narrowest point may lie between two grid points.
            1.0 - eps.norm()
        } else {
            smallest(&self.cell).min(smallest(&self.edge))
        };
    }

    /// Replaces the distances of rough surfaces by their mean gaps.
    fn fill_valleys(&mut self, cells: &Cells, roughness: f64) {
        let of_cells = (&mut self.cell, &mut self.ratio, &mut self.cell_apart);
        let of_edges = (&mut self.edge, &mut self.edge_ratio, &mut self.edge_apart);
        for (gap, ratio, apart) in [of_cells, of_edges] {
            for ((gap, ratio), apart) in gap.iter_mut().zip(ratio).zip(apart) {
                *ratio = *gap / roughness;
                let [mean, slope] = mean_gap(*ratio);
                (*gap, *apart) = (mean * roughness, slope);
            }
        }
        let areas = cells.area.iter().zip(&self.cell_apart);
        for (pressed, (area, apart)) in self.pressed.iter_mut().zip(areas) {
            *pressed = area * apart;
        }
    }
}
