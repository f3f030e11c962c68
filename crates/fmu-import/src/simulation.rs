//! One simulation of an FMU as every version of FMI can run it.

use std::ffi::{CString, c_void};
use std::fmt::Debug;

use crate::call::Call;
use crate::caller::Caller;
use crate::description::Interface;
use crate::value::{Handle, Value};

pub(crate) type Component = *mut c_void;

/// The experiment that is announced to an FMU.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Experiment {
    /// Start time, s.
    pub(crate) start: f64,
    /// Stop time, s.
    pub(crate) stop: f64,
    /// Relative tolerance.
    pub(crate) tolerance: Option<f64>,
}

/// What an FMU is told when a component of it is created.
pub(crate) struct Birth<'a> {
    /// The GUID, or the instantiation token.
    pub(crate) guid: &'a str,
    /// The resources: a URI in FMI 2.0, a path in FMI 3.0.
    pub(crate) resources: &'a str,
    /// The log categories of errors and warnings.
    pub(crate) categories: &'a [String],
    /// The interface of the component.
    pub(crate) interface: Interface,
    /// The likely cause where the FMU refuses and does not say why.
    pub(crate) refusal: &'a dyn Fn() -> String,
}

impl Birth<'_> {
    /// Why there is no component.
    pub(crate) fn refused(&self, caller: &Caller, function: &'static str) -> Call {
        let message = caller.log.last();
        Call::impossible(function, message.unwrap_or_else(|| (self.refusal)()))
    }
}

/// A C string. A zero byte cannot be told to C: the text ends before it.
pub(crate) fn c_string(text: &str) -> CString {
    let end = text.find('\0').unwrap_or(text.len());
    CString::new(&text[..end]).expect("the text ends before its first zero byte")
}

/// A component of a binary, called by the functions of its version. [`Instance`](crate::Instance) documents the
/// methods; the caller keeps what the calls of every version share.
///
/// A reference is that of a [`Handle`]: in FMI 2.0 the value reference, in FMI 3.0 the number of an element.
pub(crate) trait Simulation: Debug + Send {
    /// Announces the experiment.
    fn set_up(&mut self, caller: &mut Caller, experiment: Experiment) -> Result<(), Call>;
    /// Enters initialisation mode, sets these inputs, and leaves it.
    fn initialise(&mut self, caller: &mut Caller, inputs: &[(u32, Value)]) -> Result<(), Call>;
    /// Reads real variables, as many as there are references and places.
    fn reals(
        &mut self,
        caller: &mut Caller,
        references: &[u32],
        into: &mut [f64],
    ) -> Result<(), Call>;
    /// Reads a variable of any kind.
    fn value(&mut self, caller: &mut Caller, handle: Handle) -> Result<Value, Call>;
    /// Writes one variable.
    fn set(&mut self, caller: &mut Caller, reference: u32, value: &Value) -> Result<(), Call>;
    /// Lets an input vary linearly over the next step.
    fn set_slope(&mut self, caller: &mut Caller, reference: u32, slope: f64) -> Result<(), Call>;
    /// Lets time pass, s.
    fn step(&mut self, caller: &mut Caller, time: f64, step: f64) -> Result<(), Call>;
    /// Lets several steps pass and reads after each; how many were taken and read, and why not all. There are as many
    /// sizes as times, and a row of `references.len()` places for each.
    fn steps(
        &mut self,
        caller: &mut Caller,
        times: &[f64],
        sizes: &[f64],
        references: &[u32],
        rows: &mut [f64],
    ) -> (usize, Result<(), Call>) {
        let width = references.len();
        for (taken, (&time, &size)) in times.iter().zip(sizes).enumerate() {
            let row = &mut rows[taken * width..(taken + 1) * width];
            let mut outcome = self.step(caller, time, size);
            if outcome.is_ok() && width > 0 {
                outcome = self.reals(caller, references, row);
            }
            if outcome.is_err() {
                return (taken, outcome);
            }
        }
        (times.len(), Ok(()))
    }
    /// Goes back to the state after the creation.
    fn reset(&mut self, caller: &mut Caller) -> Result<(), Call>;
    /// Ends the simulation.
    fn terminate(&mut self, caller: &mut Caller) -> Result<(), Call>;
    /// Keeps the present state; `None` where the FMU cannot.
    fn save(&mut self, caller: &mut Caller) -> Option<*mut c_void>;
    /// Goes back to a state, which must be one of this component's own.
    fn restore(&mut self, caller: &mut Caller, state: *mut c_void) -> Result<(), Call>;
    /// Frees such a state, which is used no more.
    fn forget(&mut self, caller: &mut Caller, state: *mut c_void) -> Result<(), Call>;
    /// Frees the component, which is used no more.
    fn free(&mut self, caller: &mut Caller);
}
