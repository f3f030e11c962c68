//! The explicit Runge-Kutta pair 5(4) of Dormand & Prince (1980), J. Comput. Appl. Math. 6, 19-26, with
//! the stabilised step control of Hairer & Wanner (1996), Solving Ordinary Differential Equations II, IV.2.

use super::{Budget, Failure, Work, worst};

/// An integrator of `dy/dt = f(t, y)` for N unknowns.
pub struct DormandPrince<const N: usize> {
    /// The error allowed in each unknown per step, in its unit.
    pub allowed: [f64; N],
    /// The steps that one call may take.
    pub budget: Budget,
}

const A: [&[f64]; 6] = [
    &[1.0 / 5.0],
    &[3.0 / 40.0, 9.0 / 40.0],
    &[44.0 / 45.0, -56.0 / 15.0, 32.0 / 9.0],
    &[19372.0 / 6561.0, -25360.0 / 2187.0, 64448.0 / 6561.0, -212.0 / 729.0],
    &[9017.0 / 3168.0, -355.0 / 33.0, 46732.0 / 5247.0, 49.0 / 176.0, -5103.0 / 18656.0],
    &[35.0 / 384.0, 0.0, 500.0 / 1113.0, 125.0 / 192.0, -2187.0 / 6784.0, 11.0 / 84.0],
];
const C: [f64; 6] = [0.2, 0.3, 0.8, 8.0 / 9.0, 1.0, 1.0];
/// Fifth order minus fourth order weights.
const E: [f64; 7] =
    [71.0 / 57600.0, 0.0, -71.0 / 16695.0, 71.0 / 1920.0, -17253.0 / 339200.0, 22.0 / 525.0, -1.0 / 40.0];

impl<const N: usize> DormandPrince<N> {
    /// Takes `y` from 0 to `span` seconds. `step` is the first step to try and, afterwards, the step
    /// that suits the solution's end, whatever `span` cut it to.
    ///
    /// `f` gives besides the rates what is to be integrated along the way, without feeding back into the solution, with these errors
    /// `allowed` in the first integrals per step, and any in the others. Returns the integrals.
    pub fn integrate_along<const Q: usize, const CLOSE: usize>(
        &self,
        mut f: impl FnMut(f64, &[f64; N]) -> ([f64; N], [f64; Q]),
        y: &mut [f64; N],
        allowed: [f64; CLOSE],
        span: f64,
        step: &mut f64,
    ) -> Result<(Work, [f64; Q]), Failure> {
        let f = |t: f64, y: &[f64; N], k: &mut [f64; N], q: &mut [f64; Q]| (*k, *q) = f(t, y);
        let mut integrals = [0.0; Q];
        let sum = |passage: &Passage<Q>| {
            for (integral, part) in integrals.iter_mut().zip(passage.integrals) {
                *integral += part;
            }
        };
        let work = self.integrate_observed(f, y, allowed, span, step, sum)?;
        Ok((work, integrals))
    }

    /// The same; `f` writes into its arguments, which saves copies, and `observe` sees the integrals of each step that is taken.
    pub fn integrate_observed<const Q: usize, const CLOSE: usize>(
        &self,
        mut f: impl FnMut(f64, &[f64; N], &mut [f64; N], &mut [f64; Q]),
        y: &mut [f64; N],
        allowed: [f64; CLOSE],
        span: f64,
        step: &mut f64,
        mut observe: impl FnMut(&Passage<Q>),
    ) -> Result<Work, Failure> {
        let mut work = Work::default();
        let mut t = 0.0;
        let (mut k, mut q) = ([[0.0; N]; 7], [[0.0; Q]; 7]);
        f(0.0, y, &mut k[0], &mut q[0]);
        let mut last_log_error = LEAST_ERROR.ln();
        while t < span {
            let left = span - t;
            // Never leave a sliver for the last step.
            let h = if *step >= left {
                left
            } else if 2.0 * *step > left {
                0.5 * left
            } else {
                *step
            };
            let end = Self::stages(&mut f, t, y, h, &mut k, &mut q);
            let errors = [off(&k, h, &self.allowed), off(&q, h, &allowed)];
            let error = worst(errors.into_iter());
            if error <= 1.0 {
                let from = t;
                t = if h == left { span } else { t + h };
                *y = end;
                observe(&Passage::new(from, t, h, &q));
                (k[0], q[0]) = (k[6], q[6]);
                work.accepted += 1;
                let log_error = error.max(1e-10).ln();
                let growth = 0.9 * (0.4 / 5.0 * last_log_error - 0.7 / 5.0 * log_error).exp();
                last_log_error = log_error.max(LEAST_ERROR.ln());
                let next = h * growth.clamp(0.2, 10.0);
                // A step cut short by the span says nothing against the longer one.
                *step = if h < *step { next.max(*step) } else { next };
            } else {
                work.rejected += 1;
                let shrink = if error.is_finite() { 0.9 * error.powf(-0.2) } else { 0.1 };
                *step = h * shrink.clamp(0.1, 0.9);
                if *step < 1e-14 * span.max(1e-3) {
                    let (step, passed) = (*step, t);
                    return Err(Failure::StepTooSmall { step, passed });
                }
            }
            self.budget.check(work, t, span)?;
        }
        Ok(work)
    }

    fn stages<const Q: usize>(
        f: &mut impl FnMut(f64, &[f64; N], &mut [f64; N], &mut [f64; Q]),
        t: f64,
        y: &[f64; N],
        h: f64,
        k: &mut [[f64; N]; 7],
        q: &mut [[f64; Q]; 7],
    ) -> [f64; N] {
        let mut end = *y;
        for (stage, (row, c)) in A.iter().zip(C).enumerate() {
            // No reference to this one leaves the loop, so that it may stay in registers.
            let mut at = *y;
            for (a, slope) in row.iter().zip(&*k) {
                for (value, slope) in at.iter_mut().zip(slope) {
                    *value += h * a * slope;
                }
            }
            end = at;
            f(t + c * h, &end, &mut k[stage + 1], &mut q[stage + 1]);
        }
        end
    }
}

