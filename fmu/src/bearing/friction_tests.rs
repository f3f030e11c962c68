use journal_bearing::contact::Contact;
use plain_bearing_stand::bearing::{
    Bearing,
    friction::{Boundary, couette},
};

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
