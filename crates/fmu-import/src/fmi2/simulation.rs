//! A component of FMI 2.0.

use std::ffi::{CStr, CString, c_char, c_int, c_void};
use std::ptr;

use super::functions::Functions;
use crate::call::Call;
use crate::caller::Caller;
use crate::description::Interface;
use crate::simulation::{Birth, Component, Experiment, Simulation, c_string};
use crate::value::{Content, Handle, Value};

/// A component for Co-Simulation; the equations of one for Model Exchange stand on it.
#[derive(Debug)]
pub(crate) struct Model {
    pub(super) functions: Functions,
    pub(super) component: Component,
}

/// Steps that are taken one after another, and what is read after each.
pub(super) struct Batch<'a> {
    /// When the steps begin, s.
    pub(super) times: &'a [f64],
    /// How long they are, s.
    pub(super) sizes: &'a [f64],
    /// The real variables.
    pub(super) references: &'a [u32],
    /// A row of their values a step.
    pub(super) rows: &'a mut [f64],
}

impl Batch<'_> {
    /// The steps from one on.
    pub(super) fn from(&mut self, done: usize) -> Batch<'_> {
        Batch {
            times: &self.times[done..],
            sizes: &self.sizes[done..],
            references: self.references,
            rows: &mut self.rows[done * self.references.len()..],
        }
    }
}

// SAFETY: FMI 2.0 ties a component to no thread; it only forbids concurrent calls, which `&mut self`
// and the missing `Sync` rule out.
unsafe impl Send for Model {}

impl Model {
    /// Creates a component.
    pub(crate) fn new(
        functions: Functions,
        birth: &Birth<'_>,
        caller: &mut Caller,
        name: &str,
    ) -> Result<Self, Call> {
        let [name, guid, resources] = [name, birth.guid, birth.resources].map(c_string);
        let callbacks = caller.log.callbacks();
        // SAFETY: the strings live through the call, and the callbacks for ever.
        let component = caller.call(|| unsafe {
            (functions.instantiate)(
                name.as_ptr(),
                match birth.interface {
                    Interface::ModelExchange => 0,
                    Interface::CoSimulation => 1,
                },
                guid.as_ptr(),
                resources.as_ptr(),
                callbacks,
                0,
                0,
            )
        });
        if component.is_null() {
            return Err(birth.refused(caller, "fmi2Instantiate"));
        }
        let mut simulation = Self {
            functions,
            component,
        };
        simulation.log_troubles(caller, birth.categories);
        Ok(simulation)
    }

    /// Asks the FMU for its errors and warnings, where it has categories for them.
    fn log_troubles(&mut self, caller: &mut Caller, categories: &[String]) {
        let names: Vec<CString> = categories.iter().map(|name| c_string(name)).collect();
        if let (Some(function), false) = (self.functions.set_debug_logging, names.is_empty()) {
            let pointers: Vec<*const c_char> = names.iter().map(|name| name.as_ptr()).collect();
            // SAFETY: the array holds as many valid strings as stated. What it returns does not
            // matter: without it there are fewer messages.
            caller
                .call(|| unsafe { function(self.component, 1, pointers.len(), pointers.as_ptr()) });
        }
    }

    fn integer(&mut self, caller: &mut Caller, reference: u32) -> Result<c_int, Call> {
        let mut value: c_int = 0;
        let get = self.functions.get_integer;
        // SAFETY: both pointers are to one element.
        let status =
            caller.call(|| unsafe { get(self.component, &raw const reference, 1, &raw mut value) });
        caller.check("fmi2GetInteger", status)?;
        Ok(value)
    }

    fn boolean(&mut self, caller: &mut Caller, reference: u32) -> Result<bool, Call> {
        let mut value: c_int = 0;
        let get = self.functions.get_boolean;
        // SAFETY: both pointers are to one element.
        let status =
            caller.call(|| unsafe { get(self.component, &raw const reference, 1, &raw mut value) });
        caller.check("fmi2GetBoolean", status)?;
        Ok(value != 0)
    }

