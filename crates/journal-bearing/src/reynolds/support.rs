//! What else than the film's pressure carries the journal.

use nalgebra::{Matrix2, Vector2};

use super::film::ReynoldsFilm;

/// Damping of a film that has run empty, as a share of that of a full one: the air's. It keeps the
/// motion of a journal without a film determined.
const AIR: f64 = 1e-6;

/// A force on the load's side, dimensionless, and its derivative over the eccentricity ratio.
#[derive(Clone, Copy, Debug)]
pub(super) struct Support {
    pub(super) force: Vector2<f64>,
    pub(super) stiffness: Matrix2<f64>,
    /// The asperities' part of the force.
    pub(super) touch: Vector2<f64>,
}

/// Where a stage has started from and how long it is.
#[derive(Clone, Copy, Debug)]
pub(super) struct Motion {
    pub(super) start: Vector2<f64>,
    pub(super) duration: f64,
    pub(super) rotation: f64,
}

impl ReynoldsFilm {
    /// What asperities, air and the unresolved part of the film carry at an eccentricity ratio.
    pub(super) fn support(
        &self,
        eps: Vector2<f64>,
        motion: &Motion,
        scale: f64,
        contact: &dyn Fn(f64) -> f64,
    ) -> Support {
        let Motion {
            start,
            duration,
            rotation,
        } = *motion;
        let (touch, stiffness) = self.touch(eps, scale, contact);
        let air = AIR * self.settings.width.powi(2) / self.settings.diameter.powi(2);
        let slip = (eps - start) / duration - rotation * Vector2::new(-eps.y, eps.x);
        let (pinch, stiffening) = self.unresolved(eps, motion);
        Support {
            force: touch + pinch + slip * air,
            stiffness: stiffness + stiffening + Matrix2::identity() * (air / duration),
            touch,
        }
    }

    /// The asperities.
    fn touch(
        &self,
        eps: Vector2<f64>,
        scale: f64,
        contact: &dyn Fn(f64) -> f64,
    ) -> (Vector2<f64>, Matrix2<f64>) {
        if let Some(asperities) = &self.settings.asperities {
            let (force, slope) = asperities.push(&self.cells, &self.gap, &self.settings);
            return (force / scale, slope / scale);
        }
        let e = eps.norm();
        let force = contact(e) / scale;
        if force == 0.0 || e == 0.0 {
            return (Vector2::zeros(), Matrix2::zeros());
        }
        let nudge = 1e-6 * (1.0 - e).abs().max(1e-9);
        let slope = (contact(e + nudge) - contact(e - nudge)) / (2.0 * nudge * scale);
        let n = eps / e;
        let along = n * n.transpose();
        let across = Matrix2::identity() - along;
        (n * force, along * slope + across * (force / e))
    }

    /// The smallest gap that the grid resolves: the gap's variation over half a column at the narrowest point.
    pub(super) fn resolved_gap(&self) -> f64 {
        0.5 * (0.5 * self.cells.grid.theta_width(0)).powi(2)
    }

    /// The load that the film's narrowest part carries beyond what the grid resolves.
    ///
    /// A closing gap carries near its narrowest point (the squeeze film of a long bearing with
    /// `H = g + theta^2/2`) `pi sqrt(2)/4 g^(-3/2)` times its rate. Where `g` is narrower than the gap's
    /// variation `d` over half a column, what is beyond `(g + d)^(-3/2)` is added, less its value at `3 d`, from
    /// where on it is nothing. So it sets in without a jump, at which Newton's method would go to and fro. It matters
    /// only within a few `d` of the bush (`d` is 5e-4 of the clearance at 96 columns), and keeps the journal from it.
    fn unresolved(&self, eps: Vector2<f64>, motion: &Motion) -> (Vector2<f64>, Matrix2<f64>) {
        let e = eps.norm();
        let variation = self.resolved_gap();
        let gap = 1.0 - e;
        let farthest = 3.0 * variation;
        if !self.form.is_plain() || gap > farthest {
            return (Vector2::zeros(), Matrix2::zeros());
        }
        let n = eps / e;
        let closing = (eps - motion.start).dot(&n) / motion.duration;
        if closing <= 0.0 {
            return (Vector2::zeros(), Matrix2::zeros());
        }
        let factor = 0.25 * std::f64::consts::PI * std::f64::consts::SQRT_2;
        let beyond = |gap: f64, power: f64| gap.powf(power) - (gap + variation).powf(power);
        let carried = factor * (beyond(gap, -1.5) - beyond(farthest, -1.5));
        let slope = carried / motion.duration + closing * 1.5 * factor * beyond(gap, -2.5);
        // The direction turns with the eccentricity.
        let along = n * n.transpose();
        let aside = (eps - motion.start) / motion.duration;
        let aside = (aside - n * aside.dot(&n)) * (carried / e);
        let turning = (Matrix2::identity() - along) * (carried * closing / e);
        (
            n * (carried * closing),
            along * slope + n * aside.transpose() + turning,
        )
    }
}
