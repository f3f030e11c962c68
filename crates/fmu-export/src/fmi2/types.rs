//! The C types of FMI 2.0, after the standard's `fmi2TypesPlatform.h` and `fmi2FunctionTypes.h`.

use std::ffi::{c_char, c_int, c_void};

pub use crate::boundary::types::{
    CallbackLogger, Component, ComponentEnvironment, FmuState, Real, Status, Text, ValueReference,
};

/// `fmi2Integer`.
pub type Integer = c_int;
/// `fmi2Boolean`: 0 is false, everything else is true.
pub type Boolean = c_int;
/// `fmi2Type`, `fmi2StatusKind`: an enumeration of C.
pub type Choice = c_int;
/// `fmi2Byte`.
pub type Byte = c_char;

/// `fmi2True`.
pub const TRUE: Boolean = 1;
/// `fmi2False`.
pub const FALSE: Boolean = 0;
/// `fmi2ModelExchange` of `fmi2Type`.
pub const MODEL_EXCHANGE: Choice = 0;
/// `fmi2CoSimulation` of `fmi2Type`.
pub const CO_SIMULATION: Choice = 1;

/// `fmi2DoStepStatus` of `fmi2StatusKind`.
pub const DO_STEP_STATUS: Choice = 0;
/// `fmi2LastSuccessfulTime` of `fmi2StatusKind`.
pub const LAST_SUCCESSFUL_TIME: Choice = 2;
/// `fmi2Terminated` of `fmi2StatusKind`.
pub const TERMINATED: Choice = 3;

/// `fmi2EventInfo`; by default nothing happens.
#[derive(Clone, Copy, Debug, Default)]
#[repr(C)]
pub struct EventInfo {
    /// Whether `fmi2NewDiscreteStates` must be called again.
    pub new_discrete_states_needed: Boolean,
    /// Whether the simulation must end.
    pub terminate_simulation: Boolean,
    /// Whether nominal values have changed.
    pub nominals_changed: Boolean,
    /// Whether states have changed.
    pub states_changed: Boolean,
    /// Whether the next time event is known.
    pub next_event_time_defined: Boolean,
    /// When it is, s.
    pub next_event_time: Real,
}

/// `fmi2CallbackFunctions`. The memory functions are never called: the boundary uses Rust's
/// allocator and declares `canNotUseMemoryManagementFunctions`.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct CallbackFunctions {
    /// Takes log messages; may be NULL.
    pub logger: Option<CallbackLogger>,
    /// Not used.
    pub allocate_memory: Option<unsafe extern "C" fn(usize, usize) -> *mut c_void>,
    /// Not used.
    pub free_memory: Option<unsafe extern "C" fn(*mut c_void)>,
    /// Not used: steps are synchronous.
    pub step_finished: Option<unsafe extern "C" fn(ComponentEnvironment, Status)>,
    /// Given to the logger.
    pub component_environment: ComponentEnvironment,
}