    fn string(&mut self, caller: &mut Caller, reference: u32) -> Result<String, Call> {
        let get = self.functions.get_string;
        let get = get.ok_or_else(|| Call::missing("fmi2GetString"))?;
        let mut value: *const c_char = ptr::null();
        // SAFETY: both pointers are to one element.
        let status =
            caller.call(|| unsafe { get(self.component, &raw const reference, 1, &raw mut value) });
        caller.check("fmi2GetString", status)?;
        if value.is_null() {
            return Ok(String::new());
        }
        // SAFETY: FMI 2.0 returns a zero-terminated string that is valid until the next call.
        let text = unsafe { CStr::from_ptr(value) };
        Ok(text.to_string_lossy().into_owned())
    }
}

impl Simulation for Model {
    fn set_up(&mut self, caller: &mut Caller, experiment: Experiment) -> Result<(), Call> {
        let Experiment {
            start,
            stop,
            tolerance,
        } = experiment;
        // SAFETY: the component is alive.
        let status = caller.call(|| unsafe {
            (self.functions.setup_experiment)(
                self.component,
                c_int::from(tolerance.is_some()),
                tolerance.unwrap_or(0.0),
                start,
                1,
                stop,
            )
        });
        caller.check("fmi2SetupExperiment", status)
    }

    fn initialise(&mut self, caller: &mut Caller, inputs: &[(u32, Value)]) -> Result<(), Call> {
        // SAFETY: the component is alive.
        let status =
            caller.call(|| unsafe { (self.functions.enter_initialization_mode)(self.component) });
        caller.check("fmi2EnterInitializationMode", status)?;
        for (reference, value) in inputs {
            self.set(caller, *reference, value)?;
        }
        // SAFETY: the component is alive.
        let status =
            caller.call(|| unsafe { (self.functions.exit_initialization_mode)(self.component) });
        caller.check("fmi2ExitInitializationMode", status)
    }

    #[inline(never)]
    fn reals(
        &mut self,
        caller: &mut Caller,
        references: &[u32],
        into: &mut [f64],
    ) -> Result<(), Call> {
        let count = references.len();
        assert_eq!(count, into.len(), "a place for each reference");
        let get = self.functions.get_real;
        // SAFETY: both arrays hold `count` elements.
        let status = caller.call(|| unsafe {
            get(
                self.component,
                references.as_ptr(),
                count,
                into.as_mut_ptr(),
            )
        });
        caller.check("fmi2GetReal", status)
    }

    fn value(&mut self, caller: &mut Caller, handle: Handle) -> Result<Value, Call> {
        let reference = handle.reference;
        Ok(match handle.content {
            Content::Real => {
                let mut value = [0.0];
                self.reals(caller, &[reference], &mut value)?;
                Value::Real(value[0])
            }
            Content::Integer => Value::Integer(self.integer(caller, reference)?.into()),
            Content::Boolean => Value::Boolean(self.boolean(caller, reference)?),
            Content::Text => Value::String(self.string(caller, reference)?),
        })
    }

    fn set(&mut self, caller: &mut Caller, reference: u32, value: &Value) -> Result<(), Call> {
        let functions = self.functions;
        let (component, reference) = (self.component, &raw const reference);
        match value {
            Value::Real(value) => {
                // SAFETY: both pointers are to one element.
                let status =
                    caller.call(|| unsafe { (functions.set_real)(component, reference, 1, value) });
                caller.check("fmi2SetReal", status)
            }
            Value::Integer(value) => {
                const FUNCTION: &str = "fmi2SetInteger";
                let value = c_int::try_from(*value).map_err(|_| {
                    let why = format!("{value} is no whole number of 32 bits");
                    Call::impossible(FUNCTION, why)
                })?;
                // SAFETY: both pointers are to one element.
                let status = caller.call(|| unsafe {
                    (functions.set_integer)(component, reference, 1, &raw const value)
                });
                caller.check(FUNCTION, status)
            }
            Value::Boolean(value) => {
                let value = c_int::from(*value);
                // SAFETY: both pointers are to one element.
                let status = caller.call(|| unsafe {
                    (functions.set_boolean)(component, reference, 1, &raw const value)
                });
                caller.check("fmi2SetBoolean", status)
            }
            Value::String(value) => {
                let set = functions.set_string;
                let set = set.ok_or_else(|| Call::missing("fmi2SetString"))?;
                let text = c_string(value);
                // SAFETY: both pointers are to one element, the text lives through the call.
                let status =
                    caller.call(|| unsafe { set(component, reference, 1, &text.as_ptr()) });
                caller.check("fmi2SetString", status)
            }
        }
    }

