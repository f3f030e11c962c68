//! The gap between journal and bush, in units of the radial clearance.

use nalgebra::Vector2;

use super::grid::Grid;

/// Where the surfaces are: what makes the gap, apart from the eccentricity.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Form {
    /// Eccentricity ratio that the journal's tilt adds at `zeta = 1`.
    pub(super) tilt: Vector2<f64>,
    /// Radial deviation of bush less journal at the columns' middles, in clearances; empty: round.
    pub(super) middle: Vec<f64>,
    /// The same at the edges before the columns.
    pub(super) edge: Vec<f64>,
}

/// The directions of a grid's columns.
#[derive(Clone, Debug)]
pub(super) struct Directions {
    /// The mean of `n` over each column.
    pub(super) mean: Vec<Vector2<f64>>,
    /// `n` at the edge before each column.
    pub(super) edge: Vec<Vector2<f64>>,
}

impl Directions {
    pub(super) fn new(grid: &Grid) -> Self {
        let mean = |i: usize| {
            let (a, b) = (grid.theta_edge(i), grid.theta_edge(i + 1));
            Vector2::new(b.sin() - a.sin(), a.cos() - b.cos()) / (b - a)
        };
        let edge = |i: usize| {
            let (sin, cos) = grid.theta_edge(i).sin_cos();
            Vector2::new(cos, sin)
        };
        Self {
            mean: (0..grid.columns()).map(mean).collect(),
            edge: (0..grid.columns()).map(edge).collect(),
        }
    }
}

/// The gap in every cell and at every edge between columns, column by column.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Gap {
    /// The mean over each cell.
    pub(super) cell: Vec<f64>,
    /// At the edge before each cell, in the middle of its row.
    pub(super) edge: Vec<f64>,
    /// The smallest of all.
    pub(super) smallest: f64,
}

impl Gap {
    /// Computes the gap at the eccentricity ratio `eps` (in the middle plane).
    pub(super) fn update(
        &mut self,
        grid: &Grid,
        directions: &Directions,
        form: &Form,
        eps: Vector2<f64>,
    ) {
        let rows = grid.rows();
        self.cell.clear();
        self.edge.clear();
        self.smallest = f64::INFINITY;
        for (i, (mean, edge)) in directions.mean.iter().zip(&directions.edge).enumerate() {
            let deviation = |of: &[f64]| of.get(i).copied().unwrap_or(0.0);
            let cell = 1.0 - eps.dot(mean) + deviation(&form.middle);
            let before = 1.0 - eps.dot(edge) + deviation(&form.edge);
            let (slope, slope_before) = (form.tilt.dot(mean), form.tilt.dot(edge));
            for j in 0..rows {
                let zeta = 0.5 * (grid.zeta_edge(j) + grid.zeta_edge(j + 1));
                let (h, b) = (cell - zeta * slope, before - zeta * slope_before);
                self.smallest = self.smallest.min(h).min(b);
                self.cell.push(h);
                self.edge.push(b);
            }
        }
    }

    /// The largest share of the step `change` of the eccentricity that leaves at least `rest` of
    /// the gap everywhere.
    pub(super) fn allowed(&self, directions: &Directions, change: Vector2<f64>, rest: f64) -> f64 {
        let rows = self.cell.len() / directions.mean.len();
        let mut share: f64 = 1.0;
        for (i, (mean, edge)) in directions.mean.iter().zip(&directions.edge).enumerate() {
            let (closing, closing_before) = (change.dot(mean), change.dot(edge));
            for at in i * rows..(i + 1) * rows {
                let room = (1.0 - rest) * self.cell[at];
                let room_before = (1.0 - rest) * self.edge[at];
                if closing * share > room {
                    share = room / closing;
                }
                if closing_before * share > room_before {
                    share = room_before / closing_before;
                }
            }
        }
        share
    }
}
