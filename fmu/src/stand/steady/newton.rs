//! Newton's method on turns that should end as they begin.
//!
//! The orbit's beginning follows the temperatures. A turn that begins off it by `m` misses its beginning by `(S - 1) m`
//! and warms the stand by `W m`, which says nothing of its heat balance. The averaged balance gives both slopes roughly, and Broyden's
//! corrections (Broyden 1965, Math. Comp. 19) improve them from turn to turn.

use super::super::Unknowns;
use crate::multirate::{Equilibrium, Matrix4, Vector4};
use nalgebra::{Const, LU, Matrix2, SMatrix, SVector, Vector2};

/// From a move of the journal that is not this many times as large as what a step may err, nothing is learnt.
const CLEAR: f64 = 20.0;

/// A turn as Newton's method sees it: where it begins, and by how much it misses its beginning.
#[derive(Clone, Copy, Debug)]
pub struct Turn {
    /// The eccentricity-ratio vector at its beginning, 1.
    pub place: Vector2<f64>,
    /// The temperatures there, K.
    pub temperatures: Vector4,
    /// By how much the place at its end differs.
    pub miss: Vector2<f64>,
    /// By how much the temperatures at its end differ, K.
    pub warming: Vector4,
    /// The error of its place that each of its steps allows.
    pub error: f64,
}

impl Turn {
    /// From its beginning to its end; each of its steps allows an `error` of its place.
    pub fn of(start: &Unknowns, end: &Unknowns, error: f64) -> Self {
        let miss = SVector::<f64, 7>::from(*end) - SVector::from(*start);
        Self {
            place: Vector2::new(start[0], start[1]),
            temperatures: Vector4::from_row_slice(&start[2..6]),
            miss: miss.fixed_rows::<2>(0).into(),
            warming: miss.fixed_rows::<4>(2).into(),
            error,
        }
    }
}

/// Newton's method on turns.
pub struct Newton {
    /// `exp(J*T)` of the drift over a turn: what is left of a change of the temperatures after it.
    lasting: Matrix4,
    settle: LU<f64, Const<4>, Const<4>>,
    /// Derivative of the orbit's beginning over the temperatures, 1/K.
    shift: SMatrix<f64, 2, 4>,
    /// Derivative of the place at a turn's end over that at its beginning, 1.
    slope: Matrix2<f64>,
    /// Derivative of the temperatures at a turn's end over the place at its beginning, K.
    pub warming: SMatrix<f64, 4, 2>,
    isothermal: bool,
    last: Option<Turn>,
}

/// The change that Newton's method proposes.
pub struct Change {
    /// Of the eccentricity-ratio vector at the turn's beginning, 1.
    pub place: Vector2<f64>,
    /// Of the temperatures there, K.
    pub temperatures: Vector4,
}

impl Newton {
    /// Before the first turn, from the averaged balance and the duration of a turn, s.
    pub fn new(equilibrium: &Equilibrium, period: f64, isothermal: bool) -> Self {
        let lasting = lasting(&equilibrium.drift, period);
        // A change of the rates warms by as much as is left of it at the turn's end.
        let gain = equilibrium.drift.lu().solve(&(lasting - Matrix4::identity()));
        Self {
            lasting,
            settle: (Matrix4::identity() - lasting).lu(),
            shift: equilibrium.shift,
            slope: equilibrium.slope,
            warming: gain.map_or(SMatrix::zeros(), |gain| gain * equilibrium.heating),
            isothermal,
            last: None,
        }
    }

    /// Takes over a further turn.
    pub fn learn(&mut self, turn: Turn) {
        if let Some(before) = self.last {
            let warmer = turn.temperatures - before.temperatures;
            let off = turn.place - before.place - self.shift * warmer;
            if off.norm() > CLEAR * turn.error.max(before.error) {
                let along = off.transpose() / off.norm_squared();
                let missed = turn.miss - before.miss;
                self.slope += (off + missed - self.slope * off) * along;
                let warmed = turn.warming - before.warming;
                let cooled = (self.lasting - Matrix4::identity()) * warmer;
                self.warming += (warmed - cooled - self.warming * off) * along;
            }
        }
        self.last = Some(turn);
    }

    /// The change of the last turn's beginning that makes up for its miss.
    pub fn change(&self) -> Option<Change> {
        let turn = self.last?;
        let back = Matrix2::identity() - self.slope;
        let closer = back.lu().solve(&turn.miss)?;
        let temperatures = if self.isothermal {
            Vector4::zeros()
        } else {
            self.settle.solve(&(turn.warming + self.warming * closer))?
        };
        Some(Change { place: closer + self.shift * temperatures, temperatures })
    }
}

/// `exp(J*T)` of a drift J over a turn's duration T: what is left of a change of the temperatures after a turn.
pub fn lasting(drift: &Matrix4, period: f64) -> Matrix4 {
    (drift * period).exp()
}
