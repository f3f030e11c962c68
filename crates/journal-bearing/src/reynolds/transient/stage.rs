//! One implicit Euler stage: its duration, its start, and what acts on film and journal.

use nalgebra::Vector2;

use crate::reynolds::settings::Drive;

/// The stage as the film's balances see it.
#[derive(Clone, Copy, Debug)]
pub struct FilmStage<'a> {
    /// Duration, s.
    pub duration: f64,
    /// Mass at its start, per cell.
    pub mass: &'a [f64],
    /// Mean rotation, rad/s.
    pub rotation: f64,
    /// Flow carried by the sliding of rough surfaces at a shear flow factor of one, 1/s; zero without flow factors.
    pub shear: f64,
    /// Pressure at the open ends above that of the cavities, in units of the film's dimensionless pressure, 1/s.
    pub side: f64,
    /// Pressure of the feeds above that of the cavities, in the same units, 1/s.
    pub feed: f64,
}

/// The stage as the journal's balance of forces sees it.
#[derive(Clone, Copy)]
pub struct JournalStage<'a> {
    /// Eccentricity ratio at the stage's start.
    pub start: Vector2<f64>,
    /// Expected eccentricity ratio at its end.
    pub guess: Vector2<f64>,
    /// External load at its end, N.
    pub load: Vector2<f64>,
    /// Force per unit of dimensionless load, N.s.
    pub force_scale: f64,
    pub drive: &'a Drive,
    /// Contact force of an aligned journal, N, over the eccentricity ratio.
    pub contact: &'a dyn Fn(f64) -> f64,
}

/// The iteration found no solution of the stage.
#[derive(Clone, Copy, Debug)]
pub struct NoSolution;
