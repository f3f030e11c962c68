//! The quasi-static film: its pressure is nowhere below ambient, and it has no memory.
//!
//! Where the film would be in tension it carries nothing, and its oil content is not tracked. Position and extent of the
//! pressure field follow from the complementarity `P >= 0`, `A P - b >= 0`, `P (A P - b) = 0`: at both ends of the field,
//! pressure and pressure gradient are zero (the Swift-Stieber or Reynolds condition, at both ends). The primal-dual
//! active-set method solves it, a semismooth Newton method (Hintermueller, Ito & Kunisch 2003, SIAM J. Optim. 13), with a
//! direct factorisation over the cells under pressure only.

use std::f64::consts::PI;

use nalgebra::Vector2;
use thiserror::Error;

mod skyline;
#[cfg(test)]
mod tests;

use super::grid::Grid;
use skyline::Skyline;

/// Where the pressure field may begin.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Boundary {
    /// Anywhere: complementarity at both ends. The natural condition for squeeze; the mobility map uses it.
    #[default]
    Free,
    /// At `theta = -pi`, where `p = 0`: the largest gap when `eps` lies along `+x`. This is the condition of Raimondi &
    /// Boyd (1958) and DIN 31652, for comparison with their tables.
    Seam,
}

/// The solved film, in the dimensionless quantities of [`reynolds`](super).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Carried {
    /// The squeeze velocity `v = d eps/dt - omega z x eps`, 1/s.
    pub velocity: Vector2<f64>,
    /// The external load `W` that the pressure balances, 1/s.
    pub load: Vector2<f64>,
    /// The largest pressure `P`, 1/s.
    pub max_pressure: f64,
    /// The integral of `-H^3 dP/dzeta` over the open end `zeta = 1`, 1/s.
    pub end_flow: f64,
}

impl Carried {
    /// The Sommerfeld number `S = eta N D B (R/c)^2 / F`, 1, of a journal that turns in a resting bush: `rotation` is the
    /// mean rotation, half the journal's speed, rad/s, and `N` the journal's speed in revolutions per second.
    pub fn sommerfeld_number(&self, rotation: f64) -> f64 {
        rotation / (6.0 * PI * self.load.norm())
    }
}

/// The active-set iteration did not settle within the number of passes given.
#[derive(Clone, Copy, Debug, Error, PartialEq, Eq)]
#[error("the film's pressure field did not settle within {0} iterations")]
pub struct NotConverged(usize);

/// The quasi-static film on a [`Grid`]. It starts each solution from its last pressure field.
///
/// # Examples
/// The Sommerfeld number of a full bearing with `B/D = 1` at eccentricity ratio 0.6 is 0.121 (Raimondi & Boyd 1958):
/// ```
/// use journal_bearing::nalgebra::Vector2;
/// use journal_bearing::reynolds::{Boundary, Grid, QuasiStatic};
///
/// let (e, rotation) = (0.6, 1.0);
/// let mut film = QuasiStatic::new(Grid::standard(96, 8, 1.0), 1.0, Boundary::Seam);
/// film.place(Vector2::new(e, 0.0));
/// // At rest, d eps/dt = 0 and v = -omega z x eps.
/// let carried = film.load_at(Vector2::new(0.0, -rotation * e))?;
/// assert!((carried.sommerfeld_number(rotation) - 0.121).abs() < 0.002);
/// // The attitude angle, from the load to the eccentricity, is 50.6 degrees.
/// let attitude = -carried.load.y.atan2(carried.load.x);
/// assert!((attitude.to_degrees() - 50.6).abs() < 1.0);
/// # Ok::<(), journal_bearing::reynolds::NotConverged>(())
/// ```
#[derive(Clone, Debug)]
pub struct QuasiStatic {
    grid: Grid,
    boundary: Boundary,
    /// `(D/B)^2`.
    slenderness: f64,
    /// The integral of `n` over each column.
    normal: Vec<Vector2<f64>>,
    /// Conductance between column `i - 1` and `i`, per `zeta`.
    along: Vec<f64>,
    /// `(D/B)^2` times the integral of `H^3` over each column.
    across: Vec<f64>,
    /// Reciprocal distances between rows; the last is to the open end.
    inverse_distance: Vec<f64>,
    /// `P`, 1/s, column by column.
    pressure: Vec<f64>,
    /// Which cells are under pressure.
    full: Vec<bool>,
    /// A full cell's number in the linear system; `usize::MAX` for the others.
    number: Vec<usize>,
    matrix: Skyline,
    /// Pressures of the full cells at unit velocities along x and y.
    unit: Vec<[f64; 2]>,
    /// The columns in the order in which they are eliminated.
    order: Vec<usize>,
}

