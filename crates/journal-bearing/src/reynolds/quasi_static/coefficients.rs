//! Stiffness and damping of the quasi-static film.

use nalgebra::{Matrix2, Vector2};

use super::{Carried, NotConverged, QuasiStatic};
use crate::reynolds::Coefficients;

impl QuasiStatic {
    /// What the film carries where the journal rests at its place, and the coefficients there, with the mean rotation
    /// `omega`, rad/s. Where the film ends, pressure and gradient are zero, so that its end counts only in the second order:
    /// the set of full cells is kept.
    ///
    /// The matrix is symmetric, so the unit solutions `U = A^-1 n`, which are there, give `dW = U . (db - dA P)` without
    /// solving again.
    ///
    /// # Errors
    /// Returns [`NotConverged`] when the set of cells under pressure does not settle.
    pub fn coefficients(&mut self, omega: f64) -> Result<(Carried, Coefficients), NotConverged> {
        let turned = |eps: Vector2<f64>| omega * Vector2::new(eps.y, -eps.x);
        let carried = self.load_at(turned(self.eps))?;
        let damping = self.response();
        let columns: Vec<Vector2<f64>> = [Vector2::x(), Vector2::y()]
            .into_iter()
            .map(|towards| {
                damping * turned(towards) - self.by_conductances(towards) + self.by_area(towards, carried.velocity)
            })
            .collect();
        Ok((carried, Coefficients { stiffness: Matrix2::from_columns(&columns), damping }))
    }

    /// How the load changes with the area on which the film bears, which a displacement takes from asperities: the pressure acts
    /// on it, and it is squeezed at the velocity `v`.
    fn by_area(&self, towards: Vector2<f64>, v: Vector2<f64>) -> Vector2<f64> {
        let mut sum = Vector2::zeros();
        if self.roughness == 0.0 {
            return sum;
        }
        for (i, smooth) in self.smooth.iter().enumerate() {
            let grid = &self.grid;
            let places = [grid.theta_edge(i), grid.theta_centre(i), grid.theta_edge(i + 1)];
            let [before, middle, after] = places.map(|theta| {
                let [[_, parting], _] = self.gap(theta);
                -parting * towards.dot(&Vector2::new(theta.cos(), theta.sin()))
            });
            let change = smooth * ((before + 4.0 * middle + after) / 6.0);
            for j in 0..grid.rows() {
                let cell = i * self.stride + j;
                if self.full[cell] {
                    let units = Vector2::new(self.unit[0][cell], self.unit[1][cell]);
                    let pressed = change * self.pressure[cell] + units * change.dot(&v);
                    sum += pressed * grid.zeta_width(j);
                }
            }
        }
        sum
    }

    /// `U . (dA P)` of both unit solutions, for a displacement of the journal.
    fn by_conductances(&self, towards: Vector2<f64>) -> Vector2<f64> {
        let (along, across) = self.conductance_derivatives(towards);
        let mut sum = Vector2::zeros();
        for i in 0..self.grid.columns() {
            for j in 0..self.grid.rows() {
                let cell = i * self.stride + j;
                if !self.full[cell] {
                    continue;
                }
                for (change, neighbour) in self.edges_of(i, j, &along, &across) {
                    let neighbour = neighbour.filter(|&other| self.full[other]);
                    // An edge between two full cells comes twice.
                    let share = if neighbour.is_some() { 0.5 } else { 1.0 };
                    let drop = |field: &[f64]| field[cell] - neighbour.map_or(0.0, |other| field[other]);
                    let units = Vector2::new(drop(&self.unit[0]), drop(&self.unit[1]));
                    sum += share * change * drop(&self.pressure) * units;
                }
            }
        }
        sum
    }

    /// The derivatives of the conductances between and over the columns by a displacement of the journal.
    fn conductance_derivatives(&self, towards: Vector2<f64>) -> (Vec<f64>, Vec<f64>) {
        let cubed = |theta: f64| {
            let [_, [_, slope]] = self.gap(theta);
            -slope * towards.dot(&Vector2::new(theta.cos(), theta.sin()))
        };
        let grid = &self.grid;
        let columns = grid.columns();
        let over = |i: usize| {
            let ends = cubed(grid.theta_edge(i)) + cubed(grid.theta_edge(i + 1));
            self.slenderness * grid.theta_width(i) * (ends + 4.0 * cubed(grid.theta_centre(i))) / 6.0
        };
        let between = |i: usize| {
            let previous = grid.theta_width((i + columns - 1) % columns);
            2.0 * cubed(grid.theta_edge(i)) / (previous + grid.theta_width(i))
        };
        ((0..columns).map(between).collect(), (0..columns).map(over).collect())
    }
}
