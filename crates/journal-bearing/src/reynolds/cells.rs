//! The film's cells: what does not change while it is solved.

use std::ops::Range;

use super::block::LANES;
use super::gap::Directions;
use super::grid::Grid;

/// What happens to oil where the film ruptures.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub enum Cavitation {
    /// Its mass is conserved: the film reforms when enough has flowed in.
    #[default]
    MassConserving,
    /// It is not asked for: `p >= 0`, and oil is at hand wherever the pressure rises.
    NonNegative,
}

/// The cells' geometry.
///
/// Cells are stored column by column, each column padded to `stride` rows, a multiple of [`LANES`]. Padding
/// cells have neither area nor conductance, so they take part in nothing.
#[derive(Clone, Debug)]
pub(super) struct Cells {
    pub(super) grid: Grid,
    pub(super) directions: Directions,
    pub(super) cavitation: Cavitation,
    /// Rows of a column with its padding.
    pub(super) stride: usize,
    /// The middle of each row.
    pub(super) zeta: Vec<f64>,
    /// Components of the directions of the cells and of the edges before them.
    pub(super) normal_x: Normal,
    pub(super) normal_y: Normal,
    /// Share of the developed area (angle times share of width) of each cell.
    pub(super) area: Vec<f64>,
    /// Share of the width of each cell.
    pub(super) share: Vec<f64>,
    /// Conductance, at `H = 1`, of the edge to the column before each cell.
    pub(super) along: Vec<f64>,
    /// Conductance, at `H = 1`, of the edge to the row below each cell; with one more at the end, zero.
    pub(super) across: Vec<f64>,
    /// Conductance, at `H = 1`, to the open end or ends.
    pub(super) open: Vec<f64>,
}

/// A component of the directions of the cells (their means) and of the edges before them.
#[derive(Clone, Debug)]
pub(super) struct Normal {
    pub(super) mean: Vec<f64>,
    pub(super) edge: Vec<f64>,
}

impl Normal {
    fn new(cells: usize) -> Self {
        Self {
            mean: vec![0.0; cells],
            edge: vec![0.0; cells],
        }
    }
}

impl Cells {
    pub(super) fn new(grid: Grid, width_to_diameter: f64, cavitation: Cavitation) -> Self {
        let (columns, rows) = (grid.columns(), grid.rows());
        let stride = rows.next_multiple_of(LANES);
        let length = grid.zeta_edge(rows) - grid.zeta_edge(0);
        let scale = width_to_diameter.powi(-2) / length;
        let end = scale / grid.end_distance();
        let count = columns * stride;
        let mut cells = Self {
            directions: Directions::new(&grid),
            cavitation,
            stride,
            zeta: vec![0.0; stride],
            normal_x: Normal::new(count),
            normal_y: Normal::new(count),
            area: vec![0.0; count],
            share: vec![0.0; count],
            along: vec![0.0; count],
            across: vec![0.0; count + 1],
            open: vec![0.0; count],
            grid,
        };
        let grid = &cells.grid;
        for j in 0..rows {
            cells.zeta[j] = 0.5 * (grid.zeta_edge(j) + grid.zeta_edge(j + 1));
        }
        for i in 0..columns {
            let width = grid.theta_width(i);
            let distance = 0.5 * (grid.theta_width((i + columns - 1) % columns) + width);
            for j in 0..rows {
                let cell = i * stride + j;
                let (mean, edge) = (cells.directions.mean[i], cells.directions.edge[i]);
                (cells.normal_x.mean[cell], cells.normal_x.edge[cell]) = (mean.x, edge.x);
                (cells.normal_y.mean[cell], cells.normal_y.edge[cell]) = (mean.y, edge.y);
                let share = grid.zeta_width(j) / length;
                cells.share[cell] = share;
                cells.area[cell] = width * share;
                cells.along[cell] = share / distance;
                if j > 0 {
                    cells.across[cell] = width * scale / grid.zeta_distance(j);
                }
                let ends = [j + 1 == rows, j == 0 && grid.is_whole_width()];
                cells.open[cell] = width * end * ends.map(f64::from).iter().sum::<f64>();
            }
        }
        cells
    }

    /// The number of cells, padding included.
    pub(super) fn count(&self) -> usize {
        self.area.len()
    }

    pub(super) fn conserves_mass(&self) -> bool {
        self.cavitation == Cavitation::MassConserving
    }

    /// Columns and the ranges of their cells.
    pub(super) fn columns(&self) -> impl Iterator<Item = (usize, Range<usize>)> {
        let stride = self.stride;
        (0..self.grid.columns()).map(move |i| (i, i * stride..(i + 1) * stride))
    }

    /// The column before (around the ring) of a column.
    pub(super) fn before(&self, column: usize) -> usize {
        let columns = self.grid.columns();
        (column + columns - 1) % columns
    }

    /// The column after a column.
    pub(super) fn after(&self, column: usize) -> usize {
        (column + 1) % self.grid.columns()
    }

    /// The ring's pairs of neighbouring columns, as long ranges of cells and, where the ring closes, short ones: each
    /// with the range of the cells in the columns before.
    pub(super) fn neighbours(&self) -> [(Range<usize>, Range<usize>); 2] {
        let (stride, count) = (self.stride, self.count());
        [
            (stride..count, 0..count - stride),
            (0..stride, count - stride..count),
        ]
    }
}
