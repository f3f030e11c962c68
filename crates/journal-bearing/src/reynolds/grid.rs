//! The cells on which a film is solved: the angle `theta` around the bush, and `zeta` over half the width.

use nalgebra::Vector2;
use std::f64::consts::PI;

/// A tensor grid of finite-volume cells. `theta` runs once around the bush. `zeta = 2 z / B` runs from the mid-plane (0) to
/// the open end (1) of a bearing that is symmetric about its mid-plane; [`whole_width`](Self::whole_width) mirrors it.
///
/// # Examples
/// ```
/// use journal_bearing::reynolds::Grid;
///
/// let [columns, rows] = Grid::sufficient_cells(0.76);
/// let grid = Grid::standard(columns, rows, 0.76);
/// assert_eq!((grid.columns(), grid.rows()), (96, 8));
/// assert!(grid.zeta_width(7) < grid.zeta_width(0)); // rows crowd at the open end
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Grid {
    /// Cell edges in `theta`, rad; one more than there are columns, spanning exactly one turn.
    theta: Vec<f64>,
    /// Cell edges in `zeta`, from 0 (or -1) to 1; one more than there are rows.
    zeta: Vec<f64>,
}

impl Grid {
    /// Evenly spaced cells, the first edge at `-pi`. The grid has at least 4 columns and 1 row.
    pub fn uniform(columns: usize, rows: usize) -> Self {
        let (columns, rows) = (columns.max(4), rows.max(1));
        Self {
            theta: (0..=columns).map(|i| -PI + 2.0 * PI * i as f64 / columns as f64).collect(),
            zeta: (0..=rows).map(|j| j as f64 / rows as f64).collect(),
        }
    }

    /// Columns and rows with which a [`standard`](Self::standard) grid carries the load of an ever finer one within 0.3 %,
    /// for eccentricity ratios up to 0.97. In a narrow bearing the pressure rises and falls over a shorter angle, but is
    /// close to a parabola over the width.
    pub fn sufficient_cells(width_to_diameter: f64) -> [usize; 2] {
        if width_to_diameter >= 0.6 { [96, 8] } else { [160, 6] }
    }

    /// Cells for a film whose smallest gap may be anywhere: even around the bush, and crowding along the open ends as a
    /// heavily loaded film of a bearing of `width_to_diameter` (`B/D`) needs.
    pub fn standard(columns: usize, rows: usize, width_to_diameter: f64) -> Self {
        Self { zeta: Self::clustered(4, rows, 0.93, width_to_diameter).zeta, ..Self::uniform(columns, 1) }
    }

    /// The same grid mirrored over the whole width, `zeta` from -1 to 1, for a film that is not symmetric. It has twice the
    /// rows.
    pub fn whole_width(&self) -> Self {
        let below = self.zeta.iter().skip(1).rev().map(|z| -z);
        Self { theta: self.theta.clone(), zeta: below.chain(self.zeta.iter().copied()).collect() }
    }

    /// Whether the grid covers the whole width.
    pub fn is_whole_width(&self) -> bool {
        self.zeta[0] < 0.0
    }

    /// Cells that crowd where a film of eccentricity ratio `eccentricity` (0..1, smallest gap at `theta = 0`) varies fast:
    /// around the smallest gap, over the angle `sqrt(1 - e)`, and along the open ends, over a similar length.
    pub fn clustered(columns: usize, rows: usize, eccentricity: f64, width_to_diameter: f64) -> Self {
        let columns = columns.max(4).next_multiple_of(2);
        let rows = rows.max(1);
        let length = (1.0 - eccentricity).max(1e-12).sqrt();
        let half: Vec<f64> =
            (0..=columns / 2).map(|i| stretched_angle(2.0 * i as f64 / columns as f64, 0.25 * length)).collect();
        let theta = half.iter().rev().map(|t| -t).chain(half.iter().skip(1).copied()).collect();
        // The boundary layer at the end is about as wide as the narrow gap is long. Stretching by tanh puts about half of
        // the rows into it.
        let layer = (2.0 * length / width_to_diameter).min(1.0);
        let a = 0.3 + 0.55 * (1.0 / layer).asinh();
        let zeta = (0..=rows).map(|j| (a * j as f64 / rows as f64).tanh() / a.tanh()).collect();
        Self { theta, zeta }
    }

    /// Number of cells around the bush.
    pub fn columns(&self) -> usize {
        self.theta.len() - 1
    }

    /// Number of cells over the half width, or over the whole width after [`whole_width`](Self::whole_width).
    pub fn rows(&self) -> usize {
        self.zeta.len() - 1
    }

    /// The edge before column `i` (`0..=columns`), rad.
    pub fn theta_edge(&self, i: usize) -> f64 {
        self.theta[i]
    }

    /// The middle of column `i`, rad.
    pub fn theta_centre(&self, i: usize) -> f64 {
        0.5 * (self.theta[i] + self.theta[i + 1])
    }

    /// The angular width of column `i`, rad.
    pub fn theta_width(&self, i: usize) -> f64 {
        self.theta[i + 1] - self.theta[i]
    }

    /// The integral over column `i` of the direction from the bush's axis to the film.
    pub(crate) fn normal(&self, i: usize) -> Vector2<f64> {
        let (a, b) = (self.theta[i], self.theta[i + 1]);
        Vector2::new(b.sin() - a.sin(), a.cos() - b.cos())
    }

    /// The edge before row `j` (`0..=rows`).
    pub fn zeta_edge(&self, j: usize) -> f64 {
        self.zeta[j]
    }

    /// The width of row `j`, as a share of the half width.
    pub fn zeta_width(&self, j: usize) -> f64 {
        self.zeta[j + 1] - self.zeta[j]
    }

    /// The distance between the middles of rows `j - 1` and `j`, for `j` in `1..rows`.
    pub(crate) fn zeta_distance(&self, j: usize) -> f64 {
        0.5 * (self.zeta[j + 1] - self.zeta[j - 1])
    }

    /// The distance in `zeta` over which the pressure falls from the outermost row to the open end.
    ///
    /// With it the discrete solution of `p'' = -1`, the parabola of a short bearing, has its exact mean 1/3, provided that
    /// the distance lies between a third and a half of the row. On even rows it does. On strongly stretched grids the
    /// outermost row is so narrow that the clamped value is accurate enough.
    pub(crate) fn end_distance(&self) -> f64 {
        let inside: f64 = (1..self.rows())
            .filter(|&j| self.zeta[j] > 0.0)
            .map(|j| self.zeta[j].powi(2) * self.zeta_distance(j))
            .sum();
        let outermost = self.zeta_width(self.rows() - 1);
        (1.0 / 3.0 - inside).clamp(outermost / 3.0, outermost / 2.0)
    }
}

/// The angle at `s` (0..1) of a spacing that is half even and half logarithmic beyond `core`, by bisection.
fn stretched_angle(s: f64, core: f64) -> f64 {
    if s >= 1.0 {
        return PI;
    }
    let scale = (1.0 / core).asinh();
    let position = |t: f64| 0.5 * t / PI + 0.5 * ((0.25 * t).tan() / core).asinh() / scale;
    let (mut low, mut high) = (0.0, PI);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if position(middle) < s {
            low = middle;
        } else {
            high = middle;
        }
    }
    0.5 * (low + high)
}
