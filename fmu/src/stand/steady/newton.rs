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
    pub place: Vector2<f64>,
    temperatures: Vector4,
    pub miss: Vector2<f64>,
    warming: Vector4,
    /// The error of its place that each of its steps allows.
    error: f64,
}

impl Turn {
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
    /// Derivatives of a turn's end over its beginning: the place's, 1, and the temperatures', K.
    slope: Matrix2<f64>,
    warming: SMatrix<f64, 4, 2>,
    isothermal: bool,
    last: Option<Turn>,
}

/// The change that Newton's method proposes.
pub struct Change {
    pub place: Vector2<f64>,
    pub temperatures: Vector4,
}

impl Newton {
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::thermal::Temperatures;

    const PERIOD: f64 = 0.2;

    /// A stand whose turns are linear: its steady state is at zero.
    struct Linear {
        drift: Matrix4,
        shift: SMatrix<f64, 2, 4>,
        slope: Matrix2<f64>,
        warming: SMatrix<f64, 4, 2>,
    }

    fn linear() -> Linear {
        let mut drift = Matrix4::from_diagonal(&Vector4::new(-58.0, -0.29, -0.29, -1e-3));
        (drift[(0, 1)], drift[(0, 2)], drift[(1, 0)]) = (29.0, 29.0, 0.29);
        drift[(2, 0)] = 0.28;
        let mut shift = SMatrix::<f64, 2, 4>::zeros();
        shift.set_column(0, &Vector2::new(2e-3, -1e-3));
        Linear {
            drift,
            shift,
            slope: Matrix2::new(0.1, 0.3, -0.2, -0.4),
            warming: SMatrix::from_fn(|i, j| 0.5 + i as f64 - 2.0 * j as f64),
        }
    }

    impl Linear {
        /// How far a turn ends from its beginning.
        fn miss(&self, e: Vector2<f64>, t: Vector4) -> (Vector2<f64>, Vector4) {
            let off = e - self.shift * t;
            let cooled = (lasting(&self.drift, PERIOD) - Matrix4::identity()) * t;
            (self.slope * off - off, cooled + self.warming * off)
        }

        /// Turns of the method until the temperatures change by less than 1e-9 K, from slopes that are off by `wrong` parts.
        fn turns(&self, wrong: f64) -> usize {
            let mut newton = Newton::new(
                &Equilibrium {
                    eccentricity: [0.0; 2],
                    temperatures: Temperatures::default(),
                    drift: self.drift,
                    shift: self.shift,
                    slope: self.slope * (1.0 + wrong),
                    heating: SMatrix::zeros(),
                },
                PERIOD,
                false,
            );
            newton.warming = self.warming * (1.0 - wrong);
            let (mut e, mut t) = (Vector2::new(1e-3, -2e-3), Vector4::new(0.1, 0.2, -0.1, 0.3));
            for turn in 1..50 {
                let (miss, warming) = self.miss(e, t);
                newton.learn(Turn { place: e, temperatures: t, miss, warming, error: 1e-15 });
                let change = newton.change().unwrap();
                e += change.place;
                t += change.temperatures;
                if change.temperatures.amax() < 1e-9 {
                    assert!(e.norm() < 1e-10 && t.amax() < 1e-9, "{e} {t}");
                    return turn;
                }
            }
            usize::MAX
        }
    }

    /// With exact slopes the first change reaches the solution; the second turn confirms it.
    #[test]
    fn known_slopes_need_one_change() {
        assert_eq!(linear().turns(0.0), 2);
    }

    /// Broyden's method ends after twice as many steps as there are unknown directions (Gay 1979, SIAM J. Numer. Anal. 16): two here.
    #[test]
    fn wrong_slopes_are_learnt() {
        let turns = linear().turns(0.5);
        assert!(turns <= 2 * 2 + 2, "{turns}");
    }
}
