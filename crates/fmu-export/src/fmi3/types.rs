//! The C types of FMI 3.0, after the standard's `fmi3PlatformTypes.h` and `fmi3FunctionTypes.h`.

use std::ffi::c_void;

pub use crate::boundary::types::{
    Component, ComponentEnvironment, FmuState, IntermediateUpdateCallback, LogMessageCallback, Real, Status, Text,
    ValueReference,
};

/// `fmi3Boolean`, C's `bool`: a byte, as a host may pass any, and 0 is false.
pub type Boolean = u8;
/// `fmi3Byte`.
pub type Byte = u8;
/// `fmi3Binary`.
pub type Binary = *const u8;
/// A callback that this boundary never calls.
pub type Unused = *const c_void;

/// `fmi3True`.
pub const TRUE: Boolean = 1;
/// `fmi3False`.
pub const FALSE: Boolean = 0;
