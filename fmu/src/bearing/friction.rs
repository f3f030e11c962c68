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
