//! The phases of an instance's life, and the functions that may be called in them. Each version of the standard has its
//! own list of functions.

use std::fmt;

use serde::{Deserialize, Serialize};

use super::version::Version;

/// Where an instance is in its life.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Phase {
    /// After the instantiation or a reset.
    #[default]
    Instantiated,
    /// In initialization mode.
    Initialization,
    /// At a communication point.
    StepComplete,
    /// After a discarded step.
    StepFailed,
    /// After the termination.
    Terminated,
    /// After a failed computation. Values can be read for debugging; else restore, reset or free.
    Error,
    /// After a panic. The instance can only be freed.
    Fatal,
    /// Model Exchange: between two stretches of continuous time.
    Event,
    /// Model Exchange: the host integrates.
    Continuous,
    /// FMI 3.0 Co-Simulation: between two inner steps of a communication step, while the host's callback runs.
    Intermediate,
}

impl fmt::Display for Phase {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(match self {
            Self::Instantiated => "before the initialization",
            Self::Initialization => "in initialization mode",
            Self::StepComplete => "while running",
            Self::StepFailed => "after a discarded step",
            Self::Terminated => "after the termination",
            Self::Error => "after an error",
            Self::Fatal => "after a fatal error",
            Self::Event => "in event mode",
            Self::Continuous => "in continuous-time mode",
            Self::Intermediate => "in intermediate update mode",
        })
    }
}

/// A set of phases, a bit for each.
pub type Phases = u16;

/// The set of these phases.
pub const fn of(phases: &[Phase]) -> Phases {
    let (mut bits, mut at) = (0, 0);
    while at < phases.len() {
        bits |= 1 << phases[at] as u8;
        at += 1;
    }
    bits
}

/// A function of the standard.
pub struct Function {
    /// The C name.
    pub name: &'static str,
    /// The version of the standard that the function belongs to.
    pub version: Version,
    /// The phases in which it may be called.
    pub phases: Phases,
}

/// All phases but [`Phase::Fatal`], and [`Phase::Intermediate`], in which a call is still at work.
pub const ALIVE: Phases = !of(&[Phase::Fatal, Phase::Intermediate]);

/// The phases in which FMI 3.0 lets values be read: they are start values at first.
pub const VISIBLE: Phases = ALIVE | of(&[Phase::Intermediate]);

/// The phases in which computed values can be read.
pub const READABLE: Phases = ALIVE & !of(&[Phase::Instantiated]);

/// The phases in which partial derivatives can be asked for: not in Model Exchange, whose event mode refuses them itself.
pub const DERIVABLE: Phases = READABLE & !of(&[Phase::Continuous]);

/// The phases in which states can be read.
pub const INTEGRABLE: Phases = READABLE & !of(&[Phase::StepComplete, Phase::StepFailed]);

/// The phases in which values can be set.
pub const SETTABLE: Phases = VISIBLE & !of(&[Phase::StepFailed, Phase::Terminated, Phase::Error]);
