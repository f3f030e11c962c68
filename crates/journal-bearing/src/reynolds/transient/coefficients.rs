//! Stiffness and damping of the transient film about a resting journal.

use nalgebra::Matrix2;

use super::{film::ReynoldsFilm, forces::Forces, stage::JournalStage, step::stage};
use crate::reynolds::{Coefficients, Drive};

/// The slowest motion of the three that tell the damping, as a part of the mean rotation.
const SLOW: f64 = 1e-4;

impl ReynoldsFilm {
    /// Stiffness, N/m, and damping, N.s/m, of film and contact where the journal is, which should rest there under a constant
    /// load: from the film's linearisation, with the oil content that a displacement moves along.
    ///
    /// The load's derivative over a displacement that takes the time `1/s` is `K + B s + ...`: it is the Newton matrix of an
    /// implicit stage of that duration. `K` is that of an endless one, `B` follows from two long ones.
    ///
    /// `contact` as in [`advance`](Self::advance). The shaft has to turn: without a mean rotation the oil content stays where it
    /// is, and the damping is infinite in it.
    pub fn coefficients(&self, drive: &Drive, contact: &dyn Fn(f64) -> f64) -> Coefficients {
        let mut work = self.work.clone();
        let eps = work.state.eps;
        let mass = work.balance.mass.clone();
        let scale = work.geometry.settings.force_scale(drive.viscosity);
        let task = JournalStage { start: eps, guess: eps, load: drive.load_after, force_scale: scale, drive, contact };
        let slow = SLOW * drive.rotation().abs();
        let mut slope = |rate: f64| -> Matrix2<f64> {
            let stage = stage(&work, 1.0 / rate, &mass, drive);
            work.update_balance(&stage, drive);
            work.linearise(&stage);
            work.linear.slope + Forces::at(eps, &work, &stage, &task).stiffness
        };
        let [rest, one, two] = [0.0, slow, 2.0 * slow].map(&mut slope);
        // A parabola through the three: its slope at zero.
        let damping = ((one - rest) * 4.0 - (two - rest)) / (2.0 * slow);
        let per_length = scale / self.settings().clearance;
        Coefficients { stiffness: rest * per_length, damping: damping * per_length }
    }
}
