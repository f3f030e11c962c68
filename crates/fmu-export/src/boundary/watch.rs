//! A host that looks into communication steps, the step that is at work, and its parts. `intermediate` takes the steps.

use super::{
    lookup::{all_elements, variable_of},
    refusal::{Outcome, Refusal},
    run::Run,
    types::{ComponentEnvironment, IntermediateUpdateCallback, ValueReference},
};
use crate::model::{Kind, Model, Role, Variable};

/// The most updates in a communication step: where a model takes more inner steps, an update comes after several of them.
const MOST_UPDATES: f64 = 1000.0;

/// An inner step that leaves less than a thousandth of the rest takes the whole rest.
const NEARLY_ALL: f64 = 0.999;

/// How a host looks into communication steps.
pub struct Watch<M> {
    /// The host's function.
    pub callback: IntermediateUpdateCallback,
    /// Functions and data of the importer that each call gets.
    pub environment: ComponentEnvironment,
    /// Whether steps may return early.
    pub early: bool,
    /// The variables that the host will access, in ascending order.
    pub variables: Vec<ValueReference>,
    /// The length of a model's first inner step.
    pub inner_step: fn(&M, f64) -> f64,
    /// The step that is at work.
    pub underway: Option<Underway<M>>,
}

/// A communication step that is at work.
pub struct Underway<M> {
    /// The instance at its start, for a step that fails later.
    pub before: Box<Run<M>>,
    /// Where it ends, s.
    pub until: f64,
    /// The rest of it, s.
    pub left: f64,
    /// The shortest part of it, s.
    pub least: f64,
}

/// A part of a communication step, from one update to the next.
pub struct StepPart {
    /// How long it is, s.
    pub length: f64,
    /// When it ends, s.
    pub to: f64,
    /// What is left of the step behind it, s.
    left: f64,
}

impl<M: Model> Underway<M> {
    /// A step of an instance that is as it is at its start.
    pub fn new(before: &Run<M>, from: f64, step: f64) -> Self {
        Self { before: Box::new(before.clone()), until: from + step, left: step, least: step / MOST_UPDATES }
    }
}

impl<M: Model> Watch<M> {
    /// Takes what the host has said when it made the instance.
    pub fn new(
        callback: IntermediateUpdateCallback,
        environment: ComponentEnvironment,
        early: bool,
        variables: &[ValueReference],
        inner_step: fn(&M, f64) -> f64,
    ) -> Outcome<Self> {
        let mut variables = all_elements::<M>(variables).into_owned();
        variables.sort_unstable();
        for reference in &variables {
            check_intermediate_access(variable_of::<M>(*reference)?)?;
        }
        Ok(Self { callback, environment, early, variables, inner_step, underway: None })
    }

    /// The next part of the step that is at work, if one is: an inner step of the model from this time on.
    pub fn next_part(&self, model: &M, time: f64) -> Option<StepPart> {
        let underway = self.underway.as_ref()?;
        let inner = (self.inner_step)(model, underway.left).max(underway.least);
        // No tiny rest, and none that does not move the time.
        let is_part = inner < NEARLY_ALL * underway.left && time + inner > time;
        let length = if is_part { inner } else { underway.left };
        let left = underway.left - length;
        Some(StepPart { length, left, to: if left > 0.0 { time + length } else { underway.until } })
    }

    /// Takes note of a part that the model has advanced by, and returns the call of the host that is due.
    pub fn behind(&mut self, part: &StepPart) -> Update {
        if let Some(underway) = &mut self.underway {
            underway.left = part.left;
        }
        let more = part.left > 0.0;
        Update {
            callback: self.callback,
            environment: self.environment,
            time: part.to,
            more,
            early: self.early && more,
        }
    }
}

/// Whether hosts may access a variable within steps: continuous inputs and outputs.
pub fn is_intermediate<M: Model>(variable: &Variable<M>) -> bool {
    M::INNER_STEP.is_some()
        && matches!(variable.kind, Kind::Real(_))
        && matches!(variable.role, Role::Input | Role::Output)
}

/// Refuses a variable that hosts may not access within steps.
pub fn check_intermediate_access<M: Model>(variable: &Variable<M>) -> Outcome {
    let why = "it has no intermediateUpdate attribute";
    if is_intermediate(variable) { Ok(()) } else { Err(Refusal::NotIntermediate { name: variable.name, why }) }
}

/// A call of the host that is due.
pub struct Update {
    callback: IntermediateUpdateCallback,
    environment: ComponentEnvironment,
    time: f64,
    /// Whether something of the step is left, so that inputs matter.
    more: bool,
    /// Whether the step can end here.
    early: bool,
}

/// Whether and when the host wants a step to end.
pub type StepEnd = Option<f64>;

impl Update {
    /// Calls the host. An answer counts only if it was allowed.
    pub fn ask(self) -> StepEnd {
        let (mut requested, mut at) = (0, self.time);
        let (more, early) = (self.more, self.early);
        // SAFETY: the host vouches for its callback when it instantiates; the places live until it returns.
        unsafe {
            (self.callback)(self.environment, self.time, more, true, true, early, &raw mut requested, &raw mut at);
        }
        (early && requested != 0).then_some(at)
    }
}
