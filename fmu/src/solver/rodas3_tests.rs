use nalgebra::{SVector, matrix, vector};
use plain_bearing_stand::solver::{Budget, Failure, Rodas3, Work};
use proptest::{
    strategy::{Strategy, ValueTree},
    test_runner::TestRunner,
};

fn robertson(y: &SVector<f64, 3>) -> SVector<f64, 3> {
    let (a, b, c) = (0.04 * y[0], 1e4 * y[1] * y[2], 3e7 * y[1] * y[1]);
    vector![b - a, a - b - c, c]
}

/// Robertson's problem at t = 40: reference of Hairer & Wanner (1996), section IV.10.
#[test]
fn a_stiff_problem_takes_few_steps() {
    let integrator = Rodas3 { allowed: [1e-6, 1e-9, 1e-6], budget: Budget::of(10_000) };
    let mut y = vector![1.0, 0.0, 0.0];
    let linear = |y: &SVector<f64, 3>| {
        let (d, e) = (1e4 * y[2], 1e4 * y[1]);
        let jacobian = matrix![-0.04, d, e; 0.04, -d - 6e7 * y[1], -e; 0.0, 6e7 * y[1], 0.0];
        Ok((robertson(y), jacobian))
    };
    let work = integrator.integrate(|y| Ok::<_, Failure>(robertson(y)), linear, &mut y, 40.0, 1e-4).unwrap();
    assert!((y[0] - 0.7158271).abs() < 2e-4, "{y}");
    assert!(work.accepted < 500, "{work:?}");
}

/// Steps that grow sixfold from a 7th, 43rd, 259th or 1555th of the span add up to all of it but for rounding: what is
/// left is a step shorter than any other, and the last one.
#[test]
fn a_sliver_at_the_end_is_no_failure() {
    let still = Rodas3 { allowed: [1.0], budget: Budget::of(100) };
    let mut runner = TestRunner::deterministic();
    let parts = [7.0, 43.0, 259.0, 1555.0];
    for number in 0..4000 {
        let span = (1e-3..1e4_f64).new_tree(&mut runner).unwrap().current();
        let first = span / parts[number % 4];
        let zero = SVector::<f64, 1>::zeros();
        let rates = |_: &SVector<f64, 1>| Ok::<_, Failure>(zero);
        let linear = |_: &SVector<f64, 1>| Ok((zero, matrix![0.0]));
        let done = still.integrate(rates, linear, &mut vector![1.0], span, first);
        assert!(done.is_ok(), "{span} s from {first} s: {done:?}");
    }
}

/// Where the accepted steps of `dy/dt = -y` began, found by a clock as a second unknown, and the work. The error of a
/// step of one second is `start * 2/243`; a step over which rates are no number is one that cannot be made.
fn falling(start: f64, first: f64, is_number: impl Fn(f64) -> bool) -> Result<(Vec<f64>, Work), Failure> {
    let integrator = Rodas3 { allowed: [2.0 / 243.0, f64::INFINITY], budget: Budget::of(1000) };
    let mut begun = Vec::new();
    let rates = |y: &SVector<f64, 2>| {
        let fall = if is_number(y[1]) { -y[0] } else { f64::NAN };
        Ok(vector![fall, 1.0])
    };
    let linear = |y: &SVector<f64, 2>| {
        begun.push(y[1]);
        Ok((vector![-y[0], 1.0], matrix![-1.0, 0.0; 0.0, 0.0]))
    };
    let work = integrator.integrate(rates, linear, &mut vector![start, 0.0], 10.0, first)?;
    Ok((begun, work))
}

#[test]
fn a_step_follows_the_error_of_the_one_before() {
    for (error, growth) in [(0.125, 1.8), (1.0, 0.9), (0.0, 6.0)] {
        let (begun, work) = falling(error, 1.0, |_| true).unwrap();
        assert!((begun[1] - 1.0).abs() < 1e-12, "{begun:?}");
        assert!((begun[2] - 1.0 - growth).abs() < 1e-12, "{begun:?}");
        assert_eq!((work.accepted, work.rejected), (begun.len(), 0));
    }
}

#[test]
fn a_step_with_too_large_an_error_is_made_again_and_counted() {
    let (begun, work) = falling(1.2, 1.0, |_| true).unwrap();
    let again = 0.9 * 1.2_f64.powf(-1.0 / 3.0);
    assert!((begun[1] - again).abs() < 1e-12, "{begun:?}");
    assert_eq!((work.accepted, work.rejected), (begun.len(), 1));
    // Where a step leads to what is no number, a tenth of it is tried.
    let (begun, work) = falling(1e-9, 5.0, |time| !(4.0..6.0).contains(&time)).unwrap();
    assert!((begun[1] - 0.5).abs() < 1e-12, "{begun:?}");
    assert_eq!((work.accepted, work.rejected), (begun.len(), 1));
}

#[test]
fn a_step_is_too_small_below_the_times_resolution() {
    // Each step is a tenth of the one before: the limit itself is tried, and what lies below is not.
    let limit = 1e-14 * 10.0;
    assert_eq!(10.0 * limit * 0.1, limit);
    let step = limit * 0.1;
    let failure = falling(1.0, 10.0 * limit, |_| false).unwrap_err();
    assert_eq!(failure, Failure::StepTooSmall { step, passed: 0.0 });
}

#[test]
fn the_order_is_three() {
    // Fixed steps: everything allowed, the span cut by hand.
    let integrator = Rodas3 { allowed: [f64::INFINITY], budget: Budget::of(10) };
    let run = |n: usize| {
        let mut y = vector![1.0];
        for _ in 0..n {
            let h = 1.0 / n as f64;
            integrator
                .integrate(
                    |y| Ok::<_, Failure>(vector![-0.5 * y[0].powi(3)]),
                    |y| Ok((vector![-0.5 * y[0].powi(3)], matrix![-1.5 * y[0] * y[0]])),
                    &mut y,
                    h,
                    h,
                )
                .unwrap();
        }
        (y[0] - 0.5f64.sqrt()).abs()
    };
    let order = (run(20) / run(40)).log2();
    assert!((order - 3.0).abs() < 0.2, "{order}");
}
