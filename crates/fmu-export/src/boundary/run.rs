//! A model with its phase and times.

use std::path::Path;

use super::{phase::Phase, types::Status};
use crate::model::Experiment;

/// The part of an instance that a saved state holds.
#[derive(Clone, Default)]
pub struct Run<M> {
    /// The phase of the simulation.
    pub phase: Phase,
    /// The model. In initialization mode: a copy of `seed`, initialised.
    pub model: M,
    /// In initialization mode, the model as the host has configured it. It is kept so that the host may set another
    /// parameter after it has read an output.
    pub seed: Option<M>,
    /// Whether something was set since the outputs were last computed.
    pub stale: bool,
    /// Whether the model has computed its outputs' rates since something last changed.
    pub differentiated: bool,
    /// Whether an input has a slope for the next step.
    pub sloped: bool,
    /// The present communication point, s.
    pub time: f64,
    /// The start time, s.
    pub start: f64,
    /// The stop time, s, if the host has set one.
    pub stop: Option<f64>,
    /// The relative tolerance, if the host has set one.
    pub tolerance: Option<f64>,
    /// How the last step ended.
    pub last_step: Status,
    /// How often events were handled, and at which time, s.
    pub at_once: (f64, u32),
    /// Whether the host integrates the model (Model Exchange).
    pub exchange: bool,
}

impl<M> Run<M> {
    /// The experiment that the host has asked for, with the folder of the resources.
    pub fn experiment<'a>(&self, resources: Option<&'a Path>) -> Experiment<'a> {
        Experiment { start: self.start, stop: self.stop, tolerance: self.tolerance, resources }
    }
}
