//! The thermal equilibrium that is reached from given temperatures, on the averaged heat balance. Wear, which never rests, is
//! held at the departure's depth.
//!
//! There may be several equilibria: friction that grows as the oil warms can hold a hot state beside a cold one. Newton's
//! method alone would find any of them. So the temperatures first follow their averaged drift, with error control, until an
//! equilibrium is less than [`NEAR`] away; Newton's method finishes there. This is pseudo-transient continuation (Kelley &
//! Keyes 1998, SIAM J. Numer. Anal. 35, 508-523) with the physical drift and an error bound on its steps, so that no step
//! leaves the basin of attraction.
//!
//! The equilibrium is stable if all eigenvalues of the linearised drift have negative real parts (Lyapunov's first method).

use super::{Across, Averaged, Departure, Matrix4, NoLeap, TwoScales, Vector4, orbit::Orbit, temperatures, vector};
use crate::{
    solver::{Budget, Rodas3},
    thermal::Temperatures,
};
use nalgebra::{Matrix2, SMatrix, linalg::Schur};
use thiserror::Error;

/// Why no equilibrium was found.
#[derive(Debug, Error)]
pub enum NoEquilibrium {
    /// No averaged heat at some temperature.
    #[error(transparent)]
    Orbit(#[from] NoLeap),
    /// The temperatures rise without end.
    #[error("after {after:.3e} s the {node} would be at {temperature:.0} K and still warming")]
    Runaway {
        /// The hottest node.
        node: &'static str,
        /// Its temperature, K.
        temperature: f64,
        /// When, s.
        after: f64,
    },
    /// The given temperatures are an equilibrium, but not one that lasts.
    #[error(
        "the equilibrium at a film temperature of {film:.2} K is unstable: a deviation grows e-fold in {growth:.0} s"
    )]
    Unstable {
        /// The film's temperature, K.
        film: f64,
        /// Time in which a small deviation grows e-fold, s.
        growth: f64,
    },
    /// The temperatures neither settle nor run away.
    #[error("the temperatures have not settled after {0:.3e} s")]
    Unsettled(f64),
}

/// A stable equilibrium of the averaged heat balance, with what Newton's method needs to refine it on resolved turns.
#[derive(Debug)]
pub struct Equilibrium {
    /// Eccentricity-ratio vector at the beginning of a turn, 1.
    pub eccentricity: [f64; 2],
    /// The temperatures, K.
    pub temperatures: Temperatures,
    /// Derivatives of the temperatures' rates, 1/s.
    pub drift: Matrix4,
    /// Derivative of the orbit's beginning over the temperatures, 1/K.
    pub shift: SMatrix<f64, 2, 4>,
    /// Derivative of a turn's end over its beginning, 1.
    pub slope: Matrix2<f64>,
    /// Derivative of the temperatures' mean rates in a turn over its beginning, K/s.
    pub heating: SMatrix<f64, 4, 2>,
}

/// Nearer than this to an equilibrium, Newton's method finishes, K.
const NEAR: f64 = 0.5;
/// Newton's steps end below this, K.
const CLOSE: f64 = 1e-6;
/// Newton's steps at most.
const STEPS: usize = 20;
/// Time constants that pass between two looks for an equilibrium.
const TIME_CONSTANTS: f64 = 6.0;
/// Looks at most.
const LOOKS: usize = 60;
/// Bounds of the time between two looks: in turns, and in s.
const LEAST_TURNS: f64 = 10.0;
const LONGEST: f64 = 1e8;
/// The error allowed in each temperature per step, K, on the way to an equilibrium.
const WAY_ERROR: f64 = 0.05;
/// No oil is left at this temperature, K.
const HOTTEST: f64 = 1000.0;
/// The change of a turn's beginning from which derivatives are taken.
const MOVED: f64 = 1e-6;
/// So near to an unstable equilibrium, K, the temperatures count as given there.
const ON_THE_RIDGE: f64 = 1e-3;

/// The equilibrium that the temperatures reach from those of the departure.
///
/// # Errors
/// When there is none, when it is unstable, or when the averaged heat cannot be computed.
pub fn equilibrium(
    model: &impl TwoScales,
    tolerance: f64,
    across: Across,
    from: &Departure,
) -> Result<Equilibrium, NoEquilibrium> {
    let mean = Averaged::new(model, None, tolerance, across, from)?;
    let integrator = Rodas3 { allowed: [WAY_ERROR; 4], budget: Budget::of(100_000) };
    let mut t = vector(&from.temperatures);
    let mut passed = 0.0;
    for _ in 0..LOOKS {
        let (rates, drift) = mean.linear(&t)?;
        if rates.amax() == 0.0 && drift.amax() == 0.0 {
            // Isothermal: the temperatures stay wherever they are.
            return settled(&mean, &t, drift);
        }
        let time_constant = slowest_time_constant(&drift);
        let distance = newton(&rates, &drift).map_or(f64::INFINITY, |step| step.amax());
        if distance < NEAR && time_constant > 0.0 {
            if let Some(equilibrium) = finish(&mean, t)? {
                return Ok(equilibrium);
            }
        } else if distance < ON_THE_RIDGE {
            return Err(NoEquilibrium::Unstable { film: t[0], growth: -time_constant });
        }
        let span = (TIME_CONSTANTS * time_constant.abs()).clamp(LEAST_TURNS * model.period(), LONGEST);
        integrator.integrate(
            // Where a trial step goes too far for an orbit, a shorter one follows.
            |t| Ok(mean.rates(t).unwrap_or(Vector4::repeat(f64::NAN))),
            |t| check(t, passed).and_then(|()| Ok(mean.linear(t)?)),
            &mut t,
            span,
            model.period(),
        )?;
        passed += span;
    }
    Err(NoEquilibrium::Unsettled(passed))
}

