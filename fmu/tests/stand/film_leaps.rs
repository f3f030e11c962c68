//! Leaps of the Reynolds film against turns that are all resolved.

use fmu_export::model::{Experiment, Log, Model};
use plain_bearing_stand::bearing::FilmModel;
use plain_bearing_stand::sensors::Readings;
use plain_bearing_stand::stand::Stand;
use std::fmt;

const NO_FILES: Experiment<'static> = Experiment { start: 0.0, stop: None, tolerance: None, resources: None };

#[derive(Default)]
struct Messages(String);

impl Log for Messages {
    fn log(&mut self, _: &'static str, message: fmt::Arguments<'_>) {
        self.0 += &format!("{message}\n");
    }
}

impl Messages {
    /// The number that stands before these words.
    fn number(&self, words: &str) -> usize {
        let before = self.0.split(words).next().filter(|text| text.len() < self.0.len());
        let number = before.and_then(|text| text.split_whitespace().last());
        number.and_then(|number| number.parse().ok()).unwrap_or_else(|| panic!("{}", self.0))
    }
}

/// The fixed values of studies/paper-table3.toml: thick oil, a film with a heat capacity.
fn table3(stand: &mut Stand) {
    stand.bearing.surface.roughness = 0.0;
    stand.oil.viscosity_scale = 70.71;
    let thermal = &mut stand.thermal;
    thermal.fresh_oil = 0.0;
    thermal.film_capacity = 116.0;
    thermal.film_bush = 0.1034;
    thermal.film_shaft = 0.2951;
    thermal.bush_capacity = 215.2;
    thermal.shaft_capacity = 47.87;
    thermal.bush_oil = 0.02625;
    thermal.shaft_oil = 0.39;
    thermal.oil_ambient = 0.5131;
    thermal.initial_film_rise = -12.76;
    thermal.initial_shaft_rise = 24.83;
}

/// The readings after `span` seconds in one step, and what the stand said.
fn run(set: impl Fn(&mut Stand), multirate: bool, span: f64) -> (Readings, Messages) {
    let mut stand = Stand::default();
    set(&mut stand);
    stand.film.model = FilmModel::Reynolds;
    // Few columns take little time, and leaps do not know of them.
    (stand.bearing.resolution.columns, stand.bearing.resolution.rows) = (32, 3);
    stand.solver.multirate = multirate;
    let mut log = Messages::default();
    stand.initialise(&NO_FILES, &mut log).unwrap();
    stand.advance(0.0, span, &mut log).unwrap();
    (*stand.readings(), log)
}

/// One per cent of the tolerances of studies/paper-table3.toml: T_oil, T_bearing (K), F_N (N) and P_fr (W).
fn check(set: impl Fn(&mut Stand), span: f64) -> usize {
    let (leapt, log) = run(&set, true, span);
    let (resolved, _) = run(&set, false, span);
    for (value, expected, bound) in [
        (leapt.oil_temperature, resolved.oil_temperature, 0.005),
        (leapt.bearing_temperature, resolved.bearing_temperature, 0.006),
        (leapt.load_force, resolved.load_force, 0.5),
        (leapt.friction_power, resolved.friction_power, 0.03),
    ] {
        assert!((value - expected).abs() < bound, "{value} {expected}: {}", log.0);
    }
    log.number(" turns of the film")
}

/// Two turns take one period of the fluctuation.
fn fluctuating(stand: &mut Stand) {
    stand.drive.fluctuation_amplitude = 0.025;
    stand.drive.fluctuation_frequency = 2.5;
}

/// The rig, a point of Table 3, and the rig at a speed that fluctuates: each for so many seconds, of five turns.
fn leaps(seconds: [u32; 3]) {
    for (set, seconds) in [|_: &mut Stand| (), table3, fluctuating].into_iter().zip(seconds) {
        let turns = check(set, f64::from(seconds));
        assert!(turns < 30, "{turns} of {} turns were needed", 5 * seconds);
    }
}

#[test]
fn a_leap_is_what_resolved_turns_are() {
    leaps([12, 12, 20]);
}

#[test]
#[ignore = "takes a while: scripts/test --long"]
fn many_leaps_are_what_resolved_turns_are() {
    leaps([40; 3]);
}

/// Point 194 of 200 of studies/paper-table3.toml: a clearance of 3.8 um, in which the film heats by 35 K. A leap would be off by
/// more than 1 % of the tolerances.
#[test]
fn a_film_far_from_its_orbit_does_not_leap() {
    let narrow = |stand: &mut Stand| {
        table3(stand);
        stand.bearing.radial_clearance = 3.843_126e-6;
        stand.load.stiffness = 89.366;
        stand.load.damping = 13.267;
        stand.load.preload = 42.996;
        stand.load.eccentricity = 3.634e-4;
        stand.bearing.width = 0.019_023;
        stand.bearing.diameter = 0.025_044;
    };
    let (leapt, log) = run(narrow, true, 12.0);
    assert!(log.0.contains("no leap, all turns are resolved"), "{}", log.0);
    let (resolved, _) = run(narrow, false, 12.0);
    assert_eq!(leapt.friction_power, resolved.friction_power);
}
