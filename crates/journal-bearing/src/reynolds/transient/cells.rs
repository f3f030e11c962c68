//! The film's cells: geometry that stays the same while the film is solved.

use std::ops::Range;

use nalgebra::Vector2;

use crate::reynolds::{feed::Feed, grid::Grid, lanes::LANES, settings::Cavitation};

/// The conductance to a feed's supply over those to its neighbours: the pressure in a feed is the supply's but for this part of a
/// pressure difference between cells.
const SUPPLY: f64 = 1e4;
/// Most by which a feed's edge raises the conductance to a cell's middle next to it.
const CLOSEST: f64 = 20.0;

/// The cells' geometry.
///
/// Cells are stored column by column. Each column is padded to `stride` rows, a multiple of [`LANES`]. Padding cells have
/// neither area nor conductance, so they contribute nothing.
#[derive(Clone, Debug)]
pub struct Cells {
    pub grid: Grid,
    pub directions: Directions,
    pub cavitation: Cavitation,
    /// Rows of a column, padding included.
    pub stride: usize,
    /// `zeta` at the middle of each row.
    pub zeta: Vec<f64>,
    /// Both components of `n` by cell and edge: the [`Directions`] repeated for every row.
    pub normal: [Normal; 2],
    /// Area of each cell: its angle times its share of the width.
    pub area: Vec<f64>,
    /// Each cell's share of the width.
    pub share: Vec<f64>,
    /// Conductance, at `H = 1`, of the edge to the column before each cell.
    pub along: Vec<f64>,
    /// Conductance, at `H = 1`, of the edge to the row below each cell; one more at the end, zero.
    pub across: Vec<f64>,
    /// Conductance, at `H = 1`, of each cell to the open end or ends.
    pub open: Vec<f64>,
    /// Conductance of each cell to the supply of a feed; empty without feeds.
    pub feed: Vec<f64>,
    /// Area of each cell on which the film is sheared: none in a feed.
    pub land: Vec<f64>,
}

/// One component of `n`: its mean over each cell, and at the edge before each cell.
#[derive(Clone, Debug)]
pub struct Normal {
    pub mean: Vec<f64>,
    pub edge: Vec<f64>,
}

impl Normal {
    fn new(cells: usize) -> Self {
        Self { mean: vec![0.0; cells], edge: vec![0.0; cells] }
    }
}

/// The direction `n` of each column of a grid.
#[derive(Clone, Debug)]
pub struct Directions {
    /// The mean of `n` over each column.
    pub mean: Vec<Vector2<f64>>,
    /// `n` at the edge before each column.
    pub edge: Vec<Vector2<f64>>,
}

impl Directions {
    fn new(grid: &Grid) -> Self {
        let mean = |i: usize| grid.normal(i) / grid.theta_width(i);
        let edge = |i: usize| {
            let (sin, cos) = grid.theta_edge(i).sin_cos();
            Vector2::new(cos, sin)
        };
        Self { mean: (0..grid.columns()).map(mean).collect(), edge: (0..grid.columns()).map(edge).collect() }
    }
}

impl Cells {
    /// The cells of a grid in a bearing of `B/D`.
    pub fn new(grid: Grid, width_to_diameter: f64, cavitation: Cavitation) -> Self {
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
            normal: [Normal::new(count), Normal::new(count)],
            area: vec![0.0; count],
            share: vec![0.0; count],
            along: vec![0.0; count],
            across: vec![0.0; count + 1],
            open: vec![0.0; count],
            feed: Vec::new(),
            land: Vec::new(),
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
                for (k, normal) in cells.normal.iter_mut().enumerate() {
                    normal.mean[cell] = cells.directions.mean[i][k];
                    normal.edge[cell] = cells.directions.edge[i][k];
                }
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
        cells.land.clone_from(&cells.area);
        cells
    }

