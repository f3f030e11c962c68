//! Implicit steps for stiff cases, in which one unknown settles far faster than the others move: a journal on hard, rough
//! surfaces in thin oil, or a film almost without heat capacity.

use super::{FIRST_STEP, SCALES, Stand, Unknowns, unknowns, validity::SeenByLimits};
use crate::{
    oil::Nearby,
    sensors::SENSORS,
    solver::{Budget, Failure, Passage, Rodas3},
};
use nalgebra::{SMatrix, SVector};

/// The unknowns and the time, s: with the time among the unknowns, the system is autonomous.
type Extended = SVector<f64, 8>;
type Jacobian = SMatrix<f64, 8, 8>;

/// Step of the differences for the Jacobian: relative to an unknown's scale, and in seconds.
const NUDGE: f64 = 1e-8;

/// Budget of internal steps: before any time has passed, further ones per second and per turn, and in all. It is smaller
/// than that of explicit steps, because implicit ones either need few steps or do not help.
const STEPS_AT_ONCE: usize = 5_000;
const STEPS_PER_SECOND: f64 = 5e4;
const STEPS_PER_TURN: f64 = 1e3;
const MOST_STEPS: f64 = 5e6;

impl Stand {
    /// The unknowns `span` seconds after the present state. `allowed` is the error allowed in each of them per step;
    /// `observe` sees each step that is taken.
    pub fn resolve_stiffly(
        &self,
        span: f64,
        allowed: &Unknowns,
        mut observe: impl FnMut(&Passage<SENSORS>, &SeenByLimits),
    ) -> Result<Unknowns, Failure> {
        let [ex, ey, film, bush, shaft, bath, worn] = *allowed;
        let integrator = Rodas3 {
            allowed: [ex, ey, film, bush, shaft, bath, worn, f64::INFINITY],
            budget: Budget {
                at_once: STEPS_AT_ONCE,
                per_second: STEPS_PER_SECOND + STEPS_PER_TURN / self.turn(),
                most: MOST_STEPS,
            },
        };
        let mut x = Extended::zeros();
        x.as_mut_slice()[..7].copy_from_slice(&unknowns(&self.state));
        let (mut oil, mut oil_beside, mut oil_there) = (self.nearby, self.nearby, self.nearby);
        let (mut before, mut seen) = (None, SeenByLimits::default());
        let mut pass = |x: &Extended| {
            let (_, now) = self.course_at(x[7], &state_of(x), &mut oil_there, &mut seen);
            if let Some((from, sensed)) = before.replace((x[7], now)) {
                observe(&Passage::between(from, x[7], [sensed, now]), &seen);
            }
        };
        let rates = |x: &Extended| Ok(self.extended_rates(x, &mut oil));
        // The system is linearised once at the beginning of each step.
        let linear = |x: &Extended| {
            pass(x);
            Ok(self.linearised(x, &mut oil_beside))
        };
        integrator.integrate(rates, linear, &mut x, span, FIRST_STEP)?;
        pass(&x);
        Ok(state_of(&x))
    }

    fn extended_rates(&self, x: &Extended, oil: &mut Nearby) -> Extended {
        let mut rates = Extended::repeat(1.0);
        let (course, _) = self.course_at(x[7], &state_of(x), oil, &mut SeenByLimits::default());
        rates.as_mut_slice()[..7].copy_from_slice(&course);
        rates
    }

    /// The rates, and their derivatives by differences.
    fn linearised(&self, x: &Extended, oil: &mut Nearby) -> (Extended, Jacobian) {
        let here = self.extended_rates(x, oil);
        let mut jacobian = Jacobian::zeros();
        for column in 0..8 {
            let scale = SCALES.get(column).unwrap_or(&1.0);
            let mut nudged = *x;
            // The journal is moved towards the middle, as there may be no room towards the bush.
            nudged[column] -= (NUDGE * scale).copysign(x[column]);
            let change = self.extended_rates(&nudged, oil) - here;
            jacobian.set_column(column, &(change / (nudged[column] - x[column])));
        }
        (here, jacobian)
    }
}

fn state_of(x: &Extended) -> Unknowns {
    let [ex, ey, film, bush, shaft, bath, worn, _] = (*x).into();
    [ex, ey, film, bush, shaft, bath, worn]
}