/// A step that was taken, with what was integrated along it.
#[derive(Clone, Copy, Debug)]
pub struct Passage<const Q: usize> {
    /// Its start, s.
    pub from: f64,
    /// Its end, s.
    pub to: f64,
    /// The integrals from `from` to `to`.
    pub integrals: [f64; Q],
    /// The integrands at `from` and at `to`.
    pub ends: [[f64; Q]; 2],
}

impl<const Q: usize> Passage<Q> {
    /// A step of `h` seconds from the integrands at its stages.
    fn new(from: f64, to: f64, h: f64, stages: &[[f64; Q]; 7]) -> Self {
        let means = weighted(A[5], stages);
        Self { from, to, integrals: means.map(|mean| h * mean), ends: [stages[0], stages[6]] }
    }

    /// A step of which only the ends are known, by the trapezoidal rule.
    pub fn between(from: f64, to: f64, ends: [[f64; Q]; 2]) -> Self {
        let mut integrals = ends[0];
        for (integral, end) in integrals.iter_mut().zip(ends[1]) {
            *integral = 0.5 * (to - from) * (*integral + end);
        }
        Self { from, to, integrals, ends }
    }

    /// The integrals over the first `share` (0..1) of the step, by the cubic that has the integrals' values and slopes at
    /// both ends (Hermite). At a share of one they are exact.
    pub fn until(&self, share: f64) -> [f64; Q] {
        let (s, duration) = (share, self.to - self.from);
        let rest = 1.0 - s;
        let mut integrals = [0.0; Q];
        for (i, integral) in integrals.iter_mut().enumerate() {
            *integral = s * s * (3.0 - 2.0 * s) * self.integrals[i]
                + duration * s * rest * (rest * self.ends[0][i] - s * self.ends[1][i]);
        }
        integrals
    }
}

/// The step control looks back at no smaller error than this.
const LEAST_ERROR: f64 = 1e-4;

/// The largest ratio of an error to what is allowed. States beyond the end of `allowed` have no limit.
fn off<const M: usize>(slopes: &[[f64; M]; 7], h: f64, allowed: &[f64]) -> f64 {
    let differences = weighted(&E, slopes).into_iter().zip(allowed);
    worst(differences.map(|(difference, allowed)| h * difference / allowed))
}

/// The weighted sum of the stages' slopes.
fn weighted<const M: usize>(weights: &[f64], slopes: &[[f64; M]; 7]) -> [f64; M] {
    let mut sums = [0.0; M];
    for (weight, slopes) in weights.iter().zip(slopes) {
        for (sum, slope) in sums.iter_mut().zip(slopes) {
            *sum += weight * slope;
        }
    }
    sums
}

#[cfg(test)]
mod tests {
    use super::*;

    impl<const N: usize> DormandPrince<N> {
        /// Without anything along the way.
        fn integrate(
            &self,
            mut f: impl FnMut(f64, &[f64; N]) -> [f64; N],
            y: &mut [f64; N],
            span: f64,
            step: &mut f64,
        ) -> Result<Work, Failure> {
            let f = |t: f64, y: &[f64; N]| (f(t, y), []);
            self.integrate_along(f, y, [], span, step).map(|(work, [])| work)
        }
    }

    const INTEGRATOR: DormandPrince<2> = DormandPrince { allowed: [1e-9; 2], budget: Budget::of(100_000) };

    #[test]
    fn an_oscillator_keeps_its_phase() {
        let mut y = [1.0, 0.0];
        let mut step = 1e-3;
        INTEGRATOR.integrate(|_, y| [y[1], -y[0]], &mut y, 10.0, &mut step).unwrap();
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
        let run = |h: f64| {
            let mut k = [[0.0; 2]; 7];
            let mut y = [1.0, 0.0];
            let mut f = |_: f64, y: &[f64; 2], k: &mut [f64; 2], _: &mut [f64; 0]| *k = [y[1], -y[0]];
            for _ in 0..(1.0 / h).round() as usize {
                f(0.0, &y, &mut k[0], &mut []);
                y = DormandPrince::<2>::stages(&mut f, 0.0, &y, h, &mut k, &mut [[]; 7]);
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
        let work = INTEGRATOR.integrate(|t, y| [-2000.0 * (y[0] - t.cos()), 0.0], &mut y, 1.0, &mut step).unwrap();
        assert!(work.accepted > 500);
        assert!((y[0] - 1f64.cos()).abs() < 1e-3);
    }

    #[test]
    fn what_stands_still_is_given_up_early_and_what_moves_on_is_not() {
        let integrator = DormandPrince { budget: Budget { at_once: 1000, per_second: 100.0, most: 2e6 }, ..INTEGRATOR };
        let run = |rate: f64, span: f64| {
            let rates = |t: f64, y: &[f64; 2]| [-rate * (y[0] - t.cos()), 0.0];
            integrator.integrate(rates, &mut [1.0, 0.0], span, &mut 1e-3)
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
        let work = integrator.integrate(rates, &mut [0.0], span, &mut step);
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
            let result = INTEGRATOR.integrate(rates, &mut [1.0, 0.0], span, &mut step);
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
        let result = INTEGRATOR.integrate(|_, _| [f64::NAN, 0.0], &mut y, 1.0, &mut step);
        assert!(matches!(result, Err(Failure::StepTooSmall { .. })));
    }
}