/// Most passes of an iteration; ordinary ones need a few.
const LIMIT: usize = 200;

impl QuasiStatic {
    /// A film on `grid` (over the half width) in a bearing of `width_to_diameter` (`B/D > 0`), with the journal in the
    /// middle.
    pub fn new(grid: Grid, width_to_diameter: f64, boundary: Boundary) -> Self {
        let (columns, rows) = (grid.columns(), grid.rows());
        let normal = (0..columns)
            .map(|i| {
                let (a, b) = (grid.theta_edge(i), grid.theta_edge(i + 1));
                Vector2::new(b.sin() - a.sin(), a.cos() - b.cos())
            })
            .collect();
        let inverse_distance = (1..rows)
            .map(|j| 1.0 / grid.zeta_distance(j))
            .chain([1.0 / grid.end_distance()])
            .collect();
        let cells = columns * rows;
        let mut film = Self {
            boundary,
            slenderness: width_to_diameter.powi(-2),
            normal,
            along: vec![0.0; columns],
            across: vec![0.0; columns],
            inverse_distance,
            pressure: vec![0.0; cells],
            full: vec![false; cells],
            number: vec![0; cells],
            matrix: Skyline::default(),
            unit: Vec::with_capacity(cells),
            order: Vec::with_capacity(columns),
            grid,
        };
        film.place(Vector2::zeros());
        film
    }

    /// Puts the journal of a round, aligned bearing at the eccentricity ratio `eps`, `|eps| < 1`.
    pub fn place(&mut self, eps: Vector2<f64>) {
        self.shape(|theta| 1.0 - eps.x * theta.cos() - eps.y * theta.sin());
    }

    /// Gives the film the gap `H(theta) > 0`.
    pub fn shape(&mut self, gap: impl Fn(f64) -> f64) {
        let columns = self.grid.columns();
        let mut before = gap(self.grid.theta_edge(0)).powi(3);
        for i in 0..columns {
            let previous = self.grid.theta_width((i + columns - 1) % columns);
            let width = self.grid.theta_width(i);
            self.along[i] = 2.0 * before / (previous + width);
            let after = gap(self.grid.theta_edge(i + 1)).powi(3);
            let middle = gap(self.grid.theta_centre(i)).powi(3);
            // Simpson's rule: exact for the cubic that H^3 nearly is over one cell.
            self.across[i] = self.slenderness * width * (before + 4.0 * middle + after) / 6.0;
            before = after;
        }
    }

    /// The grid.
    pub fn grid(&self) -> &Grid {
        &self.grid
    }

    /// The pressure `P` of column `i`, row `j`, 1/s.
    pub fn pressure(&self, i: usize, j: usize) -> f64 {
        self.pressure[i * self.grid.rows() + j]
    }

    /// Solves for the load that the film carries at a squeeze velocity `v = d eps/dt - omega z x eps`, 1/s.
    ///
    /// # Errors
    /// Returns [`NotConverged`] when the set of cells under pressure does not settle.
    pub fn load_at(&mut self, v: Vector2<f64>) -> Result<Carried, NotConverged> {
        self.settle(v, |_| v)
    }

