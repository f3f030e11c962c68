//! A component of FMI 2.0.

use std::ffi::{CStr, c_int};
use std::ptr;

use super::functions::{Access, Functions};
use crate::call::Call;
use crate::caller::Caller;
use crate::component::{Base, Common, c_string, c_strings};
use crate::description::Interface;
use crate::simulation::{Batch, Birth, Experiment, Simulation};
use crate::value::{Content, Handle, Value};

/// A component for Co-Simulation; the equations of one for Model Exchange stand on it.
#[derive(Debug)]
pub(crate) struct Model {
    pub(super) base: Base,
    pub(super) functions: Functions,
}

impl Model {
    /// Creates a component.
    pub(crate) fn new(
        functions: Functions,
        common: Common,
        birth: &Birth,
        caller: &mut Caller,
        name: &str,
    ) -> Result<Self, Call> {
        let [name, guid, resources] = [name, &birth.guid, &birth.resources].map(c_string);
        let callbacks = caller.log.callbacks();
        let instantiate = functions.instantiate.get()?;
        // SAFETY: the strings live through the call, and the callbacks for ever.
        let component = caller.call(|| unsafe {
            instantiate(
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
        if component.0.is_null() {
            return Err(birth.refused(caller, functions.instantiate.name));
        }
        let base = Base { component, common };
        // The FMU tells its errors and warnings, where it has categories for them.
        if let Ok(log) = functions.set_debug_logging.get()
            && !birth.categories.is_empty()
        {
            let (_texts, categories) = c_strings(&birth.categories);
            // SAFETY: the array holds as many valid strings as stated. What it returns does not
            // matter: without it there are fewer messages.
            caller.call(|| unsafe { log(component, 1, categories.len(), categories.as_ptr()) });
        }
        Ok(Self { base, functions })
    }

    /// Reads one variable.
    fn get<T: Copy>(
        &self,
        caller: &mut Caller,
        reference: u32,
        access: Access<T>,
        blank: T,
    ) -> Result<T, Call> {
        let (get, component) = (access.get.get()?, self.base.component);
        let mut value = blank;
        // SAFETY: both pointers are to one element.
        let status =
            caller.call(|| unsafe { get(component, &raw const reference, 1, &raw mut value) });
        caller.check(access.get.name, status)?;
        Ok(value)
    }

    /// Writes one variable.
    fn put<T>(
        &self,
        caller: &mut Caller,
        reference: u32,
        access: Access<T>,
        value: T,
    ) -> Result<(), Call> {
        let (set, component) = (access.set.get()?, self.base.component);
        // SAFETY: both pointers are to one element.
        let status =
            caller.call(|| unsafe { set(component, &raw const reference, 1, &raw const value) });
        caller.check(access.set.name, status)
    }
}

impl Simulation for Model {
    fn base(&self) -> &Base {
        &self.base
    }

    fn set_up(&mut self, caller: &mut Caller, experiment: Experiment) -> Result<(), Call> {
        let Experiment {
            start,
            stop,
            tolerance,
        } = experiment;
        let function = self.functions.setup_experiment;
        let (set_up, component) = (function.get()?, self.base.component);
        let (known, tolerance) = (tolerance.is_some().into(), tolerance.unwrap_or(0.0));
        // SAFETY: the component is alive.
        let status = caller.call(|| unsafe { set_up(component, known, tolerance, start, 1, stop) });
        caller.check(function.name, status)
    }

    fn initialise(&mut self, caller: &mut Caller, inputs: &[(u32, Value)]) -> Result<(), Call> {
        self.base
            .component
            .plain(caller, self.functions.enter_initialization_mode)?;
        for (reference, value) in inputs {
            self.set(caller, *reference, value)?;
        }
        self.base.exit_initialization_mode(caller)
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
        let function = self.functions.real.get;
        let (get, component) = (function.get()?, self.base.component);
        let (references, into) = (references.as_ptr(), into.as_mut_ptr());
        // SAFETY: both arrays hold `count` elements.
        let status = caller.call(|| unsafe { get(component, references, count, into) });
        caller.check(function.name, status)
    }

    fn value(&mut self, caller: &mut Caller, handle: Handle) -> Result<Value, Call> {
        let (of, functions) = (handle.reference, &self.functions);
        Ok(match handle.content {
            Content::Real => Value::Real(self.get(caller, of, functions.real, 0.0)?),
            Content::Integer => Value::Integer(self.get(caller, of, functions.integer, 0)?.into()),
            Content::Boolean => Value::Boolean(self.get(caller, of, functions.boolean, 0)? != 0),
            Content::Text => {
                let text = self.get(caller, of, functions.string, ptr::null())?;
                Value::String(if text.is_null() {
                    String::new()
                } else {
                    // SAFETY: FMI 2.0 returns a zero-terminated string that is valid until the next call.
                    let text = unsafe { CStr::from_ptr(text) };
                    text.to_string_lossy().into_owned()
                })
            }
        })
    }

    fn set(&mut self, caller: &mut Caller, reference: u32, value: &Value) -> Result<(), Call> {
        let functions = &self.functions;
        match value {
            Value::Real(value) => self.put(caller, reference, functions.real, *value),
            Value::Integer(value) => {
                let value = c_int::try_from(*value).map_err(|_| {
                    let why = format!("{value} is no whole number of 32 bits");
                    Call::impossible(functions.integer.set.name, why)
                })?;
                self.put(caller, reference, functions.integer, value)
            }
            Value::Boolean(value) => {
                self.put(caller, reference, functions.boolean, c_int::from(*value))
            }
            Value::String(value) => {
                let text = c_string(value);
                self.put(caller, reference, functions.string, text.as_ptr())
            }
        }
    }

    fn set_slope(&mut self, caller: &mut Caller, reference: u32, slope: f64) -> Result<(), Call> {
        let function = self.functions.set_slopes;
        let (set, component) = (function.get()?, self.base.component);
        let (reference, slope) = (&raw const reference, &raw const slope);
        // SAFETY: all three pointers are to one element.
        let status = caller.call(|| unsafe { set(component, reference, 1, &1, slope) });
        caller.check(function.name, status)
    }

    #[inline(never)]
    fn step(&mut self, caller: &mut Caller, time: f64, step: f64) -> Result<(), Call> {
        let (do_step, component) = (self.functions.do_step.get()?, self.base.component);
        // SAFETY: the component is alive.
        let status = caller.call(|| unsafe { do_step(component, time, step, 1) });
        if status == 0 {
            return Ok(());
        }
        self.slow_step(caller, status, time, step)
    }

    fn steps(&mut self, caller: &mut Caller, batch: Batch<'_>) -> (usize, Result<(), Call>) {
        self.take(caller, batch)
    }
}
