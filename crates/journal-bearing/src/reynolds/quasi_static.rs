//! The quasi-static film: its pressure is nowhere below ambient, and it has no memory.
//!
//! Where the film would be in tension it carries nothing, and its oil content is not tracked. Position and extent of the
//! pressure field follow from the complementarity `P >= 0`, `A P - b >= 0`, `P (A P - b) = 0`: at both ends of the field,
//! pressure and pressure gradient are zero (the Swift-Stieber or Reynolds condition, at both ends). The primal-dual
//! active-set method solves it, a semismooth Newton method (Hintermueller, Ito & Kunisch 2003, SIAM J. Optim. 13).

use std::f64::consts::PI;

use nalgebra::{Matrix2, Vector2};
use thiserror::Error;

mod coefficients;
mod place;
#[cfg(test)]
mod tests;

use super::{grid::Grid, lanes::LANES, ring::Ring};

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

/// An axial groove over the whole width, at ambient pressure: the film begins and ends at its edges.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Groove {
    /// Where its middle stands, rad.
    pub angle: f64,
    /// From edge to edge, rad.
    pub extent: f64,
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
    /// Roughness over clearance; zero between smooth surfaces.
    roughness: f64,
    /// The eccentricity ratio.
    eps: Vector2<f64>,
    /// Which columns are in a groove.
    grooved: Vec<bool>,
    /// The integral of `n` over each column,
    smooth: Vec<Vector2<f64>>,
    /// and over its area on which the film bears.
    normal: Vec<Vector2<f64>>,
    /// Conductance between column `i - 1` and `i`, per `zeta`.
    along: Vec<f64>,
    /// `(D/B)^2` times the integral of `H^3` over each column.
    across: Vec<f64>,
    /// Reciprocal distances between rows; the last is to the open end.
    inverse_distance: Vec<f64>,
    /// Cells of a column with padding: the ring's rows.
    stride: usize,
    /// `P`, 1/s, column by column.
    pressure: Vec<f64>,
    /// Which cells are under pressure.
    full: Vec<bool>,
    /// The matrix of the full cells; the others count as identity.
    ring: Ring,
    /// Pressures of the full cells at unit velocities along x and y.
    unit: [Vec<f64>; 2],
}

/// Most passes of an iteration; ordinary ones need a few.
const LIMIT: usize = 200;

impl QuasiStatic {
    /// A film on `grid` (over the half width) in a bearing of `width_to_diameter` (`B/D > 0`), with the journal in the
    /// middle.
    pub fn new(grid: Grid, width_to_diameter: f64, boundary: Boundary) -> Self {
        Self::between(0.0, grid, width_to_diameter, boundary)
    }

    /// The same between rough surfaces, which the film sees as [`RoughFilm::MeanGap`](super::RoughFilm::MeanGap) says; `roughness` is the composite rms
    /// roughness over the radial clearance.
    pub fn between(roughness: f64, grid: Grid, width_to_diameter: f64, boundary: Boundary) -> Self {
        let (columns, rows) = (grid.columns(), grid.rows());
        let normal: Vec<_> = (0..columns).map(|i| grid.normal(i)).collect();
        let inverse_distance =
            (1..rows).map(|j| 1.0 / grid.zeta_distance(j)).chain([1.0 / grid.end_distance()]).collect();
        let stride = rows.next_multiple_of(LANES);
        let zeros = || vec![0.0; columns * stride];
        let mut film = Self {
            boundary,
            slenderness: width_to_diameter.powi(-2),
            roughness,
            eps: Vector2::zeros(),
            grooved: vec![false; columns],
            smooth: normal.clone(),
            normal,
            along: vec![0.0; columns],
            across: vec![0.0; columns],
            inverse_distance,
            stride,
            pressure: zeros(),
            full: vec![false; columns * stride],
            ring: Ring::new(columns, stride),
            unit: [zeros(), zeros()],
            grid,
        };
        film.place(Vector2::zeros());
        film
    }

    /// The film of a bush with grooves: all columns whose middle lies in one are at ambient pressure.
    #[must_use]
    pub fn with_grooves(mut self, grooves: &[Groove]) -> Self {
        for (i, grooved) in self.grooved.iter_mut().enumerate() {
            let theta = self.grid.theta_centre(i);
            let away = |groove: &Groove| (theta - groove.angle).sin().atan2((theta - groove.angle).cos());
            *grooved = grooves.iter().any(|groove| away(groove).abs() < 0.5 * groove.extent);
        }
        self
    }

    /// The grid.
    pub fn grid(&self) -> &Grid {
        &self.grid
    }

