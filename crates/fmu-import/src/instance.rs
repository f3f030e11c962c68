//! One simulation of an FMU.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use crate::call::{Call, Warnings};
use crate::caller::Caller;
use crate::library::Library;
use crate::simulation::{Experiment, Simulation};
use crate::value::{Content, Handle, Value};

/// One instance. It may move between threads, but only one at a time may use it.
#[derive(Debug)]
pub struct Instance {
    /// Unlike that of every other instance of this process: a state says with it whose it is.
    pub(crate) number: u64,
    library: Arc<Library>,
    pub(crate) caller: Caller,
    pub(crate) simulation: Box<dyn Simulation>,
}

impl Instance {
    /// Creates an instance.
    ///
    /// # Errors
    /// When the FMU refuses.
    pub fn new(library: &Arc<Library>, name: &str) -> Result<Self, Call> {
        let mut caller = Caller::new(library.mode);
        let simulation = library.instantiate(&mut caller, name)?;
        static CREATED: AtomicU64 = AtomicU64::new(0);
        Ok(Self {
            number: CREATED.fetch_add(1, Ordering::Relaxed),
            library: Arc::clone(library),
            caller,
            simulation,
        })
    }

    /// Whether the FMU is unusable after `fmi2Fatal` or `fmi3Fatal`: nothing may be called any more.
    pub fn is_dead(&self) -> bool {
        self.caller.dead
    }

    /// The warnings since the instance was created or reset, or since they were
    /// [forgotten](Self::forget_warnings).
    pub fn warnings(&self) -> Warnings {
        self.caller.warnings()
    }

    /// Counts warnings from zero again.
    pub fn forget_warnings(&mut self) {
        self.caller.forget_warnings();
    }

    /// How many messages the FMU has passed to the logger with an environment that is not its own.
    pub fn strays(&self) -> u64 {
        self.caller.log.strays()
    }

    /// Announces the experiment: start and stop time in s, and the relative tolerance.
    ///
    /// # Errors
    /// When the FMU refuses.
    pub fn setup_experiment(
        &mut self,
        start: f64,
        stop: f64,
        tolerance: Option<f64>,
    ) -> Result<(), Call> {
        let experiment = Experiment {
            start,
            stop,
            tolerance,
        };
        self.simulation.set_up(&mut self.caller, experiment)
    }

    /// Enters and leaves initialisation mode.
    ///
    /// # Errors
    /// When the FMU cannot be initialised.
    pub fn initialise(&mut self) -> Result<(), Call> {
        self.simulation.initialise(&mut self.caller, &[])
    }

    /// Reads real variables, by the references of their [handles](crate::Variable::handle).
    ///
    /// # Errors
    /// When the FMU refuses.
    ///
    /// # Panics
    /// When there are not as many places as references.
    #[inline(never)]
    pub fn reals(&mut self, references: &[u32], into: &mut [f64]) -> Result<(), Call> {
        self.simulation.reals(&mut self.caller, references, into)
    }

    /// Reads an integer or an item of an enumeration.
    ///
    /// # Errors
    /// When the FMU refuses.
    pub fn integer(&mut self, reference: u32) -> Result<i64, Call> {
        match self.of(reference, Content::Integer)? {
            Value::Integer(value) => Ok(value),
            other => Err(unlike(&other)),
        }
    }

    /// Reads a Boolean.
    ///
    /// # Errors
    /// When the FMU refuses.
    pub fn boolean(&mut self, reference: u32) -> Result<bool, Call> {
        match self.of(reference, Content::Boolean)? {
            Value::Boolean(value) => Ok(value),
            other => Err(unlike(&other)),
        }
    }

    /// Reads a text.
    ///
    /// # Errors
    /// When the FMU refuses.
    pub fn string(&mut self, reference: u32) -> Result<String, Call> {
        match self.of(reference, Content::Text)? {
            Value::String(value) => Ok(value),
            other => Err(unlike(&other)),
        }
    }

    fn of(&mut self, reference: u32, content: Content) -> Result<Value, Call> {
        self.value(Handle { reference, content })
    }

    /// Reads a variable of any kind.
    ///
    /// # Errors
    /// When the FMU refuses.
    pub fn value(&mut self, handle: Handle) -> Result<Value, Call> {
        self.simulation.value(&mut self.caller, handle)
    }

    /// Lets an input vary linearly over the next step.
    ///
    /// # Errors
    /// When the FMU refuses, or cannot.
    pub fn set_slope(&mut self, reference: u32, slope: f64) -> Result<(), Call> {
        let simulation = &mut self.simulation;
        simulation.set_slope(&mut self.caller, reference, slope)
    }

    /// Writes one variable, by the reference of its [handle](crate::Variable::handle).
    ///
    /// # Errors
    /// When the FMU refuses, and when the value does not fit the variable's type.
    pub fn set(&mut self, reference: u32, value: &Value) -> Result<(), Call> {
        self.simulation.set(&mut self.caller, reference, value)
    }

    /// Takes the instance back to where it was after its creation.
    ///
    /// # Errors
    /// When the FMU cannot; then a new instance is needed.
    pub fn reset(&mut self) -> Result<(), Call> {
        self.caller.forget_messages();
        let reset = self.simulation.reset(&mut self.caller);
        // As after its creation.
        self.caller.mode = self.library.mode;
        reset
    }

    /// Ends a simulation that was initialised.
    ///
    /// # Errors
    /// When the FMU refuses. What was computed before holds all the same.
    pub fn terminate(&mut self) -> Result<(), Call> {
        if self.caller.dead {
            return Ok(());
        }
        self.simulation.terminate(&mut self.caller)
    }
}

/// A value of another type than the one that was asked for.
fn unlike(value: &Value) -> Call {
    let text = format!("the variable's values are of another type: {value:?}");
    Call::impossible("fmi3Get", text)
}

impl Drop for Instance {
    fn drop(&mut self) {
        if !self.caller.dead {
            self.simulation.free(&mut self.caller);
        }
    }
}
