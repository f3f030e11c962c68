//! The functions that a binary of FMI 2.0 exports.

use std::ffi::{c_char, c_int, c_void};

use libloading::Library as Loaded;

use crate::description::Interface;
use crate::logger::Callbacks;
use crate::simulation::Component;
use crate::symbols::{LibraryError, Text, symbol};

pub(super) type Get<T> = unsafe extern "C" fn(Component, *const u32, usize, *mut T) -> c_int;
pub(super) type Set<T> = unsafe extern "C" fn(Component, *const u32, usize, *const T) -> c_int;
/// `fmi2GetFMUstate` and `fmi2FreeFMUstate`.
type TakeState = unsafe extern "C" fn(Component, *mut *mut c_void) -> c_int;
type PutState = unsafe extern "C" fn(Component, *mut c_void) -> c_int;
/// `fmi2SetRealInputDerivatives`.
type SetSlopes =
    unsafe extern "C" fn(Component, *const u32, usize, *const c_int, *const f64) -> c_int;
type Plain = unsafe extern "C" fn(Component) -> c_int;

/// The functions of FMI 2.0 for Co-Simulation that an importer calls.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Functions {
    pub(crate) get_version: Option<Text>,
    pub(crate) get_types_platform: Option<Text>,
    pub(crate) instantiate: unsafe extern "C" fn(
        *const c_char,
        c_int,
        *const c_char,
        *const c_char,
        *const Callbacks,
        c_int,
        c_int,
    ) -> Component,
    pub(crate) free_instance: unsafe extern "C" fn(Component),
    pub(crate) set_debug_logging:
        Option<unsafe extern "C" fn(Component, c_int, usize, *const *const c_char) -> c_int>,
    pub(crate) setup_experiment:
        unsafe extern "C" fn(Component, c_int, f64, f64, c_int, f64) -> c_int,
    pub(crate) enter_initialization_mode: Plain,
    pub(crate) exit_initialization_mode: Plain,
    pub(crate) terminate: Option<Plain>,
    pub(crate) reset: Option<Plain>,
    /// To get, set and free a state, where the FMU can.
    pub(crate) states: Option<(TakeState, PutState, TakeState)>,
    pub(crate) get_real: Get<f64>,
    pub(crate) get_integer: Get<c_int>,
    pub(crate) get_boolean: Get<c_int>,
    pub(crate) get_string: Option<Get<*const c_char>>,
    pub(crate) set_real: Set<f64>,
    pub(crate) set_integer: Set<c_int>,
    pub(crate) set_boolean: Set<c_int>,
    pub(crate) set_string: Option<Set<*const c_char>>,
    /// To set the rates of inputs, where the FMU interpolates them.
    pub(crate) set_slopes: Option<SetSlopes>,
    pub(crate) do_step: unsafe extern "C" fn(Component, f64, f64, c_int) -> c_int,
    pub(crate) get_status: Option<unsafe extern "C" fn(Component, c_int, *mut c_int) -> c_int>,
    pub(crate) get_real_status: Option<unsafe extern "C" fn(Component, c_int, *mut f64) -> c_int>,
    pub(crate) get_boolean_status:
        Option<unsafe extern "C" fn(Component, c_int, *mut c_int) -> c_int>,
}

/// Stands for `fmi2DoStep` where there is none: Model Exchange never calls it.
unsafe extern "C" fn no_step(_: Component, _: f64, _: f64, _: c_int) -> c_int {
    const ERROR: c_int = 3;
    ERROR
}

impl Functions {
    /// Finds them in a loaded binary.
    pub(crate) fn find(library: &Loaded, interface: Interface) -> Result<Self, LibraryError> {
        let states = || {
            Some((
                symbol(library, "fmi2GetFMUstate").ok()?,
                symbol(library, "fmi2SetFMUstate").ok()?,
                symbol(library, "fmi2FreeFMUstate").ok()?,
            ))
        };
        Ok(Self {
            get_version: symbol(library, "fmi2GetVersion").ok(),
            get_types_platform: symbol(library, "fmi2GetTypesPlatform").ok(),
            states: states(),
            instantiate: symbol(library, "fmi2Instantiate")?,
            free_instance: symbol(library, "fmi2FreeInstance")?,
            set_debug_logging: symbol(library, "fmi2SetDebugLogging").ok(),
            setup_experiment: symbol(library, "fmi2SetupExperiment")?,
            enter_initialization_mode: symbol(library, "fmi2EnterInitializationMode")?,
            exit_initialization_mode: symbol(library, "fmi2ExitInitializationMode")?,
            terminate: symbol(library, "fmi2Terminate").ok(),
            reset: symbol(library, "fmi2Reset").ok(),
            get_real: symbol(library, "fmi2GetReal")?,
            get_integer: symbol(library, "fmi2GetInteger")?,
            get_boolean: symbol(library, "fmi2GetBoolean")?,
            get_string: symbol(library, "fmi2GetString").ok(),
            set_real: symbol(library, "fmi2SetReal")?,
            set_integer: symbol(library, "fmi2SetInteger")?,
            set_boolean: symbol(library, "fmi2SetBoolean")?,
            set_string: symbol(library, "fmi2SetString").ok(),
            set_slopes: symbol(library, "fmi2SetRealInputDerivatives").ok(),
            // A binary for Model Exchange alone has none.
            do_step: match interface {
                Interface::CoSimulation => symbol(library, "fmi2DoStep")?,
                Interface::ModelExchange => no_step,
            },
            get_status: symbol(library, "fmi2GetStatus").ok(),
            get_real_status: symbol(library, "fmi2GetRealStatus").ok(),
            get_boolean_status: symbol(library, "fmi2GetBooleanStatus").ok(),
        })
    }
}
