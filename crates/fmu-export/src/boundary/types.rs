//! The C types that all versions of the standard share.

use std::ffi::{c_char, c_uint, c_void};

/// A handle to an instance: `fmi2Component`, `fmi3Instance`.
pub type Component = *mut c_void;
/// The host's own pointer, given back to its callbacks: `fmi2ComponentEnvironment`, `fmi3InstanceEnvironment`.
pub type ComponentEnvironment = *mut c_void;
/// A handle to a saved state: `fmi2FMUstate`, `fmi3FMUState`.
pub type FmuState = *mut c_void;
/// `fmi2ValueReference`, `fmi3ValueReference`.
pub type ValueReference = c_uint;
/// `fmi2Real`, `fmi3Float64`.
pub type Real = f64;
/// `fmi2String`, `fmi3String`: UTF-8, ended by NUL.
pub type Text = *const c_char;

/// `fmi2Status`, `fmi3Status`: how a call has ended.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
#[repr(i32)]
pub enum Status {
    /// The call succeeded.
    #[default]
    Ok = 0,
    /// The call succeeded, but something needs a look.
    Warning = 1,
    /// The step could not be computed; the state is as before it.
    Discard = 2,
    /// The call was refused or failed.
    Error = 3,
    /// The instance is unusable.
    Fatal = 4,
    /// FMI 2.0 only: the step is still being computed. Never returned: steps are synchronous.
    Pending = 5,
}

/// `fmi2CallbackLogger`: a printf-like function of the host.
pub type CallbackLogger = unsafe extern "C" fn(ComponentEnvironment, Text, Status, Text, Text, ...);

/// `fmi3IntermediateUpdateCallback`: takes environment and time, whether inputs may be set, whether outputs may be read, whether
/// they are final, whether the step can be ended, and the places for the answer: whether it shall end, and when.
pub type IntermediateUpdateCallback =
    unsafe extern "C" fn(ComponentEnvironment, Real, bool, bool, bool, bool, *mut u8, *mut Real);

/// `fmi3LogMessageCallback`: takes environment, status, category and message.
pub type LogMessageCallback = unsafe extern "C" fn(ComponentEnvironment, Status, Text, Text);
