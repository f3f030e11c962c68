//! The C types of FMI 2.0, after the standard's `fmi2TypesPlatform.h` and `fmi2FunctionTypes.h`.

use std::ffi::{c_char, c_int, c_uint, c_void};

/// `fmi2Component`: a handle to an instance.
pub type Component = *mut c_void;
/// `fmi2ComponentEnvironment`: the host's own pointer, given back to its callbacks.
pub type ComponentEnvironment = *mut c_void;
/// `fmi2FMUstate`: a handle to a saved state.
pub type FmuState = *mut c_void;
/// `fmi2ValueReference`.
pub type ValueReference = c_uint;
/// `fmi2Real`.
pub type Real = f64;
/// `fmi2Integer`.
pub type Integer = c_int;
/// `fmi2Boolean`: 0 is false, everything else is true.
pub type Boolean = c_int;
/// `fmi2String`: UTF-8, ended by NUL.
pub type Text = *const c_char;
/// `fmi2Byte`.
pub type Byte = c_char;

/// `fmi2True`.
pub const TRUE: Boolean = 1;
/// `fmi2False`.
pub const FALSE: Boolean = 0;
/// `fmi2CoSimulation` of `fmi2Type`.
pub const CO_SIMULATION: c_int = 1;

/// `fmi2DoStepStatus` of `fmi2StatusKind`.
pub const DO_STEP_STATUS: c_int = 0;
/// `fmi2LastSuccessfulTime` of `fmi2StatusKind`.
pub const LAST_SUCCESSFUL_TIME: c_int = 2;
/// `fmi2Terminated` of `fmi2StatusKind`.
pub const TERMINATED: c_int = 3;

/// `fmi2Status`: how a call has ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
#[repr(i32)]
pub enum Status {
    /// The call succeeded.
    Ok = 0,
    /// The call succeeded, but something needs a look.
    Warning = 1,
    /// The step could not be computed; the state is as before it.
    Discard = 2,
    /// The call was refused or failed.
    Error = 3,
    /// The instance is unusable.
    Fatal = 4,
    /// The step is still being computed. Never returned: steps are synchronous.
    Pending = 5,
}

/// `fmi2CallbackLogger`: a printf-like function of the host.
pub type CallbackLogger = unsafe extern "C" fn(ComponentEnvironment, Text, Status, Text, Text, ...);

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
