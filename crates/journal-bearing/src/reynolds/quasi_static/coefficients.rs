//! Stiffness and damping of the film at a place where the journal rests, and the speed at which a rotor begins to whirl.

use nalgebra::{Matrix2, Vector2};

use super::{NotConverged, QuasiStatic};

/// The film's answer to a small displacement and a small velocity of the journal, in the frame of
/// [`reynolds`](crate::reynolds): the film's force on the journal is `-K d - B v`.
///
/// # Examples
/// Two axial grooves of 20 degrees, `B/D = 0.5`, at the eccentricity ratio 0.477: Lund & Thomsen (1978) have the attitude angle
/// 51.01 degrees and, in loads over the clearance, `Kxx` = 2.67.
/// ```
/// use std::f64::consts::FRAC_PI_2;
/// use journal_bearing::nalgebra::{Rotation2, Vector2};
/// use journal_bearing::reynolds::{Boundary, Grid, Groove, QuasiStatic};
///
/// let extent = 20_f64.to_radians();
/// let grooves = [-FRAC_PI_2, FRAC_PI_2].map(|angle| Groove { angle, extent });
/// let grid = Grid::standard(144, 8, 0.5);
/// let mut film = QuasiStatic::new(grid, 0.5, Boundary::Free).with_grooves(&grooves);
/// film.place(Rotation2::new(51.01_f64.to_radians()) * Vector2::new(0.477, 0.0));
/// let (carried, coefficients) = film.coefficients(1.0)?;
/// assert!(carried.load.y.atan2(carried.load.x).abs() < 0.01);
/// let scaled = coefficients.stiffness / carried.load.norm();
/// assert!((scaled.m11 / 2.67 - 1.0).abs() < 0.025);
/// # Ok::<(), journal_bearing::reynolds::NotConverged>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Coefficients {
    /// `K`, the derivative of the load `W` by the eccentricity ratio, 1/s.
    pub stiffness: Matrix2<f64>,
    /// `B`, its derivative by the eccentricity ratio's velocity, 1.
    pub damping: Matrix2<f64>,
}

impl Coefficients {
    /// The speed `Omega sqrt(c/g)` at which a rigid rotor whose weight is the load begins to whirl, where `speed` is the
    /// journal's at which these coefficients hold, rad/s; infinite where none makes it whirl.
    ///
    /// At the threshold the rotor circles with a frequency at which the characteristic polynomial of mass, damping and
    /// stiffness has a root without a real part (Lund 1974, J. Eng. Ind. 96, 509-517).
    pub fn whirl_threshold(&self, load: f64, speed: f64) -> f64 {
        let (k, b) = (self.stiffness / load, self.damping * (speed / load));
        let equal = (k.m11 * b.m22 + k.m22 * b.m11 - k.m12 * b.m21 - k.m21 * b.m12) / b.trace();
        let squared = ((equal - k.m11) * (equal - k.m22) - k.m12 * k.m21) / b.determinant();
        match squared > 0.0 {
            true => (equal / squared).sqrt(),
            false => f64::INFINITY,
        }
    }
}

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
    pub fn coefficients(
        &mut self,
        omega: f64,
    ) -> Result<(super::Carried, Coefficients), NotConverged> {
        let turned = |eps: Vector2<f64>| omega * Vector2::new(eps.y, -eps.x);
        let carried = self.load_at(turned(self.eps))?;
        let damping = self.response();
        let columns: Vec<Vector2<f64>> = [Vector2::x(), Vector2::y()]
            .into_iter()
            .map(|towards| damping * turned(towards) - self.by_conductances(towards))
            .collect();
        Ok((
            carried,
            Coefficients {
                stiffness: Matrix2::from_columns(&columns),
                damping,
            },
        ))
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
                    let drop =
                        |field: &[f64]| field[cell] - neighbour.map_or(0.0, |other| field[other]);
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
            let normal = Vector2::new(theta.cos(), theta.sin());
            -3.0 * (1.0 - self.eps.dot(&normal)).powi(2) * towards.dot(&normal)
        };
        let grid = &self.grid;
        let columns = grid.columns();
        let over = |i: usize| {
            let ends = cubed(grid.theta_edge(i)) + cubed(grid.theta_edge(i + 1));
            self.slenderness * grid.theta_width(i) * (ends + 4.0 * cubed(grid.theta_centre(i)))
                / 6.0
        };
        let between = |i: usize| {
            let previous = grid.theta_width((i + columns - 1) % columns);
            2.0 * cubed(grid.theta_edge(i)) / (previous + grid.theta_width(i))
        };
        (
            (0..columns).map(between).collect(),
            (0..columns).map(over).collect(),
        )
    }
}
