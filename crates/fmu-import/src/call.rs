//! Calls of an FMU that did not succeed.

use std::ffi::c_int;

use thiserror::Error;

/// The status that a function of FMI returns.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Status {
    /// Done.
    Ok,
    /// Done, but something is to be looked at.
    Warning,
    /// Not done; nothing has changed.
    Discard,
    /// Failed; the instance cannot go on.
    Error,
    /// Failed; the FMU cannot go on in this process.
    Fatal,
    /// Not yet done.
    Pending,
    /// A number that the standard does not know.
    Unknown(i32),
}

impl From<c_int> for Status {
    fn from(status: c_int) -> Self {
        match status {
            0 => Self::Ok,
            1 => Self::Warning,
            2 => Self::Discard,
            3 => Self::Error,
            4 => Self::Fatal,
            5 => Self::Pending,
            other => Self::Unknown(other),
        }
    }
}

impl Status {
    /// Its name in the version of FMI of a function: `fmi2Error` where that is `fmi2DoStep`.
    pub fn name(self, function: &str) -> String {
        match self {
            Self::Unknown(number) => format!("unknown status {number}"),
            known => format!("{}{known:?}", function.get(..4).unwrap_or("fmi")),
        }
    }
}

/// What a call gives, or why it did not succeed.
pub type Called<T = ()> = Result<T, Call>;

/// A call that did not succeed.
#[derive(Clone, Debug, Error)]
#[error("{}: {}", status.name(function), self.reason())]
pub struct Call {
    /// The function, such as `fmi2DoStep`.
    pub function: &'static str,
    /// The status that it returned.
    pub status: Status,
    /// The FMU's own messages.
    pub message: Option<String>,
    /// Where the FMU has ended the simulation by itself, which the standard allows: in FMI 2.0 it has refused the step
    /// (`fmi2Discard`) and said that it wants no further one (`fmi2Terminated`), in FMI 3.0 it has said
    /// `terminateSimulation`.
    pub ended: Option<EarlyEnd>,
}

/// How far an FMU got that ended the simulation by itself.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EarlyEnd {
    /// When its last step began, s.
    pub from: f64,
    /// The time that it reached, s.
    pub at: f64,
}

/// The warnings of an FMU: calls that returned `fmi2Warning` or `fmi3Warning`, and messages logged as warnings. A call that does both
/// counts once. Beside them stands what is none: the limits of its model that a simulation passed.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Warnings {
    /// How many there were since the instance was created or reset.
    pub count: u64,
    /// The first one: the function where a call returned it, and the FMU's message.
    pub first: Option<String>,
    /// Messages in the log category `validity`, the first [of each kind](crate::validity).
    pub beyond: Vec<String>,
}

impl Call {
    fn reason(&self) -> String {
        match &self.message {
            Some(message) => format!("{message} ({})", self.function),
            None => format!("{} failed without a message", self.function),
        }
    }
}