    fn set_slope(&mut self, caller: &mut Caller, reference: u32, slope: f64) -> Result<(), Call> {
        const FUNCTION: &str = "fmi2SetRealInputDerivatives";
        let set = self.functions.set_slopes;
        let set = set.ok_or_else(|| Call::missing(FUNCTION))?;
        // SAFETY: all three pointers are to one element.
        let status = caller.call(|| unsafe {
            set(
                self.component,
                &raw const reference,
                1,
                &1,
                &raw const slope,
            )
        });
        caller.check(FUNCTION, status)
    }

    #[inline(never)]
    fn step(&mut self, caller: &mut Caller, time: f64, step: f64) -> Result<(), Call> {
        let do_step = self.functions.do_step;
        // SAFETY: the component is alive.
        let status = caller.call(|| unsafe { do_step(self.component, time, step, 1) });
        if status == 0 {
            return Ok(());
        }
        self.slow_step(caller, status, time, step)
    }

    #[inline(never)]
    fn steps(
        &mut self,
        caller: &mut Caller,
        times: &[f64],
        sizes: &[f64],
        references: &[u32],
        rows: &mut [f64],
    ) -> (usize, Result<(), Call>) {
        let batch = Batch {
            times,
            sizes,
            references,
            rows,
        };
        self.take(caller, batch)
    }

    fn reset(&mut self, caller: &mut Caller) -> Result<(), Call> {
        let reset = self.functions.reset;
        let reset = reset.ok_or_else(|| Call::missing("fmi2Reset"))?;
        // SAFETY: the component is alive.
        let status = caller.call(|| unsafe { reset(self.component) });
        caller.check("fmi2Reset", status)
    }

    fn terminate(&mut self, caller: &mut Caller) -> Result<(), Call> {
        let Some(terminate) = self.functions.terminate else {
            return Ok(());
        };
        // SAFETY: the component is alive.
        let status = caller.call(|| unsafe { terminate(self.component) });
        caller.check("fmi2Terminate", status)
    }

    fn save(&mut self, caller: &mut Caller) -> Option<*mut c_void> {
        let (get, _, _) = self.functions.states?;
        let mut state = ptr::null_mut();
        // SAFETY: the component is alive, and the state is a valid place to write to.
        let status = caller.call(|| unsafe { get(self.component, &raw mut state) });
        caller.check("fmi2GetFMUstate", status).ok()?;
        Some(state)
    }

    fn restore(&mut self, caller: &mut Caller, state: *mut c_void) -> Result<(), Call> {
        let states = self.functions.states;
        let (_, set, _) = states.ok_or_else(|| Call::missing("fmi2SetFMUstate"))?;
        // SAFETY: the component is alive, and the state is one of its own.
        let status = caller.call(|| unsafe { set(self.component, state) });
        caller.check("fmi2SetFMUstate", status)
    }

    fn forget(&mut self, caller: &mut Caller, mut state: *mut c_void) -> Result<(), Call> {
        let states = self.functions.states;
        let (_, _, free) = states.ok_or_else(|| Call::missing("fmi2FreeFMUstate"))?;
        // SAFETY: the component is alive, and the state is one of its own, used no more.
        let status = caller.call(|| unsafe { free(self.component, &raw mut state) });
        caller.check("fmi2FreeFMUstate", status)
    }

    fn free(&mut self, caller: &mut Caller) {
        // SAFETY: the component is alive and never used again.
        caller.call(|| unsafe { (self.functions.free_instance)(self.component) });
    }
}
