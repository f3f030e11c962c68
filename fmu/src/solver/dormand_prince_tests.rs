use plain_bearing_stand::solver::{Budget, DormandPrince, Failure, Passage, Work, dormand_prince::LEAST_ERROR};

/// Integrates without anything along the way.
fn integrate<const N: usize>(
    integrator: &DormandPrince<N>,
    mut f: impl FnMut(f64, &[f64; N]) -> [f64; N],
    y: &mut [f64; N],
    span: f64,
    step: &mut f64,
) -> Result<Work, Failure> {
    let f = |t: f64, y: &[f64; N]| (f(t, y), []);
    integrator.integrate_along(f, y, [], span, step).map(|(work, [])| work)
}

const INTEGRATOR: DormandPrince<2> = DormandPrince { allowed: [1e-9; 2], budget: Budget::of(100_000) };

#[test]
fn an_oscillator_keeps_its_phase() {
    let mut y = [1.0, 0.0];
    let mut step = 1e-3;
    integrate(&INTEGRATOR, |_, y| [y[1], -y[0]], &mut y, 10.0, &mut step).unwrap();
    assert!((y[0] - 10f64.cos()).abs() < 1e-7 && (y[1] + 10f64.sin()).abs() < 1e-7);
}

#[test]
fn integrals_along_the_way_are_as_good_as_the_solution() {
    let (mut y, mut step) = ([1.0, 0.0], 1e-3);
    let along = [1e-9];
    let (_, [square]) =
        INTEGRATOR.integrate_along(|_, y| ([y[1], -y[0]], [y[0] * y[0]]), &mut y, along, 3.0, &mut step).unwrap();
    let exact = 0.5 * (3.0 + 3f64.sin() * 3f64.cos());
    assert!((square - exact).abs() < 1e-7, "{square} {exact}");
}

/// The integral of 1 + t - 0.6 t^2 is a cubic, and so is that of 2 t^2.
#[test]
fn a_part_of_a_step_has_the_integrals_of_a_cubic() {
    let integrand = |t: f64| [1.0 + t - 0.6 * t * t, 2.0 * t * t];
    let integral = |t: f64| [t + 0.5 * t * t - 0.2 * t.powi(3), 2.0 / 3.0 * t.powi(3)];
    let between = |from, to| {
        let [from, to] = [integral(from), integral(to)];
        [to[0] - from[0], to[1] - from[1]]
    };
    let mut passages = Vec::new();
    let rates = |t: f64, _: &[f64; 2], k: &mut [f64; 2], q: &mut [f64; 2]| (*k, *q) = ([0.0, 0.0], integrand(t));
    let (mut y, mut step) = ([1.0, 0.0], 0.5);
    INTEGRATOR
        .integrate_observed(rates, &mut y, [], 3.0, &mut step, |p| {
            passages.push(*p);
        })
        .unwrap();
    let mut start = 0.0;
    for passage in &passages {
        let Passage { from, to, ends, .. } = *passage;
        assert_eq!(from, start);
        assert_eq!(ends, [integrand(from), integrand(to)]);
        for share in [0.0, 0.3, 0.8, 1.0] {
            let parts = passage.until(share);
            let expected = between(from, from + share * (to - from));
            for (part, expected) in parts.iter().zip(expected) {
                assert!((part - expected).abs() < 1e-13, "{passage:?} {share}");
            }
        }
        start = to;
    }
    assert!(passages.len() > 1);
    assert_eq!(start, 3.0);
}

#[test]
fn of_a_step_between_two_values_the_trapezium_is_known() {
    let passage = Passage::between(1.0, 3.0, [[2.0, -1.0], [5.0, 4.0]]);
    assert_eq!([passage.from, passage.to], [1.0, 3.0]);
    assert_eq!(passage.integrals, [7.0, 3.0]);
    assert_eq!(passage.ends, [[2.0, -1.0], [5.0, 4.0]]);
}

#[test]
fn the_order_is_five() {
    // Fixed steps: everything allowed, the span cut by hand.
    let integrator = DormandPrince { allowed: [f64::INFINITY; 2], ..INTEGRATOR };
    let run = |h: f64| {
        let mut y = [1.0, 0.0];
        for _ in 0..(1.0 / h).round() as usize {
            let mut step = h;
            let work = integrate(&integrator, |_, y| [y[1], -y[0]], &mut y, h, &mut step).unwrap();
            assert_eq!((work.accepted, work.rejected), (1, 0));
        }
        (y[0] - 1f64.cos()).abs()
    };
    let order = (run(0.1) / run(0.05)).log2();
    assert!((order - 5.0).abs() < 0.3, "{order}");
}

#[test]
fn a_stiff_fall_is_followed_in_short_steps() {
    let mut y = [1.0, 0.0];
    let mut step = 1.0;
    let work = integrate(&INTEGRATOR, |t, y| [-2000.0 * (y[0] - t.cos()), 0.0], &mut y, 1.0, &mut step).unwrap();
    assert!(work.accepted > 500);
    assert!((y[0] - 1f64.cos()).abs() < 1e-3);
}

