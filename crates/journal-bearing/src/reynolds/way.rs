//! The way along which a journal is moved while its place is sought.

use nalgebra::{Rotation2, Vector2};

use super::film::ReynoldsFilm;

/// The largest turn along the bush, rad.
const TURN: f64 = 0.5;

/// From a place on, by a change of the eccentricity ratio: around a round bush along its curve, which keeps the gap.
#[derive(Clone, Copy, Debug)]
pub(super) struct Way {
    from: Vector2<f64>,
    /// The straight part of the change.
    step: Vector2<f64>,
    /// The part that turns the eccentricity, rad.
    turn: f64,
}

impl Way {
    /// The place at a share of the way.
    pub(super) fn at(&self, share: f64) -> Vector2<f64> {
        Rotation2::new(self.turn * share) * (self.from + self.step * share)
    }

    /// The direction there: the place's derivative over the share.
    pub(super) fn heading(&self, share: f64) -> Vector2<f64> {
        let at = self.at(share);
        Rotation2::new(self.turn * share) * self.step + Vector2::new(-at.y, at.x) * self.turn
    }
}

impl ReynoldsFilm {
    /// The way that begins with a change of the eccentricity and leaves at least `rest` of the gap; the gap is to be
    /// that of its start.
    pub(super) fn way(&self, from: Vector2<f64>, change: Vector2<f64>, rest: f64) -> Way {
        let e = from.norm();
        // Near the middle there is no curve to follow.
        if !self.form.is_plain() || change.norm() < 0.5 * (1.0 - e) || e < 0.5 {
            let step = change * self.allowed(from, change, rest);
            return Way {
                from,
                step,
                turn: 0.0,
            };
        }
        let n = from / e;
        let (closing, turn) = (n * change.dot(&n), n.perp(&change) / e);
        // Both by the same share, which keeps the direction.
        let share = (TURN / turn.abs()).min(1.0) * self.allowed(from, closing, rest);
        Way {
            from,
            step: closing * share,
            turn: turn * share,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_heading_is_the_place_s_derivative() {
        let way = Way {
            from: Vector2::new(0.6, -0.7),
            step: Vector2::new(0.01, 0.02),
            turn: -0.4,
        };
        let d = 1e-6;
        for share in [0.0, 0.3, 1.0] {
            let difference = (way.at(share + d) - way.at(share - d)) / (2.0 * d);
            assert!((difference - way.heading(share)).norm() < 1e-9);
        }
    }
}
