//! Friction of the journal: the film's shear and the asperities' boundary friction.

use super::parameters::Bearing;

/// Sliding speed at which boundary friction reaches 76 % of its full value, m/s. It smooths the jump of Coulomb's law at
/// standstill.
const STICTION_SPEED: f64 = 1e-3;

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

/// Boundary friction torque on the journal, N.m, at a contact pressure that integrates to `normal` N and a shaft speed of
/// `speed` rad/s.
pub fn boundary(bearing: &Bearing, normal: f64, speed: f64) -> f64 {
    let sliding = speed * bearing.radius() / STICTION_SPEED;
    bearing.surface.boundary_friction * normal * bearing.radius() * sliding.tanh()
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

    #[test]
    fn boundary_friction_opposes_either_direction() {
        let bearing = Bearing::default();
        let forward = boundary(&bearing, 100.0, 31.4);
        assert!((forward - bearing.surface.boundary_friction * 100.0 * 0.0125).abs() < 1e-12);
        assert_eq!(boundary(&bearing, 100.0, -31.4), -forward);
        assert_eq!(boundary(&bearing, 100.0, 0.0), 0.0);
    }
}
