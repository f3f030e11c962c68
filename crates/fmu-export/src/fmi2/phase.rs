//! The state machine of FMI 2.0 Co-Simulation (standard 2.0.4, section 4.2.4): which functions may be called in which
//! phase of an instance's life.

use std::fmt;

use serde::{Deserialize, Serialize};

/// Where an instance is in its life.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Phase {
    /// After `fmi2Instantiate` or `fmi2Reset`.
    Instantiated,
    /// Between `fmi2EnterInitializationMode` and `fmi2ExitInitializationMode`.
    Initialization,
    /// At a communication point.
    StepComplete,
    /// After a discarded step.
    StepFailed,
    /// After `fmi2Terminate`.
    Terminated,
    /// After a failed computation. Values can be read for debugging; else restore, reset or free.
    Error,
    /// After a panic. The instance can only be freed.
    Fatal,
}

impl fmt::Display for Phase {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Instantiated => "before the initialization",
            Self::Initialization => "in initialization mode",
            Self::StepComplete => "while running",
            Self::StepFailed => "after a discarded step",
            Self::Terminated => "after fmi2Terminate",
            Self::Error => "after an error",
            Self::Fatal => "after a fatal error",
        })
    }
}

/// A function of the standard and the phases in which it may be called.
pub struct Function {
    /// The C name.
    pub name: &'static str,
    /// A bit for each phase.
    phases: u8,
}

impl Function {
    const fn new(name: &'static str, phases: &[Phase]) -> Self {
        let (mut bits, mut at) = (0, 0);
        while at < phases.len() {
            bits |= 1 << phases[at] as u8;
            at += 1;
        }
        Self { name, phases: bits }
    }

    /// Whether the function may be called in this phase.
    pub fn allowed_in(&self, phase: Phase) -> bool {
        self.phases & (1 << phase as u8) != 0
    }
}

use Phase::{Error, Initialization, Instantiated, StepComplete, StepFailed, Terminated};

const ALIVE: &[Phase] = &[
    Instantiated,
    Initialization,
    StepComplete,
    StepFailed,
    Terminated,
    Error,
];
const READABLE: &[Phase] = &[Initialization, StepComplete, StepFailed, Terminated, Error];
const SETTABLE: &[Phase] = &[Instantiated, Initialization, StepComplete];

macro_rules! functions {
    ($($constant:ident $name:ident $phases:expr;)*) => {
        $(pub const $constant: Function = Function::new(stringify!($name), $phases);)*
    };
}

functions! {
    SET_DEBUG_LOGGING fmi2SetDebugLogging ALIVE;
    SETUP_EXPERIMENT fmi2SetupExperiment &[Instantiated];
    ENTER_INITIALIZATION fmi2EnterInitializationMode &[Instantiated];
    EXIT_INITIALIZATION fmi2ExitInitializationMode &[Initialization];
    TERMINATE fmi2Terminate &[StepComplete, StepFailed];
    RESET fmi2Reset ALIVE;
    GET_REAL fmi2GetReal READABLE;
    GET_INTEGER fmi2GetInteger READABLE;
    GET_BOOLEAN fmi2GetBoolean READABLE;
    GET_STRING fmi2GetString READABLE;
    SET_REAL fmi2SetReal SETTABLE;
    SET_INTEGER fmi2SetInteger SETTABLE;
    SET_BOOLEAN fmi2SetBoolean SETTABLE;
    SET_STRING fmi2SetString SETTABLE;
    GET_STATE fmi2GetFMUstate ALIVE;
    SET_STATE fmi2SetFMUstate ALIVE;
    FREE_STATE fmi2FreeFMUstate ALIVE;
    SERIALIZED_SIZE fmi2SerializedFMUstateSize ALIVE;
    SERIALIZE fmi2SerializeFMUstate ALIVE;
    DESERIALIZE fmi2DeSerializeFMUstate ALIVE;
    DIRECTIONAL_DERIVATIVE fmi2GetDirectionalDerivative READABLE;
    SET_INPUT_DERIVATIVES fmi2SetRealInputDerivatives SETTABLE;
    GET_OUTPUT_DERIVATIVES fmi2GetRealOutputDerivatives &[StepComplete, StepFailed, Terminated, Error];
    DO_STEP fmi2DoStep &[StepComplete];
    CANCEL_STEP fmi2CancelStep &[];
    GET_STATUS fmi2GetStatus &[StepComplete, StepFailed, Terminated, Error];
    GET_REAL_STATUS fmi2GetRealStatus &[StepComplete, StepFailed, Terminated, Error];
    GET_INTEGER_STATUS fmi2GetIntegerStatus &[StepComplete, StepFailed, Terminated, Error];
    GET_BOOLEAN_STATUS fmi2GetBooleanStatus &[StepComplete, StepFailed, Terminated, Error];
    GET_STRING_STATUS fmi2GetStringStatus &[StepComplete, StepFailed, Terminated, Error];
}
