//! Why a call is refused: the messages that users of an FMU read in their simulation tool.

use thiserror::Error;

use super::{
    phase::Phase,
    types::{Status, ValueReference},
};
use crate::model::Fault;

/// How a call ends.
pub type Outcome<T = ()> = Result<T, Refusal>;

/// Why a call is refused. The instance is as before the call, unless a computation failed.
#[derive(Debug, Error)]
pub enum Refusal {
    #[error("this function must not be called {0}")]
    Phase(Phase),
    #[error("`{0}` is NULL")]
    Null(&'static str),
    #[error("`{0}` is NULL although n > 0")]
    NullArray(&'static str),
    #[error("`{name}` cannot point to n = {n} values, which are more than any memory holds")]
    TooMany { name: &'static str, n: usize },
    #[error("`{0}` is misaligned for its type")]
    Misaligned(&'static str),
    #[error("`{0}` is not a handle that this FMU gave, or it was freed")]
    Foreign(&'static str),
    #[error("`{name}` = {value}: {why}")]
    Argument { name: &'static str, value: String, why: &'static str },
    #[error("no variable has the value reference {0}")]
    UnknownReference(ValueReference),
    #[error("{name} is of type {is}, not {asked}")]
    Type { name: &'static str, is: &'static str, asked: &'static str },
    #[error("{name} is {role}, which cannot be set {phase}")]
    NotSettable { name: &'static str, role: &'static str, phase: Phase },
    #[error("{name} cannot be accessed in intermediate update mode: {why}")]
    NotIntermediate { name: &'static str, why: &'static str },
    #[error("{name} cannot be set to {value}: it must be {allowed}")]
    Value { name: &'static str, value: String, allowed: String },
    #[error("{0} cannot be set to a value: it must be left alone, as the model computes it")]
    Computed(&'static str),
    #[error("{name}: {why}")]
    Derivative { name: &'static str, why: String },
    #[error("log category {0:?} is unknown; LogCategories in modelDescription.xml lists the known ones")]
    Category(String),
    #[error("the bytes are not a saved state of this FMU: {0}")]
    Bytes(String),
    #[error("`size` = {given}: the saved state takes {needed} bytes")]
    Size { given: usize, needed: usize },
    #[error("{0}")]
    Unsupported(&'static str),
    /// A function for what this FMU does not offer.
    #[error("{0}")]
    Absent(&'static str),
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
