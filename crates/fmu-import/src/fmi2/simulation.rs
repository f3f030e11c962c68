//! A component of FMI 2.0.

use std::{
    ffi::{CStr, c_int},
    ptr,
    sync::Arc,
};

use super::functions::{Access, Functions};
use crate::{
    call::{Call, Called},
    caller::Caller,
    component::{CommonFunctions, ComponentBase, c_string},
    description::Interface,
    simulation::{Batch, Birth, Experiment, Simulation, Within},
    value::{Content, Handle, Value},
};

/// A component for Co-Simulation; the equations of one for Model Exchange stand on it.
#[derive(Debug)]
pub struct Model {
    pub base: ComponentBase,
    pub functions: Arc<Functions>,
}

impl Model {
    /// Creates a component.
    pub fn new(
        functions: Arc<Functions>,
        common: CommonFunctions,
        birth: &Birth,
        mut caller: Caller,
        name: &str,
    ) -> Called<Self> {
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
        let base = birth.base(component, common, caller, functions.instantiate.name)?;
        Ok(Self { base, functions })
    }

    /// Reads one variable.
    fn get<T: Copy>(&mut self, reference: u32, access: Access<T>, blank: T) -> Called<T> {
        let mut value = blank;
        let (reference, place) = (&raw const reference, &raw mut value);
        // SAFETY: both pointers are to one element.
        self.base.call(access.get, |get, of| unsafe { get(of, reference, 1, place) })?;
        Ok(value)
    }

    /// Writes one variable.
    fn put<T>(&mut self, reference: u32, access: Access<T>, value: T) -> Called {
        let (reference, value) = (&raw const reference, &raw const value);
        // SAFETY: both pointers are to one element.
        self.base.call(access.set, |set, of| unsafe { set(of, reference, 1, value) })
    }
}

impl Simulation for Model {
    fn hear(&mut self, categories: &[String]) {
        let function = self.functions.set_debug_logging;
        // SAFETY: the array holds as many valid strings as stated.
        self.base.hear(categories, function, |log, of, count, texts| unsafe { log(of, 1, count, texts) });
    }

    fn base(&self) -> &ComponentBase {
        &self.base
    }

    fn base_mut(&mut self) -> &mut ComponentBase {
        &mut self.base
    }

    fn set_up(&mut self, experiment: Experiment) -> Called {
        let Experiment { start, stop, tolerance } = experiment;
        let (known, tolerance) = (tolerance.is_some().into(), tolerance.unwrap_or(0.0));
        let function = self.functions.setup_experiment;
        // SAFETY: the component is alive.
        self.base.call(function, |set_up, of| unsafe { set_up(of, known, tolerance, start, 1, stop) })
    }

    fn initialise(&mut self, within: Within) -> Called {
        self.base.plain(self.functions.enter_initialization_mode)?;
        within(self)?;
        self.base.exit_initialization_mode()
    }

    #[inline(never)]
    fn reals(&mut self, references: &[u32], into: &mut [f64]) -> Called {
        let count = references.len();
        assert_eq!(count, into.len(), "a place for each reference");
        let (references, into) = (references.as_ptr(), into.as_mut_ptr());
        let get = self.functions.real.get;
        // SAFETY: both arrays hold `count` elements.
        self.base.call(get, |get, of| unsafe { get(of, references, count, into) })
    }

    fn value(&mut self, handle: Handle) -> Result<Value, Call> {
        let (of, functions) = (handle.reference, Arc::clone(&self.functions));
        Ok(match handle.content {
            Content::Real => Value::Real(self.get(of, functions.real, 0.0)?),
            Content::Integer => Value::Integer(self.get(of, functions.integer, 0)?.into()),
            Content::Boolean => Value::Boolean(self.get(of, functions.boolean, 0)? != 0),
            Content::Text => {
                let text = self.get(of, functions.string, ptr::null())?;
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

    fn set(&mut self, reference: u32, value: &Value) -> Result<(), Call> {
        let functions = Arc::clone(&self.functions);
        match value {
            Value::Real(value) => self.put(reference, functions.real, *value),
            Value::Integer(value) => {
                let value = c_int::try_from(*value).map_err(|_| {
                    Call::impossible(functions.integer.set.name, format!("{value} is no whole number of 32 bits"))
                })?;
                self.put(reference, functions.integer, value)
            }
            Value::Boolean(value) => self.put(reference, functions.boolean, c_int::from(*value)),
            Value::String(value) => {
                let text = c_string(value);
                self.put(reference, functions.string, text.as_ptr())
            }
        }
    }

    fn set_slope(&mut self, reference: u32, slope: f64) -> Called {
        let (reference, slope) = (&raw const reference, &raw const slope);
        let function = self.functions.set_slopes;
        // SAFETY: all three pointers are to one element.
        self.base.call(function, |set, of| unsafe { set(of, reference, 1, &1, slope) })
    }

    #[inline(never)]
    fn step(&mut self, time: f64, step: f64) -> Called {
        let (do_step, component) = (self.functions.do_step.get()?, self.base.component);
        // SAFETY: the component is alive.
        let status = self.base.caller.call(|| unsafe { do_step(component, time, step, 1) });
        if status == 0 {
            return Ok(());
        }
        self.slow_step(status, time, step)
    }

    fn steps(&mut self, batch: Batch) -> (usize, Called) {
        self.take(batch)
    }
}
