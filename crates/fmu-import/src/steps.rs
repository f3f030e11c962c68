//! The steps of a simulation.

use crate::call::Call;
use crate::instance::Instance;

impl Instance {
    /// Lets `step` seconds pass from `time`.
    ///
    /// # Errors
    /// When the step is refused or fails, and when the FMU ends the simulation by itself: then [`Call::ended`] says
    /// when, and the instance holds its last values.
    #[inline(never)]
    pub fn step(&mut self, time: f64, step: f64) -> Result<(), Call> {
        self.simulation.step(&mut self.caller, time, step)
    }

    /// Lets several steps pass, one after another, and reads real variables after each: `times` says when the steps
    /// begin and `sizes` how long they are, in s, `references` names the variables, and `rows` gets as many values a
    /// step. What a call costs beside the FMU's own work is paid once for all of them.
    ///
    /// Returns how many steps were taken and read, and why not all of them: see [`step`](Self::step) and
    /// [`reals`](Self::reals).
    ///
    /// # Panics
    /// When there are not as many times as sizes, or `rows` has no room for the values of all steps.
    #[inline(never)]
    pub fn steps(
        &mut self,
        times: &[f64],
        sizes: &[f64],
        references: &[u32],
        rows: &mut [f64],
    ) -> (usize, Result<(), Call>) {
        assert!(
            times.len() == sizes.len() && rows.len() >= times.len() * references.len(),
            "each step needs a size, and a row of its own"
        );
        self.simulation
            .steps(&mut self.caller, times, sizes, references, rows)
    }
}