    /// Solves for the squeeze velocity at which the film carries the load `W`, 1/s.
    ///
    /// # Errors
    /// Returns [`NotConverged`] when the set of cells under pressure does not settle.
    pub fn velocity_under(&mut self, load: Vector2<f64>) -> Result<Carried, NotConverged> {
        if load == Vector2::zeros() {
            return self.load_at(load);
        }
        self.settle(load, |response| {
            response
                .try_inverse()
                .map_or(load, |compliance| compliance * load)
        })
    }

    /// Forgets the last pressure field, so that the next solution starts cold.
    pub fn reset(&mut self) {
        self.full.fill(false);
        self.pressure.fill(0.0);
    }

    /// Iterates on the set of full cells. `towards` is a guess at the direction of the pressure field; `velocity` computes
    /// the velocity from the present set's response `dW/dv`.
    fn settle(
        &mut self,
        towards: Vector2<f64>,
        velocity: impl Fn(nalgebra::Matrix2<f64>) -> Vector2<f64>,
    ) -> Result<Carried, NotConverged> {
        let rows = self.grid.rows();
        if towards == Vector2::zeros() {
            self.reset();
            return Ok(Carried {
                velocity: towards,
                load: towards,
                max_pressure: 0.0,
                end_flow: 0.0,
            });
        }
        if !self.full.iter().any(|&full| full) {
            for (i, normal) in self.normal.iter().enumerate() {
                let full = normal.dot(&towards) > 0.0;
                self.full[i * rows..(i + 1) * rows].fill(full);
            }
        }
        for _ in 0..LIMIT {
            self.solve_unit_velocities();
            let response = self.response();
            let v = velocity(response);
            self.combine(v);
            if !self.update_set(v) {
                return Ok(Carried {
                    velocity: v,
                    load: response * v,
                    max_pressure: self.pressure.iter().copied().fold(0.0, f64::max),
                    end_flow: self.end_flow(),
                });
            }
        }
        Err(NotConverged(LIMIT))
    }

    /// Solves for the pressures of unit velocities along x and y over the full cells.
    fn solve_unit_velocities(&mut self) {
        let (columns, rows) = (self.grid.columns(), self.grid.rows());
        self.arrange();
        self.matrix.clear();
        self.unit.clear();
        let mut count = 0;
        for &i in &self.order {
            for j in 0..rows {
                let cell = i * rows + j;
                if self.full[cell] {
                    self.number[cell] = count;
                    count += 1;
                } else {
                    self.number[cell] = usize::MAX;
                }
            }
        }
        for at in 0..columns {
            let i = self.order[at];
            let (left, right) = ((i + columns - 1) % columns, (i + 1) % columns);
            for j in 0..rows {
                let cell = i * rows + j;
                let own = self.number[cell];
                if own == usize::MAX {
                    continue;
                }
                let width = self.grid.zeta_width(j);
                let couplings = [
                    (Some(left * rows + j), self.along[i] * width),
                    (Some(right * rows + j), self.along[right] * width),
                    ((j > 0).then(|| cell - 1), self.across_into(i, j)),
                    (
                        (j + 1 < rows).then_some(cell + 1),
                        self.across_into(i, j + 1),
                    ),
                ];
                let lower = |neighbour: Option<usize>| {
                    neighbour.map(|n| self.number[n]).filter(|&n| n < own)
                };
                let first = couplings
                    .iter()
                    .filter_map(|&(neighbour, _)| lower(neighbour))
                    .min()
                    .unwrap_or(own);
                self.matrix.push_row(first);
                let mut diagonal = 0.0;
                for (k, &(neighbour, conductance)) in couplings.iter().enumerate() {
                    // At a closed seam the pressure falls to zero over half a cell.
                    let sealed = self.boundary == Boundary::Seam
                        && ((k == 0 && i == 0) || (k == 1 && right == 0));
                    if sealed {
                        diagonal += 2.0 * conductance;
                        continue;
                    }
                    diagonal += conductance;
                    if let Some(n) = lower(neighbour) {
                        self.matrix.add(own, n, -conductance);
                    }
                }
                self.matrix.add(own, own, diagonal);
                let normal = self.normal[i];
                self.unit.push([normal.x * width, normal.y * width]);
            }
        }
        let definite = self.matrix.factorise();
        debug_assert!(definite, "a positive gap makes a definite matrix");
        self.matrix.solve2(&mut self.unit);
    }

