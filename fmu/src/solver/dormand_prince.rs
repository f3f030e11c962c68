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
pub const LEAST_ERROR: f64 = 1e-4;

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
