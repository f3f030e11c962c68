//! The energy balance of a long run, from recorded outputs alone: the work of shaft and load is the heat that went out and the
//! heat that is stored.

use fmu_export::model::{Experiment, Model};
use plain_bearing_stand::bearing::ThermalClearance;
use plain_bearing_stand::sensors::Readings;
use plain_bearing_stand::stand::Stand;

const NO_FILES: Experiment<'static> = Experiment { start: 0.0, stop: None, tolerance: None, resources: None };

/// A row is recorded this often, s: ten times in a turn of the load. Integrals of periodic signals by the trapezoidal rule
/// converge exponentially.
const STEP: f64 = 0.02;

/// `M*omega + F*v`, W.
fn work(r: &Readings) -> f64 {
    r.friction_torque * r.shaft_speed + r.load_force * r.journal_velocity
}

/// The heat stored between two rows, J. The oil's heat capacity is linear in its temperature, so its mean is exact.
fn stored(stand: &Stand, from: &Readings, to: &Readings) -> f64 {
    let thermal = &stand.thermal;
    thermal.film_capacity * (to.film_temperature - from.film_temperature)
        + thermal.bush_capacity * (to.bearing_temperature - from.bearing_temperature)
        + thermal.shaft_capacity * (to.shaft_temperature - from.shaft_temperature)
        + 0.5 * (from.oil_bath_capacity + to.oil_bath_capacity) * (to.oil_temperature - from.oil_temperature)
}

/// The rig from 22 degC over so many seconds, with a bronze bush in an aluminium housing, and wear: of this depth, m, at least, in a
/// bush above this temperature, K.
fn the_work_is_heat_out_and_heat_stored(seconds: f64, [worn, warm]: [f64; 2]) {
    let mut stand = Stand::default();
    stand.thermal.initial_bearing = 295.15;
    stand.thermal.initial_oil = 295.15;
    stand.thermal.bush_ambient = 0.02;
    stand.bearing.expansion.thermal_clearance = ThermalClearance::ConstrainedBush;
    stand.bearing.expansion.bush = 18e-6;
    stand.bearing.expansion.bush_modulus = 110e9;
    stand.bearing.expansion.housing = 23e-6;
    stand.bearing.wear.coefficient = 1e-15;
    stand.initialise(&NO_FILES, &mut ()).unwrap();
    let begin = *stand.readings();
    let mut before = begin;
    let (mut done, mut out) = (0.0, 0.0);
    for i in 0..(seconds / STEP) as usize {
        stand.advance(i as f64 * STEP, STEP, &mut ()).unwrap();
        let now = *stand.readings();
        done += 0.5 * STEP * (work(&before) + work(&now));
        out += 0.5 * STEP * (before.ambient_heat_flow + now.ambient_heat_flow);
        before = now;
    }
    let end = *stand.readings();
    let stored = stored(&stand, &begin, &end);
    println!("work {done} J, out {out} J, stored {stored} J; {end:?}");
    // Expansion and wear were at work.
    assert!(end.wear_depth > worn, "{}", end.wear_depth);
    assert!(end.hot_radial_clearance - end.wear_depth > 2.1e-5);
    assert!(end.bearing_temperature > warm);
    let missing = done - out - stored;
    assert!(
        missing.abs() < 1e-5 * done,
        "of {done} J of work, {out} J went out and {stored} J are stored: {missing} J are missing"
    );
}

#[test]
fn the_work_of_1000_seconds_is_heat_out_and_heat_stored() {
    the_work_is_heat_out_and_heat_stored(1000.0, [2e-8, 303.0]);
}

#[test]
#[ignore = "takes a while: scripts/test --long"]
fn the_work_of_5000_seconds_is_heat_out_and_heat_stored() {
    the_work_is_heat_out_and_heat_stored(5000.0, [4e-7, 325.0]);
}