impl From<crate::solver::Failure> for NoEquilibrium {
    fn from(failure: crate::solver::Failure) -> Self {
        Self::Orbit(failure.into())
    }
}

/// Ends the way where no oil is left.
fn check(t: &Vector4, after: f64) -> Result<(), NoEquilibrium> {
    const NODES: [&str; 4] = ["film", "bush", "shaft", "oil"];
    let hottest = t.imax();
    if t[hottest] < HOTTEST {
        return Ok(());
    }
    Err(NoEquilibrium::Runaway { node: NODES[hottest], temperature: t[hottest], after })
}

/// The change of the temperatures that Newton's method proposes, K.
fn newton(rates: &Vector4, drift: &Matrix4) -> Option<Vector4> {
    let step = drift.lu().solve(&-rates)?;
    step.iter().all(|x| x.is_finite()).then_some(step)
}

/// Newton's method from temperatures near an equilibrium; `None` if there is none that is near and stable.
fn finish<M: TwoScales>(mean: &Averaged<'_, M>, near: Vector4) -> Result<Option<Equilibrium>, NoEquilibrium> {
    let mut t = near;
    for _ in 0..STEPS {
        let (rates, drift) = mean.linear(&t)?;
        let Some(step) = newton(&rates, &drift) else {
            break;
        };
        t += step;
        if (t - near).amax() > 2.0 * NEAR {
            break;
        }
        if step.amax() < CLOSE {
            if slowest_time_constant(&drift) <= 0.0 {
                break;
            }
            return settled(mean, &t, drift).map(Some);
        }
    }
    Ok(None)
}

/// The equilibrium at known temperatures.
fn settled<M: TwoScales>(mean: &Averaged<'_, M>, t: &Vector4, drift: Matrix4) -> Result<Equilibrium, NoEquilibrium> {
    let here = mean.orbit(t, mean.worn)?;
    let clearance = mean.clearance(t, mean.worn);
    let mut shift = SMatrix::<f64, 2, 4>::zeros();
    for column in 0..4 {
        let mut nudged = *t;
        nudged[column] += mean.nudge;
        if mean.follows(column, &nudged, clearance) {
            let ahead = mean.orbit(&nudged, mean.worn)?.place();
            shift.set_column(column, &((ahead - here.place()) / mean.nudge));
        }
    }
    let slope = mean.curves.borrow().slope();
    let at_here = mean.rates_under(t, mean.worn, &here.flows());
    let mut heating = SMatrix::<f64, 4, 2>::zeros();
    for column in 0..2 {
        let ahead = Orbit(here.0 + slope.column(column) * MOVED);
        let rates = mean.rates_under(t, mean.worn, &ahead.flows());
        heating.set_column(column, &((rates - at_here) / MOVED));
    }
    Ok(Equilibrium {
        eccentricity: here.place().into(),
        temperatures: temperatures(t),
        drift,
        shift,
        slope: slope.fixed_rows::<2>(0).into(),
        heating,
    })
}

/// The longest time constant of a linear drift, s: the time in which the slowest deviation shrinks e-fold, or, with a
/// negative sign, in which the fastest-growing one grows e-fold. At most 10^12 s, and zero for a drift that is not finite.
pub fn slowest_time_constant(drift: &Matrix4) -> f64 {
    /// Steps for an eigenvalue; the QR algorithm takes some three.
    const MOST: usize = 1000;
    /// A longer time constant than this, s, is none.
    const FOREVER: f64 = 1e12;
    let finite = drift.iter().all(|x| x.is_finite());
    let Some(schur) = finite.then(|| Schur::try_new(*drift, f64::EPSILON, MOST)).flatten() else {
        return 0.0;
    };
    let eigenvalues = schur.complex_eigenvalues();
    let slowest = eigenvalues.iter().map(|eigenvalue| eigenvalue.re).fold(f64::NEG_INFINITY, f64::max);
    if slowest.abs() < 1.0 / FOREVER {
        return FOREVER;
    }
    -1.0 / slowest
}
