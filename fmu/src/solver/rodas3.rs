//! The linearly implicit, L-stable Rosenbrock method RODAS3 of order 3(2) for stiff systems:
//! Sandu, Verwer, Blom, Spee, Carmichael & Potra (1997), Atmospheric Environment 31, 3459-3472, eq. 3.4.

use super::{Budget, Failure, Work, worst};
use nalgebra::{Const, DimMin, SMatrix, SVector, ToTypenum};

/// An integrator of the autonomous system `dy/dt = f(y)` for N unknowns.
pub struct Rodas3<const N: usize> {
    /// The error allowed in each unknown per step, in its unit.
    pub allowed: [f64; N],
    /// The steps that one call may take.
    pub budget: Budget,
}

impl<const N: usize> Rodas3<N>
where
    Const<N>: ToTypenum + DimMin<Const<N>, Output = Const<N>>,
{
    /// Takes `y` over `span` seconds, beginning with a step of `first` seconds. `f` gives the rates and
    /// may fail with an error of its own; `linear` gives the rates with their derivatives over the unknowns.
    pub fn integrate<E: From<Failure>>(
        &self,
        mut f: impl FnMut(&SVector<f64, N>) -> Result<SVector<f64, N>, E>,
        mut linear: impl FnMut(&SVector<f64, N>) -> Result<(SVector<f64, N>, SMatrix<f64, N, N>), E>,
        y: &mut SVector<f64, N>,
        span: f64,
        first: f64,
    ) -> Result<Work, E> {
        let mut work = Work::default();
        let (mut t, mut step) = (0.0, first.min(span));
        let (mut rates, mut jacobian) = linear(y)?;
        while t < span {
            let left = span - t;
            let h = step.min(left);
            // gamma = 1/2.
            let system = SMatrix::<f64, N, N>::identity() * (2.0 / h) - jacobian;
            let lu = system.lu();
            let solve = |right: SVector<f64, N>| {
                lu.solve(&right).ok_or_else(|| E::from(Failure::StepTooSmall { step: h, passed: t }))
            };
            let u1 = solve(rates)?;
            let u2 = solve(rates + u1 * (4.0 / h))?;
            let at3 = *y + u1 * 2.0;
            let u3 = solve(f(&at3)? + (u1 - u2) / h)?;
            let at4 = at3 + u3;
            let u4 = solve(f(&at4)? + (u1 - u2 - u3 * (8.0 / 3.0)) / h)?;
            let error = worst((0..N).map(|i| u4[i] / self.allowed[i]));
            if error.is_finite() && error <= 1.0 {
                *y = at4 + u4;
                t = if h == left { span } else { t + h };
                work.accepted += 1;
                if t < span {
                    (rates, jacobian) = linear(y)?;
                }
            } else {
                work.rejected += 1;
            }
            let factor = if error.is_finite() { 0.9 * error.max(1e-12).powf(-1.0 / 3.0) } else { 0.1 };
            step = h * factor.clamp(0.1, 6.0);
            // The last step may be a sliver that rounding left; what it suggests for a further one does not matter.
            if t < span && step < 1e-14 * span {
                return Err(Failure::StepTooSmall { step, passed: t }.into());
            }
            self.budget.check(work, t, span)?;
        }
        Ok(work)
    }
}
