//! One simulation of an FMU.

use std::sync::Arc;

use crate::{
    call::{Called, Warnings},
    library::Library,
    logger::Log,
    simulation::{Batch, Experiment, Simulation},
    value::{Handle, Value},
};

/// One instance. It may move between threads, but only one at a time may use it.
#[derive(Debug)]
pub struct Instance {
    library: Arc<Library>,
    simulation: Box<dyn Simulation>,
    /// The first step of the present simulation, s, where all must have its size.
    first_step: Option<f64>,
}

impl Instance {
    /// Creates an instance.
    ///
    /// # Errors
    /// When the FMU refuses.
    pub fn new(library: &Arc<Library>, name: &str) -> Called<Self> {
        let simulation = library.instantiate(name)?;
        Ok(Self { library: Arc::clone(library), simulation, first_step: None })
    }

    /// Whether the FMU is unusable after `fmi2Fatal` or `fmi3Fatal`: nothing may be called any more.
    pub fn is_dead(&self) -> bool {
        self.simulation.base().caller.dead
    }

    /// The warnings since the instance was created or reset, or since they were
    /// [forgotten](Self::forget_warnings).
    pub fn warnings(&self) -> Warnings {
        self.log().warnings()
    }

    /// Counts warnings from zero again.
    pub fn forget_warnings(&mut self) {
        self.log().forget_warnings();
    }

    /// How many messages the FMU has passed to the logger with an environment that is not its own.
    pub fn strays(&self) -> u64 {
        self.log().strays()
    }

    fn log(&self) -> &Log {
        &self.simulation.base().caller.log
    }

    /// Announces the experiment: start and stop time in s, and the relative tolerance.
    ///
    /// # Errors
    /// When the FMU refuses.
    pub fn setup_experiment(&mut self, start: f64, stop: f64, tolerance: Option<f64>) -> Called {
        self.first_step = None;
        self.simulation.set_up(Experiment { start, stop, tolerance })
    }

    /// Sets structural parameters, by their value references, before anything else is set: see
    /// [`Package::resize`](crate::Package::resize).
    ///
    /// # Errors
    /// When the FMU refuses.
    pub fn resize(&mut self, sizes: &[(u32, u64)]) -> Called {
        match sizes {
            [] => Ok(()),
            sizes => self.simulation.resize(sizes),
        }
    }

    /// Enters and leaves initialisation mode.
    ///
    /// # Errors
    /// When the FMU cannot be initialised.
    pub fn initialise(&mut self) -> Called {
        self.simulation.initialise(&mut |_| Ok(()))
    }

    /// Reads real variables, by the references of their [handles](crate::Variable::handle).
    ///
    /// # Errors
    /// When the FMU refuses.
    ///
    /// # Panics
    /// When there are not as many places as references.
    #[inline(never)]
    pub fn reals(&mut self, references: &[u32], into: &mut [f64]) -> Called {
        self.simulation.reals(references, into)
    }

    /// Reads a variable of any kind.
    ///
    /// # Errors
    /// When the FMU refuses.
    pub fn value(&mut self, handle: Handle) -> Called<Value> {
        self.simulation.value(handle)
    }

    /// Lets an input vary linearly over the next step.
    ///
    /// # Errors
    /// When the FMU refuses, or cannot.
    pub fn set_slope(&mut self, reference: u32, slope: f64) -> Called {
        self.simulation.set_slope(reference, slope)
    }

    /// Writes one variable, by the reference of its [handle](crate::Variable::handle).
    ///
    /// # Errors
    /// When the FMU refuses, and when the value does not fit the variable's type.
    pub fn set(&mut self, reference: u32, value: &Value) -> Called {
        self.simulation.set(reference, value)
    }

    /// Lets `step` seconds pass from `time`.
    ///
    /// # Errors
    /// When the step is refused or fails, and when the FMU ends the simulation by itself: then `Call::ended` says
    /// when, and the instance holds its last values.
    #[inline(never)]
    pub fn step(&mut self, time: f64, step: f64) -> Called {
        let step = self.of_one_size(step);
        self.simulation.step(time, step)
    }

    /// The size of a step, s: for an FMU whose steps must have one size that of the first one, to the last bit, where only
    /// rounding makes another one.
    fn of_one_size(&mut self, step: f64) -> f64 {
        const ROUNDING: f64 = 1e-6;
        if !self.library.one_size {
            return step;
        }
        let first = *self.first_step.get_or_insert(step);
        if (step - first).abs() <= ROUNDING * first { first } else { step }
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
    pub fn steps(&mut self, times: &[f64], sizes: &[f64], references: &[u32], rows: &mut [f64]) -> (usize, Called) {
        assert!(
            times.len() == sizes.len() && rows.len() >= times.len() * references.len(),
            "each step needs a size, and a row of its own"
        );
        let same: Vec<f64>;
        let sizes = if self.library.one_size {
            same = sizes.iter().map(|&size| self.of_one_size(size)).collect();
            &same
        } else {
            sizes
        };
        self.simulation.steps(Batch { times, sizes, references, rows })
    }

    /// Takes the instance back to where it was after its creation.
    ///
    /// # Errors
    /// When the FMU cannot; then a new instance is needed.
    pub fn reset(&mut self) -> Called {
        self.log().clear();
        let reset = self.simulation.reset();
        // As after its creation.
        self.simulation.base_mut().caller.mode = self.library.mode;
        if reset.is_ok() {
            self.library.hear_again(&mut *self.simulation);
        }
        reset
    }

    /// Ends a simulation that was initialised.
    ///
    /// # Errors
    /// When the FMU refuses. What was computed before holds all the same.
    pub fn terminate(&mut self) -> Called {
        if self.is_dead() {
            return Ok(());
        }
        self.simulation.base_mut().terminate()
    }
}

impl Drop for Instance {
    fn drop(&mut self) {
        if !self.is_dead() {
            self.simulation.base_mut().free();
        }
    }
}
