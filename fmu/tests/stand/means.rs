//! The sensors' means over a turn: `sensor.*Mean`.

use fmu_export::model::{Experiment, Model};
use plain_bearing_stand::bearing::FilmModel;
use plain_bearing_stand::sensors::Sensed;
use plain_bearing_stand::stand::Stand;
use plain_bearing_stand::thermal::Initialization;
use std::f64::consts::TAU;

const NO_FILES: Experiment<'static> = Experiment { start: 0.0, stop: None, tolerance: None, resources: None };

/// The time of a turn at the default speed, s.
const TURN: f64 = 0.2;

fn start(set: impl FnOnce(&mut Stand)) -> Stand {
    let mut stand = Stand::default();
    set(&mut stand);
    stand.initialise(&NO_FILES, &mut ()).unwrap();
    stand
}

/// The means over the `span` seconds that follow, from readings at many short steps by Simpson's rule.
fn sampled(stand: &mut Stand, begin: f64, span: f64, parts: usize) -> Sensed {
    let step = span / parts as f64;
    let mut sums = stand.readings().sensed();
    for i in 0..parts {
        stand.advance(begin + i as f64 * step, step, &mut ()).unwrap();
        let weight = match i {
            _ if i + 1 == parts => 1.0,
            i if i % 2 == 0 => 4.0,
            _ => 2.0,
        };
        for (sum, value) in sums.iter_mut().zip(stand.readings().sensed()) {
            *sum += weight * value;
        }
    }
    sums.map(|sum| sum / (3 * parts) as f64)
}

#[track_caller]
fn assert_close(values: Sensed, expected: Sensed, bound: f64) {
    for (value, expected) in values.into_iter().zip(expected) {
        let apart = (value / expected - 1.0).abs();
        assert!(apart < bound, "{value} {expected}: {apart:e}");
    }
}

#[test]
fn the_means_are_those_of_the_readings() {
    let mut stand = start(|_| ());
    stand.advance(0.0, 3.0 * TURN, &mut ()).unwrap();
    let mut watched = stand.clone();
    let expected = sampled(&mut watched, 3.0 * TURN, TURN, 400);
    assert_close(watched.means(), expected, 1e-8);
    // The same turn in one step, and in steps of which none ends with it.
    let mut whole = stand.clone();
    whole.advance(3.0 * TURN, TURN, &mut ()).unwrap();
    assert_close(whole.means(), expected, 2e-6);
    for i in 0..9 {
        let step = 0.13 * TURN;
        let time = 3.0 * TURN + f64::from(i) * step;
        stand.advance(time, step, &mut ()).unwrap();
    }
    assert_close(stand.means(), expected, 2e-6);
}

#[test]
fn the_reynolds_film_s_means_are_those_of_its_readings() {
    let coarse = |stand: &mut Stand| {
        stand.film.model = FilmModel::Reynolds;
        (stand.bearing.resolution.columns, stand.bearing.resolution.rows) = (48, 6);
    };
    let mut stand = start(coarse);
    stand.advance(0.0, 2.0 * TURN, &mut ()).unwrap();
    let mut watched = stand.clone();
    let expected = sampled(&mut watched, 2.0 * TURN, TURN, 400);
    assert_close(watched.means(), expected, 2e-5);
    stand.advance(2.0 * TURN, TURN, &mut ()).unwrap();
    assert_close(stand.means(), expected, 2e-4);
}

#[test]
fn a_leap_ends_with_the_means_of_its_last_turn() {
    // The end of the step ends a turn, and it does not: then the turn that ended last begins where the leap landed.
    for (stop, rest) in [(150.0, 0.0), (150.05, 0.05)] {
        let mut leaped = start(|_| ());
        leaped.advance(0.0, stop, &mut ()).unwrap();
        let mut watched = start(|_| ());
        let begin = stop - rest - TURN;
        watched.advance(0.0, begin, &mut ()).unwrap();
        let expected = sampled(&mut watched, begin, TURN, 400);
        assert_close(leaped.means(), expected, 1e-5);
    }
}

#[test]
fn a_steady_start_knows_its_turn() {
    for (film, bound) in [(FilmModel::Mobility, 1e-6), (FilmModel::Reynolds, 1e-7)] {
        let mut stand = start(|stand| {
            stand.thermal.initialization = Initialization::SteadyState;
            stand.film.model = film;
            (stand.bearing.resolution.columns, stand.bearing.resolution.rows) = (48, 6);
        });
        let known = stand.means();
        let mut next = stand.clone();
        next.advance(0.0, TURN, &mut ()).unwrap();
        assert_close(next.means(), known, bound);
        // They stay until the next turn is complete.
        stand.advance(0.0, 0.5 * TURN, &mut ()).unwrap();
        assert_eq!(stand.means(), known);
    }
}

/// The last of the ten turns that take one period of the fluctuation.
#[test]
fn a_steady_start_knows_its_last_turn_of_several() {
    let mut stand = start(|stand| {
        stand.thermal.initialization = Initialization::SteadyState;
        stand.drive.fluctuation_amplitude = 0.025;
    });
    let known = stand.means();
    stand.advance(0.0, 9.0 * TURN, &mut ()).unwrap();
    assert!((stand.means()[1] / known[1] - 1.0).abs() > 1e-4);
    stand.advance(9.0 * TURN, TURN, &mut ()).unwrap();
    assert_close(stand.means(), known, 2e-6);
}

#[test]
fn the_means_follow_the_speed() {
    // Twice as fast backwards: the load's turn takes half the time.
    let mut stand = start(|stand| stand.inputs.speed.value = -20.0 * std::f64::consts::PI);
    stand.advance(0.0, TURN, &mut ()).unwrap();
    let expected = sampled(&mut stand, TURN, 0.5 * TURN, 400);
    assert_close(stand.means(), expected, 1e-8);
    let angle = stand.readings().shaft_angle;
    assert!((angle + 3.0 * TAU).abs() < 1e-9, "{angle}");
}

#[test]
fn without_a_turn_the_means_are_the_readings() {
    let stand = start(|stand| stand.inputs.speed.value = 0.0);
    assert_eq!(stand.means(), stand.readings().sensed());
}

/// In the dry bearing of a stiff case the implicit integrator takes over; its means are those of its own steps.
#[test]
fn stiff_cases_have_means_too() {
    let mut stand = start(|stand| {
        stand.oil.viscosity_scale = 1e-3;
        stand.bearing.surface.composite_modulus = 1e13;
        stand.thermal.isothermal = true;
    });
    stand.advance(0.0, 2.0 * TURN, &mut ()).unwrap();
    let mut watched = stand.clone();
    let expected = sampled(&mut watched, 2.0 * TURN, TURN, 400);
    stand.advance(2.0 * TURN, TURN, &mut ()).unwrap();
    assert_close(stand.means(), expected, 1e-4);
}
