use plain_bearing_stand::{
    sensors::{SENSORS, TurnMeans},
    solver::Passage,
};
use std::f64::consts::TAU;

/// The signal `3 + cos(angle)` of a shaft that turns at `speed`, in parts of `step` s. Returns the mean's error
/// after each.
fn errors(speed: f64, step: f64, parts: usize, expected: f64) -> Vec<f64> {
    let mut turn = TurnMeans::default();
    let signal = |t: f64| [3.0 + (speed * t).cos(); SENSORS];
    let integral = |t: f64| 3.0 * t + (speed * t).sin() / speed;
    let add = |k: usize| {
        let [from, to] = [k, k + 1].map(|k| k as f64 * step);
        let passage =
            Passage { from, to, integrals: [integral(to) - integral(from); SENSORS], ends: [signal(from), signal(to)] };
        turn.add(&passage, speed * step);
        turn.means().map_or(f64::NAN, |means| means[0] - expected)
    };
    (0..parts).map(add).collect()
}

#[test]
fn whole_turns_have_the_mean_of_the_signal() {
    for speed in [TAU, -TAU] {
        // Parts that end with the turn, that do not, and that are longer than a turn.
        for (step, bound) in [(0.05, 1e-12), (0.0371, 1e-6), (1.0, 1e-12), (2.0, 1e-12)] {
            let first = (1.0_f64 / step).ceil() as usize;
            for error in &errors(speed, step, 80, 3.0)[first.max(1) - 1..] {
                assert!(error.abs() < bound, "{speed} {step}: {error:e}");
            }
        }
    }
}

#[test]
fn the_cubic_between_a_part_s_ends_is_of_fourth_order() {
    let worst = |step: f64| {
        let errors = errors(TAU, step, 400, 3.0);
        errors[200..].iter().fold(0.0, |a: f64, b| a.max(b.abs()))
    };
    let order = (worst(0.0742) / worst(0.0371)).log2();
    assert!(order > 3.5, "{order}");
}

#[test]
fn before_the_first_turn_ends_the_mean_is_that_so_far() {
    let quarter = 3.0 + 2.0 / std::f64::consts::PI;
    assert!(errors(TAU, 0.25, 1, quarter)[0].abs() < 1e-12);
    assert_eq!(TurnMeans::default().means(), None);
}

#[test]
fn a_restart_forgets_and_a_known_turn_lasts_until_the_next() {
    let known = [7.0; SENSORS];
    let mut turn = TurnMeans::after(known);
    let part = Passage::between(0.0, 0.6, [[1.0; SENSORS]; 2]);
    turn.add(&part, 0.6 * TAU);
    assert_eq!(turn.means(), Some(known));
    turn.add(&part, 0.6 * TAU);
    let one = turn.means().map_or(0.0, |means| means[0]);
    assert!((one - 1.0).abs() < 1e-12, "{one}");
    turn.restart();
    assert_eq!(turn.means(), None);
}
