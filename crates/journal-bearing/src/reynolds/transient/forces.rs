//! Forces on the journal: film pressure, asperity contact and the external load, and two small terms that keep the motion
//! determined where the film says nothing: damping by the air, and the film's narrowest part, which the grid does not
//! resolve.

use nalgebra::{Matrix2, Vector2};

use super::{
    asperities,
    geometry::Geometry,
    stage::{FilmStage, JournalStage},
    workspace::Workspace,
};

/// Damping by the air in a film that has run empty, as a share of the damping of a full film. It keeps the motion of a
/// journal without a film determined.
const AIR: f64 = 1e-6;
/// The forces balance when their sum is at most this share of all contributions,
const CARRIED: f64 = 1e-11;
/// or when what is missing would move the journal by less than this share of the clearance.
const SLIGHT: f64 = 1e-13;

/// The balance of forces at an eccentricity ratio, dimensionless.
#[derive(Clone, Copy, Debug)]
pub struct Forces {
    /// The part of the load that nothing carries.
    pub missing: Vector2<f64>,
    /// The sum of the absolute contributions to `missing`.
    pub size: f64,
    /// Derivative over the eccentricity ratio of all that carries except the film's pressure.
    pub stiffness: Matrix2<f64>,
}

impl Forces {
    /// The forces at the eccentricity ratio `eps`, with the present pressures.
    pub fn at(eps: Vector2<f64>, work: &Workspace, stage: &FilmStage, task: &JournalStage) -> Self {
        let geometry = &work.geometry;
        let (touch, stiffness) = rubbing(task, touch(eps, geometry, task));
        let (pinch, stiffening) = unresolved(eps, geometry, stage, task);
        let air = AIR * geometry.settings.width.powi(2) / geometry.settings.diameter.powi(2);
        let turning = stage.rotation * Vector2::new(-eps.y, eps.x);
        let slip = (eps - task.start) / stage.duration - turning;
        let carried = work.pressure_load();
        let wanted = task.load / task.force_scale;
        Self {
            missing: wanted - (touch + pinch + slip * air) - carried.force,
            size: carried.size + wanted.norm() + touch.norm(),
            stiffness: stiffness + stiffening + Matrix2::identity() * (air / stage.duration),
        }
    }

    /// Whether the forces balance; `change` is how the journal would answer to what is missing.
    pub fn balance(&self, change: Vector2<f64>) -> bool {
        self.missing.norm() <= CARRIED * self.size || change.norm() <= SLIGHT
    }
}

/// A contact's force and stiffness with its friction. In each place friction is a multiple of the pressure and a quarter
/// turn ahead of it on the load's side, and so are their resultants.
fn rubbing(task: &JournalStage, (force, stiffness): (Vector2<f64>, Matrix2<f64>)) -> (Vector2<f64>, Matrix2<f64>) {
    let friction = task.drive.contact_friction;
    if friction == 0.0 {
        return (force, stiffness);
    }
    let turn = Matrix2::new(1.0, -friction, friction, 1.0);
    (turn * force, turn * stiffness)
}

/// The contact of the asperities: cell by cell, or from the contact of an aligned journal.
fn touch(eps: Vector2<f64>, geometry: &Geometry, task: &JournalStage) -> (Vector2<f64>, Matrix2<f64>) {
    let (scale, contact) = (task.force_scale, task.contact);
    if let Some(surface) = &geometry.settings.asperities {
        let (force, slope) = asperities::push(surface, geometry);
        return (force / scale, slope / scale);
    }
    let e = eps.norm();
    let force = contact(e) / scale;
    if force == 0.0 || e == 0.0 {
        return (Vector2::zeros(), Matrix2::zeros());
    }
    let nudge = 1e-6 * (1.0 - e).abs().max(geometry.form.roughness).max(1e-9);
    let slope = (contact(e + nudge) - contact(e - nudge)) / (2.0 * nudge * scale);
    let n = eps / e;
    let along = n * n.transpose();
    let across = Matrix2::identity() - along;
    (n * force, along * slope + across * (force / e))
}

/// The load that the film's narrowest part carries beyond what the grid resolves, and its derivative.
///
/// Near its narrowest point a closing gap carries `pi sqrt(2)/4 g^(-3/2)` times its rate (the squeeze film of a long
/// bearing with `H = g + theta^2/2`). Let `d` be the gap's variation over half a column. The grid resolves about
/// `(g + d)^(-3/2)`; the rest is added here, less its value at `3 d`, beyond which nothing is added. The term therefore
/// sets in without a jump, at which Newton's method would oscillate. It matters only within a few `d` of the bush (`d` is
/// 5e-4 of the clearance at 96 columns), and keeps the journal from touching it.
fn unresolved(
    eps: Vector2<f64>,
    geometry: &Geometry,
    stage: &FilmStage,
    task: &JournalStage,
) -> (Vector2<f64>, Matrix2<f64>) {
    let (start, duration) = (task.start, stage.duration);
    let e = eps.norm();
    let variation = geometry.cells.resolved_gap();
    let farthest = 3.0 * variation;
    if !geometry.form.is_plain() || 1.0 - e > farthest {
        return (Vector2::zeros(), Matrix2::zeros());
    }
    // The film bears, and is squeezed, on this share of the area.
    let [gap, share] = geometry.form.content(1.0 - e);
    if gap > farthest {
        return (Vector2::zeros(), Matrix2::zeros());
    }
    let n = eps / e;
    let closing = (eps - start).dot(&n) / duration;
    if closing <= 0.0 {
        return (Vector2::zeros(), Matrix2::zeros());
    }
    let factor = 0.25 * std::f64::consts::PI * std::f64::consts::SQRT_2 * (share * share);
    let beyond = |gap: f64, power: f64| gap.powf(power) - (gap + variation).powf(power);
    let carried = factor * (beyond(gap, -1.5) - beyond(farthest, -1.5));
    let slope = carried / duration + closing * 1.5 * factor * beyond(gap, -2.5);
    // The direction turns with the eccentricity.
    let along = n * n.transpose();
    let aside = (eps - start) / duration;
    let aside = (aside - n * aside.dot(&n)) * (carried / e);
    let turning = (Matrix2::identity() - along) * (carried * closing / e);
    (n * (carried * closing), along * slope + n * aside.transpose() + turning)
}
