//! Why a call is refused, in words for the person at the host.

use thiserror::Error;

use super::phase::Phase;
use super::types::{Status, ValueReference};
use crate::model::Fault;

/// How a call ends.
pub type Outcome<T = Status> = Result<T, Refusal>;

/// Why a call is refused. But for a failed step, nothing has changed.
#[derive(Debug, Error)]
pub enum Refusal {
    #[error("not allowed {0}")]
    Phase(Phase),
    #[error("argument {0} is NULL")]
    Null(&'static str),
    #[error("argument {0} is not a pointer to what it should be")]
    Pointer(&'static str),
    #[error("argument {name} = {value} is not usable: {why}")]
    Argument {
        name: &'static str,
        value: String,
        why: &'static str,
    },
    #[error("there is no variable with value reference {0}")]
    UnknownReference(ValueReference),
    #[error("variable {name} is of type {is}, not {asked}")]
    Type {
        name: &'static str,
        is: &'static str,
        asked: &'static str,
    },
    #[error("variable {name} is {role}, which cannot be set {phase}")]
    NotSettable {
        name: &'static str,
        role: &'static str,
        phase: Phase,
    },
    #[error("variable {name} cannot be set to {value}: it must be {allowed}")]
    Value {
        name: &'static str,
        value: String,
        allowed: String,
    },
    #[error("variable {name}: {why}")]
    Derivative { name: &'static str, why: String },
    #[error("log category {0:?} is unknown; the model description lists those there are")]
    Category(String),
    #[error("these bytes are not a saved state of this FMU: {0}")]
    Bytes(String),
    #[error("the size {given} does not fit the saved state, which takes {needed} bytes")]
    Size { given: usize, needed: usize },
    #[error("{0}")]
    Unsupported(&'static str),
    #[error(transparent)]
    Fault(#[from] Fault),
    #[error("{0}")]
    Step(#[source] Fault),
}

impl Refusal {
    /// The status that the host gets.
    pub fn status(&self) -> Status {
        match self {
            Self::Unsupported(_) | Self::Step(Fault::Failed(_)) => Status::Discard,
            _ => Status::Error,
        }
    }
}
