//! Derivatives over time and along directions.

use fmu_export::fmi2::calls;
use lag::Lag;

use crate::answer;
use crate::host::{Error, Host, Ok, vr};

#[test]
fn inputs_with_slopes_meet_the_exact_solution() {
    let host = Host::started();
    for i in 0..10 {
        let t = f64::from(i) * 0.1;
        assert_eq!([host.set("input", t), host.slope("input", 1, 1.0), host.step(t, 0.1)], [Ok; 3]);
    }
    // tau y' = 2 t - y, y(0) = 1
    let exact = 2.0 * (1.0 - 0.5) + (1.0 + 2.0 * 0.5) * (-1.0 / 0.5_f64).exp();
    assert!((host.get("output") - exact).abs() < 1e-13);
    let held = host.get("input");
    assert_eq!(host.step(1.0, 0.1), Ok);
    assert_eq!(host.get("input"), held, "slopes hold for one step");
}

#[test]
fn output_derivatives_known_and_by_difference() {
    let host = Host::started();
    assert_eq!([host.set("input", 3.0), host.step(0.0, 0.2)], [Ok; 2]);
    let before = host.get("output");
    assert!((before - answer(3.0, 0.2)).abs() < 1e-14);
    let rate = (6.0 - before) / 0.5;
    assert!((host.rate("output") - rate).abs() < 1e-12);
    assert_eq!(host.slope("input", 1, 4.0), Ok);
    assert!((host.rate("feed") - 8.0).abs() < 1e-6, "{}", host.rate("feed"));
    assert_eq!(host.get("output"), before, "nothing has moved");
}

#[test]
fn directional_derivatives() {
    let host = Host::new();
    assert_eq!(host.enter(), Ok);
    assert!((host.derivative("output", "initialState") - 1.0).abs() < 1e-9);
    assert_eq!([host.set("input", 3.0), host.exit()], [Ok; 2]);
    assert!((host.derivative("feed", "input") - 2.0).abs() < 1e-9);
    assert!((host.derivative("feed", "gain") - 3.0).abs() < 1e-9);
    assert_eq!(host.derivative("output", "input"), 0.0);
    // At a bound the difference is one-sided.
    assert_eq!(host.set("input", 1e6), Ok);
    assert!((host.derivative("feed", "input") - 2.0).abs() < 1e-8);
    assert_eq!(host.get("input"), 1e6);
    let mut value = 0.0;
    let derivative = |unknown, known, direction| {
        // SAFETY: one value each.
        unsafe {
            calls::fmi2GetDirectionalDerivative::<Lag>(
                host.component,
                &vr(unknown),
                1,
                &vr(known),
                1,
                &direction,
                &mut value,
            )
        }
    };
    let mut derivative = derivative;
    assert_eq!(derivative("feed", "input", 0.0), Ok);
    assert_eq!(derivative("feed", "input", f64::NAN), Error);
    assert_eq!(derivative("input", "input", 1.0), Error);
    assert_eq!(derivative("feed", "timeConstant", 1.0), Error);
    assert_eq!(derivative("feed", "inverted", 1.0), Error);
}
