//! A host that looks into communication steps, and the step that is at work. `intermediate` has what they do.

use super::{
    run::Run,
    types::{ComponentEnvironment, IntermediateUpdateCallback, ValueReference},
};

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
