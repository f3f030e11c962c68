//! Why a point has no result.

use std::fmt;

use serde::{Deserialize, Serialize};

use fmu_import::{Call, Status};

/// Why a point has no result. Its text is the `status` column of `points.csv`.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Failure {
    /// A parameter's value is not allowed by the FMU's description.
    OutOfRange(String),
    /// The FMU returned `fmi2Discard`, with its message.
    Discard(String),
    /// The FMU returned `fmi2Error`, with its message.
    Error(String),
    /// The FMU returned `fmi2Fatal`, with its message.
    Fatal(String),
    /// A result is not a finite number; its variable.
    NotFinite(String),
    /// The worker process died of a signal; its name, and the last words of the FMU.
    Crashed(String),
    /// The FMU ended its process; the exit code, and its last words.
    Exited(i32, String),
    /// The FMU cannot be loaded, and why.
    Unloadable(String),
    /// The point took too long.
    Timeout,
    /// The worker process took too much memory.
    OutOfMemory,
}

impl std::error::Error for Failure {}

impl Failure {
    /// The failure of a call of the FMU.
    pub fn from_call(call: &Call) -> Self {
        let text = match &call.message {
            Some(message) => format!("{message} ({})", call.function),
            None => call.function.to_owned(),
        };
        match call.status {
            Status::Discard => Self::Discard(text),
            Status::Fatal => Self::Fatal(text),
            Status::Pending => Self::Error(format!("fmi2Pending: {text}")),
            Status::Unknown(number) => Self::Error(format!("unknown status {number}: {text}")),
            _ => Self::Error(text),
        }
    }

    /// The class under which `summary.json` counts it.
    pub fn class(&self) -> &'static str {
        match self {
            Self::OutOfRange(_) => "out of range",
            Self::Discard(_) => "fmi2Discard",
            Self::Error(_) => "fmi2Error",
            Self::Fatal(_) => "fmi2Fatal",
            Self::NotFinite(_) => "not finite",
            Self::Crashed(_) => "crashed",
            Self::Exited(..) => "exited",
            Self::Unloadable(_) => "not loadable",
            Self::Timeout => "timeout",
            Self::OutOfMemory => "out of memory",
        }
    }
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let class = self.class();
        match self {
            Self::OutOfRange(text)
            | Self::Discard(text)
            | Self::Error(text)
            | Self::Fatal(text)
            | Self::NotFinite(text)
            | Self::Crashed(text) => write!(f, "{class}: {text}"),
            Self::Exited(code, words) => {
                let words = if words.is_empty() {
                    String::new()
                } else {
                    format!(": {words}")
                };
                write!(
                    f,
                    "{class}: the FMU ended its process with code {code}{words}"
                )
            }
            Self::Unloadable(text) => f.write_str(text),
            Self::Timeout | Self::OutOfMemory => f.write_str(class),
        }
    }
}