#[test]
fn what_stands_still_is_given_up_early_and_what_moves_on_is_not() {
    let integrator = DormandPrince { budget: Budget { at_once: 1000, per_second: 100.0, most: 2e6 }, ..INTEGRATOR };
    let run = |rate: f64, span: f64| {
        let rates = |t: f64, y: &[f64; 2]| [-rate * (y[0] - t.cos()), 0.0];
        integrate(&integrator, rates, &mut [1.0, 0.0], span, &mut 1e-3)
    };
    // Some 4 steps a second from stiffness, and some 30 for the cosine.
    let work = run(10.0, 1000.0).unwrap();
    assert!(work.accepted > 10_000, "{work:?}");
    let Err(Failure::TooManySteps { steps, passed, .. }) = run(1e6, 1000.0) else {
        panic!("not given up");
    };
    assert!(steps <= 1100 && passed < 0.01, "{steps} {passed}");
    let Err(Failure::SpanTooLong { needed, passed }) = run(10.0, 1e6) else {
        panic!("not given up");
    };
    assert!(needed > 1e6 && passed < 1000.0, "{needed} {passed}");
}

/// The error of a step of h s for `dy/dt = t^4`, wherever it begins: the fifth order is exact, the fourth is not.
fn quartic_error(h: f64) -> f64 {
    71.0 / 270_000.0 * h.powi(5)
}

/// Follows `dy/dt = t^4`, with half of what is allowed as the error of a step of one second. Returns where the steps
/// ended that were tried, the work, and the next step.
fn quartic(span: f64, mut step: f64) -> (Vec<f64>, Work, f64) {
    let integrator = DormandPrince { allowed: [2.0 * quartic_error(1.0)], budget: Budget::of(10_000) };
    let mut times = Vec::new();
    let rates = |t: f64, _: &[f64; 1]| {
        times.push(t);
        [t.powi(4)]
    };
    let work = integrate(&integrator, rates, &mut [0.0], span, &mut step);
    let ends = times[1..].chunks(6).map(|stages| stages[5]).collect();
    (ends, work.unwrap(), step)
}

/// Growth of the step by the control of Hairer & Wanner.
fn growth(error: f64, error_before: f64) -> f64 {
    0.9 * error.powf(-0.7 / 5.0) * error_before.powf(0.4 / 5.0)
}

#[track_caller]
fn assert_close(values: &[f64], expected: &[f64]) {
    let same = values.len() == expected.len();
    let mut pairs = values.iter().zip(expected);
    let close = same && pairs.all(|(a, b)| (a - b).abs() <= 1e-12 * b);
    assert!(close, "{values:?}, expected {expected:?}");
}

#[test]
fn a_step_follows_its_error_and_the_one_before() {
    let second = growth(0.5, LEAST_ERROR);
    let third = second * growth(0.5 * second.powi(5), 0.5);
    let (ends, _, _) = quartic(100.0, 1.0);
    assert_close(&ends[..3], &[1.0, 1.0 + second, 1.0 + second + third]);
}

#[test]
fn a_step_with_too_large_an_error_is_made_again_and_counted() {
    let again = 2.0 * 0.9 * 16_f64.powf(-0.2);
    let next = again * growth(0.5 * again.powi(5), LEAST_ERROR);
    let (ends, work, _) = quartic(10.0, 2.0);
    assert_close(&ends[..3], &[2.0, again, again + next]);
    assert_eq!((work.accepted, work.rejected), (ends.len() - 1, 1));
}

#[test]
fn the_last_two_steps_share_what_is_left() {
    assert_close(&quartic(1.0, 0.6).0, &[0.5, 1.0]);
    assert_close(&quartic(1.0, 1.1).0, &[1.0]);
}

#[test]
fn a_step_that_the_span_cuts_short_shortens_no_other() {
    assert_eq!(quartic(1.0, 10.0).2, 10.0);
    assert_eq!(quartic(1e-3, 2e-3).2, 1e-2);
    assert_close(&[quartic(1.0, 1.0).2], &[growth(0.5, LEAST_ERROR)]);
}

#[test]
fn a_step_is_too_small_below_the_times_resolution() {
    let given_up_at = |span: f64, first: f64| {
        let (mut step, rates) = (first, |_: f64, _: &[f64; 2]| [f64::NAN, 0.0]);
        let result = integrate(&INTEGRATOR, rates, &mut [1.0, 0.0], span, &mut step);
        let Err(Failure::StepTooSmall { step, passed }) = result else {
            panic!("{result:?}");
        };
        assert_eq!(passed, 0.0);
        step
    };
    // Each step is a tenth of the one before: the limit itself is tried, and what lies below is not.
    let limit = 1e-14 * 0.3;
    assert_eq!(10.0 * limit * 0.1, limit);
    assert_eq!(given_up_at(0.3, 10.0 * limit), limit * 0.1);
    assert_eq!(given_up_at(1e-6, 5e-17), 5e-17 * 0.1);
}

#[test]
fn what_is_no_number_is_an_error() {
    let mut y = [1.0, 0.0];
    let mut step = 0.1;
    let result = integrate(&INTEGRATOR, |_, _| [f64::NAN, 0.0], &mut y, 1.0, &mut step);
    assert!(matches!(result, Err(Failure::StepTooSmall { .. })));
}