    /// Conductance between rows `j - 1` and `j` of column `i`; nothing flows through the mid-plane.
    fn across_into(&self, i: usize, j: usize) -> f64 {
        if j == 0 {
            0.0
        } else {
            self.across[i] * self.inverse_distance[j - 1]
        }
    }

    /// Orders the columns so that the factor stays narrow: starting after an empty column if there is one, else folded so
    /// that neighbours are at most two places apart.
    fn arrange(&mut self) {
        let (columns, rows) = (self.grid.columns(), self.grid.rows());
        self.order.clear();
        let empty = (0..columns).find(|i| !self.full[i * rows..(i + 1) * rows].contains(&true));
        match empty {
            Some(cut) => self
                .order
                .extend((1..=columns).map(|k| (cut + k) % columns)),
            None => {
                let pairs = (1..columns.div_ceil(2)).flat_map(|k| [k, columns - k]);
                self.order.extend([0].into_iter().chain(pairs));
                if columns.is_multiple_of(2) {
                    self.order.push(columns / 2);
                }
            }
        }
    }

    /// `dW/dv` over the present set of full cells.
    fn response(&self) -> nalgebra::Matrix2<f64> {
        let rows = self.grid.rows();
        let mut response = nalgebra::Matrix2::zeros();
        for (i, normal) in self.normal.iter().enumerate() {
            let mut sum = Vector2::zeros();
            for j in 0..rows {
                let number = self.number[i * rows + j];
                if number != usize::MAX {
                    sum += Vector2::from(self.unit[number]) * self.grid.zeta_width(j);
                }
            }
            response += normal * sum.transpose();
        }
        response
    }

    /// Superposes the unit solutions to the pressures at velocity `v`.
    fn combine(&mut self, v: Vector2<f64>) {
        for (p, &number) in self.pressure.iter_mut().zip(&self.number) {
            *p = match number {
                usize::MAX => 0.0,
                n => self.unit[n][0] * v.x + self.unit[n][1] * v.y,
            };
        }
    }

    /// Removes cells under tension from the set and adds cells that fill. False when none changed.
    fn update_set(&mut self, v: Vector2<f64>) -> bool {
        let (columns, rows) = (self.grid.columns(), self.grid.rows());
        let mut changed = false;
        for i in 0..columns {
            let (left, right) = ((i + columns - 1) % columns, (i + 1) % columns);
            let open_left = !(self.boundary == Boundary::Seam && i == 0);
            let open_right = !(self.boundary == Boundary::Seam && right == 0);
            let source = self.normal[i].dot(&v);
            for j in 0..rows {
                let cell = i * rows + j;
                let fills = if self.full[cell] {
                    self.pressure[cell] > 0.0
                } else {
                    let width = self.grid.zeta_width(j);
                    let mut inflow = source * width;
                    if open_left {
                        inflow += self.along[i] * width * self.pressure[left * rows + j];
                    }
                    if open_right {
                        inflow += self.along[right] * width * self.pressure[right * rows + j];
                    }
                    if j > 0 {
                        inflow += self.across_into(i, j) * self.pressure[cell - 1];
                    }
                    if j + 1 < rows {
                        inflow += self.across_into(i, j + 1) * self.pressure[cell + 1];
                    }
                    inflow > 0.0
                };
                changed |= fills != self.full[cell];
                self.number[cell] = usize::from(fills);
            }
        }
        for (full, &number) in self.full.iter_mut().zip(&self.number) {
            *full = number == 1;
        }
        changed
    }

    /// The integral of `-H^3 dP/dzeta` over the open end.
    fn end_flow(&self) -> f64 {
        let rows = self.grid.rows();
        let sum: f64 = (0..self.grid.columns())
            .map(|i| self.across_into(i, rows) * self.pressure[(i + 1) * rows - 1])
            .sum();
        sum / self.slenderness
    }
}
