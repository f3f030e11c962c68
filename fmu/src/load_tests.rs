use plain_bearing_stand::load::Load;

#[test]
fn no_eccentricity_gives_a_constant_load() {
    let load = Load { eccentricity: 0.0, ..Load::default() };
    let expected = 16.621 * (48.0 - 100.0 * 0.03267);
    for angle in [0.0, 1.0, 4.0] {
        assert!((load.force(angle, 31.4) - expected).abs() < 1e-9);
    }
}

#[test]
fn the_damper_swings_a_quarter_turn_ahead_of_the_spring() {
    let load = Load::default();
    let speed = 31.4;
    // At the eccentric's top the travel rate is zero; at its middle the travel is zero.
    let top = load.force(std::f64::consts::FRAC_PI_2 - load.phase, speed);
    let middle = load.force(-load.phase, speed);
    let base = 16.621 * (48.0 - 100.0 * 0.03267);
    assert!((top - base - 16.621 * 100.0 * 15.74 * 4.1e-4).abs() < 1e-9);
    assert!((middle - base - 16.621 * 14.0 * 15.74 * 4.1e-4 * speed).abs() < 1e-9);
    let least = |angles: std::ops::Range<i32>, speed: f64| {
        let forces = angles.map(|k| load.force(f64::from(k) * 1e-3, speed));
        forces.fold(f64::INFINITY, f64::min)
    };
    assert!((least(0..6284, speed) - load.least_force(speed)).abs() < 1e-3);
    assert!(load.least_force(600.0) < 0.0 && least(0..6284, 600.0) == 0.0);
}
