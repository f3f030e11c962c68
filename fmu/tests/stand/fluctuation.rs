//! Leaps over a speed that fluctuates.

use fmu_export::model::{Experiment, Log, Model};
use plain_bearing_stand::sensors::Readings;
use plain_bearing_stand::stand::Stand;
use std::fmt;

/// One per cent of the paper's tolerances (Table 2): oil, bush (K) and friction power (W).
const CLOSE: [f64; 3] = [0.005, 0.00615, 0.03];

#[derive(Default)]
struct Messages(String);

impl Log for Messages {
    fn log(&mut self, _: &'static str, message: fmt::Arguments<'_>) {
        self.0 += &format!("{message}\n");
    }
}

/// Sets a stand's parameters.
type Case = fn(&mut Stand);

/// The stand with the paper's fluctuation after `stop` seconds in one step, and what it said.
fn run(case: impl Fn(&mut Stand), multirate: bool, stop: f64) -> (Stand, String) {
    let mut stand = Stand::default();
    stand.solver.multirate = multirate;
    stand.drive.fluctuation_amplitude = 0.025;
    case(&mut stand);
    let mut log = Messages::default();
    stand.initialise(&Experiment::default(), &mut log).unwrap();
    stand.advance(0.0, stop, &mut log).unwrap();
    (stand, log.0)
}

/// At 300 rpm and 0.5 Hz, ten turns take one period of the fluctuation.
fn check_over_a_fluctuation(case: impl Fn(&mut Stand), stop: f64) {
    let (leaped, said) = run(&case, true, stop);
    let (resolved, _) = run(&case, false, stop);
    assert!(said.contains("in a leap") && !said.contains("no leap"), "{said}");
    // The means over the last turn, of which the ten have different ones.
    for (mean, expected) in leaped.means().into_iter().zip(resolved.means()) {
        assert!((mean / expected - 1.0).abs() < 1e-4, "{mean} {expected}");
    }
    let (leaped, resolved) = (leaped.readings(), resolved.readings());
    let apart = |get: fn(&Readings) -> f64| (get(leaped) - get(resolved)).abs();
    assert!(apart(|r| r.oil_temperature) < CLOSE[0]);
    assert!(apart(|r| r.bearing_temperature) < CLOSE[1]);
    assert!(apart(|r| r.friction_power) < CLOSE[2]);
    assert!(apart(|r| r.shaft_angle) < 1e-8);
    assert!(apart(|r| r.shaft_speed) < 1e-9);
    assert!(apart(|r| r.wear_depth) < 1e-3 * resolved.wear_depth + 1e-15);
}

#[test]
fn a_leap_goes_over_a_fluctuating_speed() {
    let cases: [Case; 4] = [
        |stand| stand.thermal.initial_bearing = 330.0,
        |stand| stand.oil.viscosity_scale = 60.0,
        |stand| stand.bearing.wear.coefficient = 1e-13,
        // Bodies of little mass, which the fluctuation warms and cools most.
        |stand| {
            stand.thermal.initial_bearing = 330.0;
            stand.thermal.bush_capacity = 20.0;
            stand.thermal.shaft_capacity = 20.0;
        },
    ];
    for (number, case) in cases.into_iter().enumerate() {
        // Whole periods of the fluctuation, and not.
        check_over_a_fluctuation(case, [150.0, 149.87][number % 2]);
    }
}

/// The run of studies/rig-run.toml.
#[test]
#[ignore = "takes a while: scripts/test --long"]
fn a_leap_over_an_hour_of_a_fluctuating_speed() {
    let cold = |stand: &mut Stand| {
        stand.thermal.initial_bearing = 295.15;
        stand.thermal.initial_oil = 295.15;
        stand.load.eccentricity = 1.27e-3;
    };
    check_over_a_fluctuation(cold, 5000.0);
}

/// Where a leap would be wrong, the turns are resolved, and the log names the cause.
#[test]
fn a_fluctuation_that_forbids_leaps_is_named() {
    let cases: [(Case, &str); 3] = [
        (
            |stand| stand.drive.fluctuation_frequency = 0.5 * std::f64::consts::SQRT_2,
            "no leap: drive.fluctuationFrequency and drive.speed have no common period",
        ),
        (
            |stand| stand.drive.fluctuation_amplitude = 0.9,
            "they are resolved: the fluctuation of the speed swings the temperatures by",
        ),
        (
            |stand| {
                stand.drive.fluctuation_amplitude = 1.0;
                stand.bearing.wear.coefficient = 1e-13;
            },
            "no leap: the fluctuation of the speed changes the asperities' friction coefficient",
        ),
    ];
    for (case, words) in cases {
        let mut ends = Vec::new();
        for multirate in [true, false] {
            let (stand, said) = run(case, multirate, 25.0);
            assert_eq!(multirate, said.contains(words), "{said}");
            ends.push(stand.readings().bearing_temperature);
        }
        // The first period is resolved roughly, before it shows that there is no leap.
        assert!((ends[0] - ends[1]).abs() < CLOSE[1], "{ends:?}");
    }
}
