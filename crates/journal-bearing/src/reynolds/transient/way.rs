//! The way along which the journal moves while its position is sought.

use nalgebra::{Rotation2, Vector2};

use super::geometry::Geometry;

/// The largest turn of the eccentricity along one way, rad.
const TURN: f64 = 0.5;

/// A way from a position by a change of the eccentricity ratio. Along a round bush it is curved, which keeps the gap.
#[derive(Clone, Copy, Debug)]
pub struct GapKeepingMove {
    from: Vector2<f64>,
    /// The straight part of the change.
    step: Vector2<f64>,
    /// The part that turns the eccentricity, rad.
    turn: f64,
}

impl GapKeepingMove {
    /// The way that starts with `change` and leaves at least the share `rest` of the gap. `geometry` must be at `from`.
    pub fn new(geometry: &Geometry, from: Vector2<f64>, change: Vector2<f64>, rest: f64) -> Self {
        let e = from.norm();
        // Near the middle there is no curve to follow.
        if !geometry.form.is_plain() || change.norm() < 0.5 * (1.0 - e) || e < 0.5 {
            let step = change * geometry.allowed(from, change, rest);
            return Self { from, step, turn: 0.0 };
        }
        let n = from / e;
        let (closing, turn) = (n * change.dot(&n), n.perp(&change) / e);
        // The same share of both parts keeps the direction.
        let share = (TURN / turn.abs()).min(1.0) * geometry.allowed(from, closing, rest);
        Self { from, step: closing * share, turn: turn * share }
    }

    /// The position after a share of the way, 0..1.
    pub fn at(&self, share: f64) -> Vector2<f64> {
        Rotation2::new(self.turn * share) * (self.from + self.step * share)
    }

    /// The derivative of the position over the share.
    pub fn heading(&self, share: f64) -> Vector2<f64> {
        let at = self.at(share);
        Rotation2::new(self.turn * share) * self.step + Vector2::new(-at.y, at.x) * self.turn
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_heading_is_the_position_s_derivative() {
        let way = GapKeepingMove { from: Vector2::new(0.6, -0.7), step: Vector2::new(0.01, 0.02), turn: -0.4 };
        let d = 1e-6;
        for share in [0.0, 0.3, 1.0] {
            let difference = (way.at(share + d) - way.at(share - d)) / (2.0 * d);
            assert!((difference - way.heading(share)).norm() < 1e-9);
        }
    }
}
