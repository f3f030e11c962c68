use nalgebra::{Matrix2, SMatrix, Vector2};
use plain_bearing_stand::{
    multirate::{Equilibrium, Matrix4, Vector4},
    stand::steady::newton::{Newton, Turn, lasting},
    thermal::Temperatures,
};

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
