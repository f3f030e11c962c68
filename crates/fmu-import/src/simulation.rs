//! One simulation of an FMU as every version of FMI can run it.

use std::{fmt::Debug, path::PathBuf};

use crate::{
    call::{Call, Called},
    caller::Caller,
    component::{CommonFunctions, ComponentBase},
    description::Interface,
    symbols::Component,
    value::{Handle, Value},
};

/// The experiment that is announced to an FMU.
#[derive(Clone, Copy, Debug, Default)]
pub struct Experiment {
    /// Start time, s.
    pub start: f64,
    /// Stop time, s.
    pub stop: f64,
    /// Relative tolerance.
    pub tolerance: Option<f64>,
}

/// All that an FMU is told when a component of it is created.
#[derive(Debug)]
pub struct Birth {
    /// The GUID, or the instantiation token.
    pub guid: String,
    /// The resources: a URI in FMI 2.0, a path in FMI 3.0.
    pub resources: String,
    /// The log categories of errors and warnings, and that of the model's validity.
    pub categories: Vec<String>,
    /// The interface of the component.
    pub interface: Interface,
    /// The file of the binary.
    pub binary: PathBuf,
}

impl Birth {
    /// What `function` has created. Where that is nothing, the FMU says why, or else the likely cause.
    pub fn base(
        &self,
        component: Component,
        common: CommonFunctions,
        caller: Caller,
        function: &'static str,
    ) -> Called<ComponentBase> {
        if component.0.is_null() {
            let why = caller.log.last().unwrap_or_else(|| self.likely_cause());
            return Err(Call::impossible(function, why));
        }
        Ok(ComponentBase { component, common, caller })
    }

    fn likely_cause(&self) -> String {
        let guid = &self.guid;
        // Exporters write the GUID into the binary, with braces or without.
        let bare = guid.trim_matches(['{', '}']).as_bytes();
        let holds = |file: &[u8]| bare.is_empty() || file.windows(bare.len()).any(|part| part == bare);
        let cause = match std::fs::read(&self.binary) {
            Ok(binary) if !holds(&binary) => "does not occur in the binary, so the two are probably not of one export",
            _ => "may not be that of the binary, or resources may be missing",
        };
        format!("the FMU refuses an instance without a message; the GUID of the description, {guid}, {cause}")
    }
}

/// Steps that are taken one after another, and what is read after each.
pub struct Batch<'a> {
    /// When the steps begin, s.
    pub times: &'a [f64],
    /// How long they are, s; as many as times.
    pub sizes: &'a [f64],
    /// The real variables.
    pub references: &'a [u32],
    /// A row of their values a step.
    pub rows: &'a mut [f64],
}

impl Batch<'_> {
    /// The row of a step.
    pub fn row(&mut self, step: usize) -> &mut [f64] {
        let width = self.references.len();
        &mut self.rows[step * width..(step + 1) * width]
    }
}

/// What is done with a component in initialisation mode.
pub type Within<'a> = &'a mut dyn FnMut(&mut dyn Simulation) -> Called;

/// A component of a binary, called by the functions of its version. [`Instance`](crate::Instance) documents the
/// methods.
///
/// A reference is that of a [`Handle`]: in FMI 2.0 the value reference, in FMI 3.0 the number of an element.
pub trait Simulation: Debug + Send {
    /// Lets the FMU log its messages in these categories.
    fn hear(&mut self, categories: &[String]);
    /// Announces the experiment.
    fn set_up(&mut self, experiment: Experiment) -> Called;
    /// Sets structural parameters, by their value references; FMI 2.0 has none.
    fn resize(&mut self, _: &[(u32, u64)]) -> Called {
        Ok(())
    }
    /// Enters initialisation mode, does what is to be done within it, and leaves it.
    fn initialise(&mut self, within: Within) -> Called;
    /// Reads real variables, as many as there are references and places.
    fn reals(&mut self, references: &[u32], into: &mut [f64]) -> Called;
    /// Reads a variable of any kind.
    fn value(&mut self, handle: Handle) -> Called<Value>;
    /// Writes one variable.
    fn set(&mut self, reference: u32, value: &Value) -> Called;
    /// Lets an input vary linearly over the next step.
    fn set_slope(&mut self, reference: u32, slope: f64) -> Called;
    /// Lets time pass, s.
    fn step(&mut self, time: f64, step: f64) -> Called;
    /// Lets time pass, s, up to the next return of the FMU: the time that it reached, and whether there is an event.
    fn part(&mut self, time: f64, step: f64) -> Called<(f64, bool)> {
        self.step(time, step).map(|()| (time + step, false))
    }
    /// Lets several steps pass and reads after each; how many were taken and read, and why not all.
    fn steps(&mut self, mut batch: Batch) -> (usize, Called) {
        for (taken, (&time, &size)) in batch.times.iter().zip(batch.sizes).enumerate() {
            let mut outcome = self.step(time, size);
            if outcome.is_ok() && !batch.references.is_empty() {
                outcome = self.reals(batch.references, batch.row(taken));
            }
            if outcome.is_err() {
                return (taken, outcome);
            }
        }
        (batch.times.len(), Ok(()))
    }
    /// The component with what every version can do.
    fn base(&self) -> &ComponentBase;
    /// The same, for calls.
    fn base_mut(&mut self) -> &mut ComponentBase;
    /// Goes back to the state after the creation.
    fn reset(&mut self) -> Called {
        self.base_mut().reset()
    }
}
