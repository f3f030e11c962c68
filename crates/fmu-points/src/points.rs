//! Points, those who run them, and what may happen meanwhile.

use std::{ops::ControlFlow, time::Duration};

use serde::{Deserialize, Serialize};
use thiserror::Error;

use crate::{as_json, failure::Failure, notices::Notices};

/// Why a run cannot go on at all. What happens to a single point is a [`Failure`].
#[derive(Debug, Error)]
pub enum RunError {
    /// A worker cannot be started.
    #[error("cannot start a worker: {0}")]
    Start(String),
    /// The FMU cannot be loaded.
    #[error("{0}")]
    Unloadable(String),
    /// A worker was lost and cannot be replaced.
    #[error("a worker was lost: {0}")]
    Lost(String),
    /// Workers on other machines are lost, and cannot be replaced.
    #[error("no worker is left: {0}")]
    NoWorker(String),
}

/// Limits on a point's time and memory.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub struct PointLimits {
    /// The longest time that a point may take.
    pub time: Duration,
    /// The most memory that its process may occupy, bytes.
    pub memory: u64,
}

impl PointLimits {
    /// No limits: for a single point, while a person is watching.
    pub const NONE: Self = Self { time: Duration::MAX, memory: u64::MAX };
}

/// A point to run: its index, and its parameters in the FMU's units.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Job {
    /// The index of the point.
    pub index: u64,
    /// The parameters.
    pub values: Vec<f64>,
}

/// The results of a point in the FMU's units, or why there are none.
pub type PointResult = Result<Vec<f64>, Failure>;

/// Whether two outcomes are results that are the same to the last bit.
pub fn is_same<E>(one: &Result<Simulated, E>, other: &Result<Simulated, E>) -> bool {
    let bits = |outcome: &Result<Simulated, E>| -> Option<Vec<u64>> {
        let values = &outcome.as_ref().ok()?.values;
        Some(values.iter().map(|value| value.to_bits()).collect())
    };
    bits(one).is_some() && bits(one) == bits(other)
}

/// A simulated point.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Simulated {
    /// The results in the FMU's units.
    pub values: Vec<f64>,
    /// The FMU's remarks beside them, if there were any.
    #[serde(with = "as_json")]
    pub notices: Option<Box<Notices>>,
}

impl From<Vec<f64>> for Simulated {
    fn from(values: Vec<f64>) -> Self {
        Self { values, notices: None }
    }
}

impl Simulated {
    /// Results with what was said beside them.
    pub(crate) fn new(values: Vec<f64>, notices: &Notices) -> Self {
        Self { values, notices: (!notices.is_empty()).then(|| Box::new(notices.clone())) }
    }
}

/// Events of a run.
#[derive(Debug)]
pub enum Event {
    /// The FMU's warnings in the point of this index, of which the next event will be that it failed.
    Said(u64, Box<Notices>),
    /// The point of this index is done.
    Answer(u64, Result<Simulated, Failure>),
    /// All answers so far have been handed over; the next one is waited for.
    Idle,
}

/// The connection of a running worker: its instructions, and the place for its answers.
pub struct Post<'a> {
    /// Takes what happens; breaks where nothing further is wanted.
    pub take: &'a mut dyn FnMut(Event) -> ControlFlow<()>,
    /// Whether the run is to end at once.
    pub stopped: &'a dyn Fn() -> bool,
    over: bool,
    /// Points that are given back, since they could not be run here through no fault of theirs.
    pub(crate) returned: Vec<Job>,
}

impl<'a> Post<'a> {
    /// Hands everything to `take`.
    pub fn new(take: &'a mut dyn FnMut(Event) -> ControlFlow<()>, stopped: &'a dyn Fn() -> bool) -> Self {
        Self { take, stopped, over: false, returned: Vec::new() }
    }

    /// Reports what happened.
    pub fn send(&mut self, event: Event) {
        self.over |= (self.take)(event).is_break();
    }

    /// Whether nothing further is wanted.
    pub fn is_over(&self) -> bool {
        self.over || (self.stopped)()
    }
}

/// Something that runs points one after another.
pub trait Worker: Send {
    /// Runs the jobs and reports each one as soon as it is done, exactly once; may stop early
    /// when the post says so, and give points back.
    ///
    /// # Errors
    /// When no further point can be run.
    fn run(&mut self, jobs: &[Job], post: &mut Post) -> Result<(), RunError>;

    /// Waits until it can take points; `false` where it will not, or is `stopped` before.
    ///
    /// # Errors
    /// When no worker can take points any more.
    fn ready(&mut self, _stopped: &dyn Fn() -> bool) -> Result<bool, RunError> {
        Ok(true)
    }

    /// How long its last points took beyond their computation.
    fn overhead(&self) -> Duration {
        Duration::ZERO
    }
}