    /// The pressure `P` of column `i`, row `j`, 1/s.
    pub fn pressure(&self, i: usize, j: usize) -> f64 {
        self.pressure[i * self.stride + j]
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
        self.settle(load, |response| response.try_inverse().map_or(load, |compliance| compliance * load))
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
        velocity: impl Fn(Matrix2<f64>) -> Vector2<f64>,
    ) -> Result<Carried, NotConverged> {
        let rows = self.grid.rows();
        if towards == Vector2::zeros() {
            self.reset();
            return Ok(Carried { velocity: towards, load: towards, max_pressure: 0.0, end_flow: 0.0 });
        }
        if !self.full.iter().any(|&full| full) {
            for (i, normal) in self.normal.iter().enumerate() {
                let full = normal.dot(&towards) > 0.0 && !self.grooved[i];
                self.full[i * self.stride..][..rows].fill(full);
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
        for i in 0..self.grid.columns() {
            for j in 0..self.grid.rows() {
                let cell = i * self.stride + j;
                let full = self.full[cell];
                let edges = self.edges(i, j);
                let leak = edges.iter().fold(0.0, |sum, (conductance, _)| sum + conductance);
                let [before, after, below, above] = edges.map(|(conductance, neighbour)| {
                    let couples = full && neighbour.is_some_and(|other| self.full[other]);
                    if couples { -conductance } else { 0.0 }
                });
                let ring = &mut self.ring;
                ring.diagonal[cell] = if full { leak } else { 1.0 };
                (ring.before[cell], ring.after[cell]) = (before, after);
                (ring.below[cell], ring.above[cell]) = (below, above);
                let faced = self.normal[i] * self.grid.zeta_width(j);
                for (k, unit) in self.unit.iter_mut().enumerate() {
                    unit[cell] = if full { faced[k] } else { 0.0 };
                }
            }
        }
        let columns = self.full.chunks_exact(self.stride);
        let counts = columns.map(|column| column.iter().filter(|&&full| full).count());
        for (active, count) in self.ring.active.iter_mut().zip(counts.clone()) {
            *active = count > 0;
        }
        let emptiest = counts.enumerate().min_by_key(|&(_, count)| count);
        self.ring.factorise(emptiest.map_or(0, |(column, _)| column));
        let [x, y] = &mut self.unit;
        self.ring.solve([x, y]);
    }

    /// The conductances from a cell to the columns before and after it and to the rows below and above it, with the cells
    /// there. There are none beyond the open end, a closed seam and the edge of a groove, where the pressure is zero.
    fn edges(&self, i: usize, j: usize) -> [(f64, Option<usize>); 4] {
        self.edges_of(i, j, &self.along, &self.across)
    }

    /// The same of other conductances between and over the columns.
    fn edges_of(&self, i: usize, j: usize, along: &[f64], across: &[f64]) -> [(f64, Option<usize>); 4] {
        let (columns, cell) = (self.grid.columns(), i * self.stride + j);
        let (before, after) = ((i + columns - 1) % columns, (i + 1) % columns);
        let around = |edge: usize, column: usize| {
            let conductance = along[edge] * self.grid.zeta_width(j);
            if self.boundary == Boundary::Seam && edge == 0 || self.grooved[column] {
                // The pressure falls to zero over half a cell.
                let [own, other] = [i, column].map(|i| self.grid.theta_width(i));
                ((own + other) / own * conductance, None)
            } else {
                (conductance, Some(column * self.stride + j))
            }
        };
        let across_into = |j: usize| match j {
            // Nothing flows through the mid-plane.
            0 => 0.0,
            j => across[i] * self.inverse_distance[j - 1],
        };
        [
            around(i, before),
            around(after, after),
            (across_into(j), (j > 0).then(|| cell - 1)),
            (across_into(j + 1), (j + 1 < self.grid.rows()).then_some(cell + 1)),
        ]
    }

    /// `dW/dv` over the present set of full cells.
    fn response(&self) -> Matrix2<f64> {
        let mut response = Matrix2::zeros();
        for (i, normal) in self.normal.iter().enumerate() {
            let mut sum = Vector2::zeros();
            for j in 0..self.grid.rows() {
                let unit = |k: usize| self.unit[k][i * self.stride + j];
                sum += Vector2::new(unit(0), unit(1)) * self.grid.zeta_width(j);
            }
            response += normal * sum.transpose();
        }
        response
    }

    /// Superposes the unit solutions to the pressures at velocity `v`.
    fn combine(&mut self, v: Vector2<f64>) {
        for (p, (x, y)) in self.pressure.iter_mut().zip(self.unit[0].iter().zip(&self.unit[1])) {
            *p = x * v.x + y * v.y;
        }
    }

    /// Removes cells under tension from the set and adds cells that fill. False when none changed.
    fn update_set(&mut self, v: Vector2<f64>) -> bool {
        let fills = |i: usize, j: usize| {
            let cell = i * self.stride + j;
            if self.grooved[i] {
                return false;
            }
            if j >= self.grid.rows() || self.full[cell] {
                return self.pressure[cell] > 0.0;
            }
            let inflow = self.normal[i].dot(&v) * self.grid.zeta_width(j);
            let from = |neighbour: Option<usize>| neighbour.map_or(0.0, |cell| self.pressure[cell]);
            let edges = self.edges(i, j).into_iter();
            edges.fold(inflow, |sum, (conductance, neighbour)| sum + conductance * from(neighbour)) > 0.0
        };
        let columns = 0..self.grid.columns();
        let full: Vec<bool> =
            columns.flat_map(|i| (0..self.stride).map(move |j| (i, j))).map(|(i, j)| fills(i, j)).collect();
        let changed = full != self.full;
        self.full = full;
        changed
    }

    /// The integral of `-H^3 dP/dzeta` over the open end.
    fn end_flow(&self) -> f64 {
        let rows = self.grid.rows();
        let sum: f64 = (0..self.grid.columns())
            .map(|i| self.across[i] * self.inverse_distance[rows - 1] * self.pressure(i, rows - 1))
            .sum();
        sum / self.slenderness
    }
}
