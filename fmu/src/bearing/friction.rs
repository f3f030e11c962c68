//! Friction of the journal: the film's shear and the asperities' boundary friction.

use super::parameters::Bearing;
use journal_bearing::contact::Contact;

/// Couette part of the film's friction torque over viscosity and speed, m³: `2*pi*R^3*B/(c*sqrt(1 - e^2))`. It is exact for a
/// full film between round, aligned surfaces (Sommerfeld 1904), and an upper bound for a ruptured one.
pub fn couette(bearing: &Bearing, eccentricity_ratio: f64) -> f64 {
    let radius = bearing.radius();
    let gap = bearing.radial_clearance * (1.0 - eccentricity_ratio * eccentricity_ratio).sqrt();
    std::f64::consts::TAU * radius.powi(3) * bearing.width / gap
}

/// Poiseuille part of the film's friction torque on the journal, N.m: half the moment of the load about the bush's centre,
/// `c*(Fx*ey - Fy*ex)/2`. Partial integration of `h/2*dp/dtheta` gives it for any pressure field, also with squeeze and
/// cavitation.
pub fn poiseuille(clearance: f64, load: [f64; 2], eccentricity: [f64; 2]) -> f64 {
    0.5 * clearance * (load[0] * eccentricity[1] - load[1] * eccentricity[0])
}

/// The friction of the touching asperities on a journal.
#[derive(Clone, Copy, Debug, Default)]
pub struct Boundary {
    /// Friction torque on the journal, N.m.
    pub torque: f64,
    /// Friction heat over the friction coefficient, W: the contact pressure times the sliding speed, over the surface.
    pub sliding: f64,
    /// Friction heat, W.
    pub heat: f64,
}

impl Boundary {
    /// The friction of a contact at a radial clearance (m) and a friction coefficient, whose surfaces slide at `speed` rad/s, at
    /// an eccentricity-ratio vector and its rate (1/s).
    ///
    /// The torque is the friction coefficient times the contact pressure's integral times the radius. The heat also counts
    /// that the contact's place moves along the bush, which changes the sliding speed by the journal's own.
    pub fn of(
        bearing: &Bearing,
        clearance: f64,
        contact: &Contact,
        coefficient: f64,
        speed: f64,
        eccentricity: [f64; 2],
        velocity: [f64; 2],
    ) -> Self {
        if contact.normal <= 0.0 {
            return Self::default();
        }
        let moment = contact.normal * bearing.radius();
        let [[x, y], [vx, vy]] = [eccentricity, velocity];
        let length = (x * x + y * y).sqrt();
        let along = if length > 0.0 { clearance * (x * vy - y * vx) / length } else { 0.0 };
        let sliding = moment * speed + contact.force * along;
        Self { torque: coefficient * moment, sliding, heat: coefficient * sliding }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_concentric_journal_has_petroffs_torque() {
        let bearing = Bearing::default();
        let expected = std::f64::consts::TAU * 0.0125_f64.powi(3) * 0.019 / 2e-5;
        assert!((couette(&bearing, 0.0) / expected - 1.0).abs() < 1e-14);
    }

    const TOUCH: Contact = Contact { force: 90.0, normal: 100.0 };

    #[test]
    fn boundary_friction_opposes_either_direction() {
        let bearing = Bearing::default();
        let torque = |speed| {
            let friction = bearing.contact_friction(speed);
            Boundary::of(&bearing, 2e-5, &TOUCH, friction, speed, [0.9, 0.0], [0.0; 2]).torque
        };
        assert!((torque(31.4) - bearing.surface.boundary_friction * 100.0 * 0.0125).abs() < 1e-12);
        assert_eq!(torque(-31.4), -torque(31.4));
        assert_eq!(torque(0.0), 0.0);
    }

    /// A contact at the top of the y axis that moves against the rotation slides more slowly.
    #[test]
    fn the_contact_s_own_motion_changes_the_heat() {
        let bearing = Bearing::default();
        let heat = |velocity| Boundary::of(&bearing, 2e-5, &TOUCH, 0.05, 31.4, [0.0, 0.9], velocity).heat;
        let change = heat([3.0, 0.0]) - heat([0.0; 2]);
        assert!((change + 0.05 * 90.0 * 2e-5 * 3.0).abs() < 1e-12, "{change}");
    }
}
