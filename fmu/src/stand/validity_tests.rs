use plain_bearing_stand::{
    bearing::Film,
    stand::{
        Stand,
        validity::{LIMITS, SeenByLimits},
    },
    thermal::Temperatures,
};
use std::collections::BTreeMap;

/// What is looked at in haste misses no limit, at bearings and instants from all over, and suspects few that are not passed.
#[test]
fn a_limit_that_is_passed_is_suspected() {
    let mut seed = 1_u32;
    let mut draw = |low: f64, high: f64| {
        seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        low * (high / low).powf(f64::from(seed) / f64::from(u32::MAX))
    };
    let (mut passed, mut suspected) = (BTreeMap::new(), BTreeMap::new());
    for k in 0..300 {
        let mut stand = Stand::default();
        let bearing = &mut stand.bearing;
        (bearing.diameter, bearing.radial_clearance) = (draw(0.01, 0.3), draw(2e-6, 1e-3));
        bearing.width = bearing.diameter * draw(0.05, 6.0);
        bearing.surface.roughness = if k % 4 == 0 { 0.0 } else { bearing.radial_clearance * draw(3e-4, 1.0) };
        bearing.surface.composite_modulus = draw(1e8, 1e12);
        stand.fluid = stand.oil.through_two_points();
        stand.film = Film::mobility(&stand.bearing).unwrap();
        for _ in 0..20 {
            let temperatures = Temperatures::of([(); 4].map(|()| draw(205.0, 560.0)));
            let viscosity = draw(1e-4, 10.0);
            stand.inputs.speed.value = draw(0.1, 1e4);
            stand.inputs.external_force.value = draw(1.0, 1e6) - 1.0;
            let clearance = stand.bearing.radial_clearance * draw(0.5, 2.0);
            let e = draw(1e-3, 1.5);
            let mut seen = SeenByLimits { temperatures, ..SeenByLimits::default() };
            stand.drift(0.0, [0.6 * e, -0.8 * e], viscosity, clearance, &mut seen);
            let strain = stand.film.strain(&stand.bearing, &seen.at, &seen.press);
            let suspects = stand.suspects(&seen, &strain);
            for (bit, how) in LIMITS.iter().filter_map(|(bit, how)| Some((bit, how(&stand, &seen, &strain)?))) {
                assert_ne!(suspects & bit, 0, "{how}: {seen:?} {strain:?}");
                *passed.entry(*bit).or_insert(0) += 1;
            }
            for (bit, _) in LIMITS.iter().filter(|(bit, _)| suspects & bit != 0) {
                *suspected.entry(*bit).or_insert(0) += 1;
            }
        }
    }
    assert_eq!(passed.len(), 7, "{passed:?}");
    for (bit, count) in &passed {
        assert!(suspected[bit] < 2 * count, "{bit}: {passed:?} {suspected:?}");
    }
}
