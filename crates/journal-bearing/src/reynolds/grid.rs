//! The cells on which the film is solved: angle `theta` around the bush, `zeta` over half the width.

use std::f64::consts::PI;

/// A tensor grid of finite-volume cells over one half of a bearing that is symmetric about its
/// mid-plane: `theta` runs once around the bush, `zeta = 2 z / B` from the mid-plane (0) to the
/// open end (1).
#[derive(Clone, Debug, PartialEq)]
pub struct Grid {
    /// Cell edges in `theta`, rad; one more than there are columns, spanning exactly one turn.
    theta: Vec<f64>,
    /// Cell edges in `zeta`, from 0 to 1; one more than there are rows.
    zeta: Vec<f64>,
}

impl Grid {
    /// Evenly spaced cells, the first edge at `-pi`.
    ///
    /// At least 4 columns and 1 row are made, whatever is asked for.
    pub fn uniform(columns: usize, rows: usize) -> Self {
        let (columns, rows) = (columns.max(4), rows.max(1));
        Self {
            theta: (0..=columns)
                .map(|i| -PI + 2.0 * PI * i as f64 / columns as f64)
                .collect(),
            zeta: (0..=rows).map(|j| j as f64 / rows as f64).collect(),
        }
    }

    /// How many columns and rows bring a [`standard`](Self::standard) grid within 0.3 % of the load
    /// on an ever finer one, for eccentricity ratios up to 0.97: a narrow bearing's pressure rises
    /// and falls over a shorter angle, but is close to a parabola over the width.
    pub fn sufficient_cells(width_to_diameter: f64) -> [usize; 2] {
        if width_to_diameter >= 0.6 {
            [96, 8]
        } else {
            [160, 6]
        }
    }

    /// Cells for a film whose smallest gap may be anywhere: even around the bush, and crowding along
    /// the open ends as fits the heavily loaded film of a bearing of `width_to_diameter`.
    pub fn standard(columns: usize, rows: usize, width_to_diameter: f64) -> Self {
        Self {
            zeta: Self::clustered(4, rows, 0.93, width_to_diameter).zeta,
            ..Self::uniform(columns, 1)
        }
    }

    /// The grid over the whole width, `zeta` from -1 to 1, for a film that is not symmetric. It has
    /// twice the rows.
    pub fn whole_width(&self) -> Self {
        let below = self.zeta.iter().skip(1).rev().map(|z| -z);
        Self {
            theta: self.theta.clone(),
            zeta: below.chain(self.zeta.iter().copied()).collect(),
        }
    }

    /// Whether the grid reaches over the whole width.
    pub fn is_whole_width(&self) -> bool {
        self.zeta[0] < 0.0
    }

    /// Cells that crowd where a film of eccentricity ratio `eccentricity` (0..1, smallest gap at
    /// `theta = 0`) varies fast: around the smallest gap, over the angle `sqrt(1 - e)`, and along
    /// the open ends, over a like length.
    pub fn clustered(
        columns: usize,
        rows: usize,
        eccentricity: f64,
        width_to_diameter: f64,
    ) -> Self {
        let columns = columns.max(4).next_multiple_of(2);
        let rows = rows.max(1);
        let length = (1.0 - eccentricity).max(1e-12).sqrt();
        let half: Vec<f64> = (0..=columns / 2)
            .map(|i| stretched_angle(2.0 * i as f64 / columns as f64, 0.25 * length))
            .collect();
        let theta = half
            .iter()
            .rev()
            .map(|t| -t)
            .chain(half.iter().skip(1).copied())
            .collect();
        // The end's boundary layer is about as wide as the gap is long; tanh stretching puts
        // about as many rows into it as outside.
        let layer = (2.0 * length / width_to_diameter).min(1.0);
        let a = 0.3 + 0.55 * (1.0 / layer).asinh();
        let zeta = (0..=rows)
            .map(|j| (a * j as f64 / rows as f64).tanh() / a.tanh())
            .collect();
        Self { theta, zeta }
    }

    /// Number of cells around the bush.
    pub fn columns(&self) -> usize {
        self.theta.len() - 1
    }

    /// Number of cells over the half width.
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

    /// The distance over which the pressure of the outermost row falls to that of the open end.
    ///
    /// It is chosen so that the discrete solution of `p'' = -1`, the parabola of a short bearing,
    /// has its exact mean 1/3, where that takes a distance from a third to a half of the row: on
    /// even rows it does; on strongly stretched ones the outermost row is narrow enough as it is.
    pub(crate) fn end_distance(&self) -> f64 {
        let inside: f64 = (1..self.rows())
            .filter(|&j| self.zeta[j] > 0.0)
            .map(|j| self.zeta[j].powi(2) * self.zeta_distance(j))
            .sum();
        let outermost = self.zeta_width(self.rows() - 1);
        (1.0 / 3.0 - inside).clamp(outermost / 3.0, outermost / 2.0)
    }
}

/// The angle at `s` (0..1) of a spacing that is, in equal parts, even and logarithmic beyond `core`.
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
