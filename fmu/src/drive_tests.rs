use plain_bearing_stand::drive::{Command, Drive};
use std::f64::consts::TAU;

#[test]
fn angle_is_the_integral_of_speed() {
    for fluctuation_frequency in [1e-300, 1e-12, 1e-3, 1e-2, 0.1, 3.7] {
        check_angle(fluctuation_frequency);
    }
}

fn check_angle(fluctuation_frequency: f64) {
    let drive = Drive { fluctuation_amplitude: 0.9, fluctuation_frequency, ..Drive::default() };
    let command = Command { time: 1.3, speed: 31.4, slope: -12.0 };
    let (n, tau) = (2000, 0.9);
    let dx = tau / n as f64;
    // Simpson's rule.
    let sum: f64 = (0..=n)
        .map(|i| {
            let weight = match i {
                0 => 1.0,
                i if i == n => 1.0,
                i if i % 2 == 1 => 4.0,
                _ => 2.0,
            };
            weight * drive.speed(&command, i as f64 * dx)
        })
        .sum();
    let expected = sum * dx / 3.0;
    let turned = drive.turned(&command, tau);
    assert!((turned - expected).abs() < 1e-12 * expected, "{fluctuation_frequency} Hz: {turned}, {expected}");
}

/// At 300 rpm a turn takes 0.2 s.
#[test]
fn speed_and_angle_repeat_after_their_common_turns() {
    for (fluctuation_frequency, turns) in [(0.5, 10), (1.5, 10), (5.0, 1), (50.0, 1), (0.0, 1)] {
        let drive = Drive { fluctuation_amplitude: 0.5, fluctuation_frequency, ..Drive::default() };
        let command = Command { time: 1.3, speed: -10.0 * std::f64::consts::PI, slope: 0.0 };
        assert_eq!(drive.common_turns(command.speed), Some(turns));
        let span = 0.2 * f64::from(turns);
        let turned = drive.turned(&command, span) / TAU;
        assert!((turned + f64::from(turns)).abs() < 1e-12, "{turned}");
        let [now, then] = [0.0, span].map(|tau| drive.speed(&command, tau));
        assert!((now - then).abs() < 1e-11, "{now} {then}");
    }
}

#[test]
fn not_every_fluctuation_repeats_with_the_turns() {
    let turns = |fluctuation_frequency, speed| {
        let drive = Drive { fluctuation_amplitude: 0.5, fluctuation_frequency, ..Drive::default() };
        drive.common_turns(speed)
    };
    assert_eq!(turns(5.0 / 64.0, TAU * 5.0), Some(64));
    for frequency in [5.0 / 65.0, 0.5 * std::f64::consts::SQRT_2, 1e-12] {
        assert_eq!(turns(frequency, TAU * 5.0), None);
    }
    assert_eq!(turns(0.5, 0.0), None);
    assert_eq!(Drive::default().common_turns(0.0), Some(1));
}

#[test]
fn a_constant_speed_turns_exactly() {
    let command = Command { time: 7.0, speed: 10.0 * std::f64::consts::PI, slope: 0.0 };
    assert_eq!(Drive::default().turned(&command, 0.2), TAU);
}