    /// Makes feeds of all cells whose middle lies in one, in a bearing of this width, m. Returns how many these are.
    ///
    /// The film begins at a feed's edge, wherever that is between two cells' middles.
    pub fn dig(&mut self, feed: &Feed, width: f64) -> usize {
        let (columns, rows) = (self.grid.columns(), self.grid.rows());
        let place = |i: usize, j: usize| (self.grid.theta_centre(i), 0.5 * width * self.zeta[j]);
        let fed = |i: usize, j: usize| {
            let (theta, z) = place(i, j);
            feed.covers(theta, z)
        };
        // The distance between two middles over that of the one in the film from the edge.
        let nearer = |whole: f64, rest: f64| (whole / rest).clamp(1.0, CLOSEST);
        self.feed = vec![0.0; self.count()];
        let mut dug = 0;
        for i in 0..columns {
            let before = self.before(i);
            let apart = 0.5 * (self.grid.theta_width(before) + self.grid.theta_width(i));
            for j in 0..rows {
                let cell = i * self.stride + j;
                let here = fed(i, j);
                if here {
                    dug += 1;
                    self.feed[cell] = SUPPLY * (self.along[cell] + self.across[cell]);
                    self.open[cell] = 0.0;
                }
                self.land[cell] *= 1.0 - self.share_in(feed, width, [i, j]);
                if here != fed(before, j) {
                    let (theta, z) = place(if here { before } else { i }, j);
                    self.along[cell] *= nearer(apart, feed.gap_around(theta, z));
                }
                if j > 0 && here != fed(i, j - 1) {
                    let (theta, z) = place(i, if here { j - 1 } else { j });
                    let apart = 0.5 * width * self.grid.zeta_distance(j);
                    self.across[cell] *= nearer(apart, feed.gap_along(theta, z));
                }
            }
        }
        dug
    }

    /// The share of a cell's area that lies in a feed.
    fn share_in(&self, feed: &Feed, width: f64, [i, j]: [usize; 2]) -> f64 {
        const POINTS: usize = 16;
        let along = |from: f64, to: f64, k: usize| from + (to - from) * (k as f64 + 0.5) / POINTS as f64;
        let (grid, half) = (&self.grid, 0.5 * width);
        let thetas = [grid.theta_edge(i), grid.theta_edge(i + 1)];
        let ends = [half * grid.zeta_edge(j), half * grid.zeta_edge(j + 1)];
        let covered = |k: usize| {
            let theta = along(thetas[0], thetas[1], k / POINTS);
            feed.covers(theta, along(ends[0], ends[1], k % POINTS))
        };
        let inside = (0..POINTS * POINTS).filter(|&k| covered(k)).count();
        inside as f64 / (POINTS * POINTS) as f64
    }

    /// Number of cells, padding included.
    pub fn count(&self) -> usize {
        self.area.len()
    }

    /// Whether cells without pressure keep account of their oil.
    pub fn conserves_mass(&self) -> bool {
        self.cavitation == Cavitation::MassConserving
    }

    /// Each column with the range of its cells.
    pub fn columns(&self) -> impl Iterator<Item = (usize, Range<usize>)> {
        let stride = self.stride;
        (0..self.grid.columns()).map(move |i| (i, i * stride..(i + 1) * stride))
    }

    /// The column before a column, around the ring.
    pub fn before(&self, column: usize) -> usize {
        let columns = self.grid.columns();
        (column + columns - 1) % columns
    }

    /// The column after a column, around the ring.
    pub fn after(&self, column: usize) -> usize {
        (column + 1) % self.grid.columns()
    }

    /// All pairs of neighbouring columns as two pairs of ranges (cells, cells of the columns before them): a long pair for
    /// the ring up to its seam, and a short one across the seam.
    pub fn neighbours(&self) -> [(Range<usize>, Range<usize>); 2] {
        let (stride, count) = (self.stride, self.count());
        [(stride..count, 0..count - stride), (0..stride, count - stride..count)]
    }

    /// The smallest gap that the grid resolves: the variation of the gap over half a column at its narrowest point.
    pub fn resolved_gap(&self) -> f64 {
        0.5 * (0.5 * self.grid.theta_width(0)).powi(2)
    }
}
