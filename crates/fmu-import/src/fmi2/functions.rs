//! The functions that only a binary of FMI 2.0 exports.

use std::ffi::{c_char, c_int};

use crate::{
    description::Interface,
    logger::Callbacks,
    symbols::{self, Component, Function, LibraryError, Plain, Symbols, Text},
};

pub type Get<T> = unsafe extern "C" fn(Component, *const u32, usize, *mut T) -> c_int;
pub type Set<T> = unsafe extern "C" fn(Component, *const u32, usize, *const T) -> c_int;
/// `fmi2SetRealInputDerivatives`.
type SetSlopes = unsafe extern "C" fn(Component, *const u32, usize, *const c_int, *const f64) -> c_int;
/// `fmi2GetStatus` and those like it.
pub type GetStatus<T> = unsafe extern "C" fn(Component, c_int, *mut T) -> c_int;

/// To read and write variables of one type.
pub type Access<T> = symbols::Access<Get<T>, Set<T>>;

/// The functions of FMI 2.0 that an importer calls.
#[derive(Clone, Copy, Debug)]
pub struct Functions {
    pub get_types_platform: Function<Text>,
    pub instantiate: Function<
        unsafe extern "C" fn(
            *const c_char,
            c_int,
            *const c_char,
            *const c_char,
            *const Callbacks,
            c_int,
            c_int,
        ) -> Component,
    >,
    pub set_debug_logging: Function<unsafe extern "C" fn(Component, c_int, usize, *const *const c_char) -> c_int>,
    pub setup_experiment: Function<unsafe extern "C" fn(Component, c_int, f64, f64, c_int, f64) -> c_int>,
    pub enter_initialization_mode: Function<Plain>,
    pub real: Access<f64>,
    pub integer: Access<c_int>,
    pub boolean: Access<c_int>,
    /// Some FMUs without texts leave them out.
    pub string: Access<*const c_char>,
    /// To set the rates of inputs, where the FMU interpolates them.
    pub set_slopes: Function<SetSlopes>,
    pub do_step: Function<unsafe extern "C" fn(Component, f64, f64, c_int) -> c_int>,
    pub get_status: Function<GetStatus<c_int>>,
    pub get_real_status: Function<GetStatus<f64>>,
    pub get_boolean_status: Function<GetStatus<c_int>>,
}

impl Functions {
    /// Finds them in a loaded binary.
    pub fn find(symbols: &Symbols, interface: Interface) -> Result<Self, LibraryError> {
        Ok(Self {
            get_types_platform: symbols.find("GetTypesPlatform"),
            instantiate: symbols.need("Instantiate")?,
            set_debug_logging: symbols.find("SetDebugLogging"),
            setup_experiment: symbols.need("SetupExperiment")?,
            enter_initialization_mode: symbols.need("EnterInitializationMode")?,
            real: symbols.needed_access("Real")?,
            integer: symbols.needed_access("Integer")?,
            boolean: symbols.needed_access("Boolean")?,
            string: symbols.access("String"),
            set_slopes: symbols.find("SetRealInputDerivatives"),
            // A binary for Model Exchange alone has none, and nobody calls it.
            do_step: symbols.need_if(interface == Interface::CoSimulation, "DoStep")?,
            get_status: symbols.find("GetStatus"),
            get_real_status: symbols.find("GetRealStatus"),
            get_boolean_status: symbols.find("GetBooleanStatus"),
        })
    }
}
