//! The functions that a binary of FMI 3.0 exports.

use std::ffi::{c_char, c_int, c_void};

use libloading::Library as Loaded;

use crate::description::Interface;
use crate::simulation::Component;
use crate::symbols::{LibraryError, Text, symbol};

type Get<T> = unsafe extern "C" fn(Component, *const u32, usize, *mut T, usize) -> c_int;
type Set<T> = unsafe extern "C" fn(Component, *const u32, usize, *const T, usize) -> c_int;
/// `fmi3GetFMUState` and `fmi3FreeFMUState`.
type TakeState = unsafe extern "C" fn(Component, *mut *mut c_void) -> c_int;
type PutState = unsafe extern "C" fn(Component, *mut c_void) -> c_int;
type Plain = unsafe extern "C" fn(Component) -> c_int;
/// `fmi3LogMessageCallback`.
pub(super) type LogMessage =
    unsafe extern "C" fn(*const c_void, c_int, *const c_char, *const c_char);
/// `fmi3InstantiateCoSimulation`.
type Instantiate = unsafe extern "C" fn(
    *const c_char,
    *const c_char,
    *const c_char,
    bool,
    bool,
    bool,
    bool,
    *const u32,
    usize,
    *const c_void,
    LogMessage,
    *const c_void,
) -> Component;
/// `fmi3InstantiateModelExchange`.
type InstantiateExchange = unsafe extern "C" fn(
    *const c_char,
    *const c_char,
    *const c_char,
    bool,
    bool,
    *const c_void,
    LogMessage,
) -> Component;
/// To create a component, by its interface.
#[derive(Clone, Copy, Debug)]
pub(super) enum Instantiates {
    CoSimulation(Instantiate),
    ModelExchange(InstantiateExchange),
}
/// `fmi3DoStep`. The flags are bytes rather than `bool`, as an FMU may write any.
type DoStep =
    unsafe extern "C" fn(Component, f64, f64, bool, *mut u8, *mut u8, *mut u8, *mut f64) -> c_int;

/// The functions that read and write variables of one type. Some FMUs leave out those of types that they have not.
#[derive(Clone, Copy, Debug)]
pub(super) struct Access<T> {
    pub(super) get: Option<Get<T>>,
    pub(super) set: Option<Set<T>>,
    /// Their names.
    pub(super) getter: &'static str,
    pub(super) setter: &'static str,
}

impl<T> Access<T> {
    fn find(library: &Loaded, getter: &'static str, setter: &'static str) -> Self {
        Self {
            get: symbol(library, getter).ok(),
            set: symbol(library, setter).ok(),
            getter,
            setter,
        }
    }
}

/// The functions of FMI 3.0 for Co-Simulation that an importer calls.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Functions {
    pub(crate) get_version: Option<Text>,
    pub(super) instantiate: Instantiates,
    pub(super) free_instance: unsafe extern "C" fn(Component),
    pub(super) set_debug_logging:
        Option<unsafe extern "C" fn(Component, bool, usize, *const *const c_char) -> c_int>,
    pub(super) enter_initialization_mode:
        unsafe extern "C" fn(Component, bool, f64, f64, bool, f64) -> c_int,
    pub(super) exit_initialization_mode: Plain,
    pub(super) terminate: Option<Plain>,
    pub(super) reset: Option<Plain>,
    /// To get, set and free a state, where the FMU can.
    pub(crate) states: Option<(TakeState, PutState, TakeState)>,
    pub(super) do_step: DoStep,
    pub(super) float32: Access<f32>,
    pub(super) float64: Access<f64>,
    pub(super) int8: Access<i8>,
    pub(super) uint8: Access<u8>,
    pub(super) int16: Access<i16>,
    pub(super) uint16: Access<u16>,
    pub(super) int32: Access<i32>,
    pub(super) uint32: Access<u32>,
    pub(super) int64: Access<i64>,
    pub(super) uint64: Access<u64>,
    /// Bytes, as an FMU may write others than 0 and 1.
    pub(super) boolean: Access<u8>,
    pub(super) string: Access<*const c_char>,
}

/// Stands for `fmi3DoStep` where there is none: Model Exchange never calls it.
unsafe extern "C" fn no_step(
    _: Component,
    _: f64,
    _: f64,
    _: bool,
    _: *mut u8,
    _: *mut u8,
    _: *mut u8,
    _: *mut f64,
) -> c_int {
    const ERROR: c_int = 3;
    ERROR
}

impl Functions {
    /// Finds them in a loaded binary.
    pub(crate) fn find(library: &Loaded, interface: Interface) -> Result<Self, LibraryError> {
        let states = || {
            Some((
                symbol(library, "fmi3GetFMUState").ok()?,
                symbol(library, "fmi3SetFMUState").ok()?,
                symbol(library, "fmi3FreeFMUState").ok()?,
            ))
        };
        Ok(Self {
            get_version: symbol(library, "fmi3GetVersion").ok(),
            instantiate: match interface {
                Interface::CoSimulation => {
                    Instantiates::CoSimulation(symbol(library, "fmi3InstantiateCoSimulation")?)
                }
                Interface::ModelExchange => {
                    Instantiates::ModelExchange(symbol(library, "fmi3InstantiateModelExchange")?)
                }
            },
            free_instance: symbol(library, "fmi3FreeInstance")?,
            set_debug_logging: symbol(library, "fmi3SetDebugLogging").ok(),
            enter_initialization_mode: symbol(library, "fmi3EnterInitializationMode")?,
            exit_initialization_mode: symbol(library, "fmi3ExitInitializationMode")?,
            terminate: symbol(library, "fmi3Terminate").ok(),
            reset: symbol(library, "fmi3Reset").ok(),
            states: states(),
            // Some binaries for Model Exchange alone have none.
            do_step: match interface {
                Interface::CoSimulation => symbol(library, "fmi3DoStep")?,
                Interface::ModelExchange => no_step,
            },
            float32: Access::find(library, "fmi3GetFloat32", "fmi3SetFloat32"),
            float64: Access::find(library, "fmi3GetFloat64", "fmi3SetFloat64"),
            int8: Access::find(library, "fmi3GetInt8", "fmi3SetInt8"),
            uint8: Access::find(library, "fmi3GetUInt8", "fmi3SetUInt8"),
            int16: Access::find(library, "fmi3GetInt16", "fmi3SetInt16"),
            uint16: Access::find(library, "fmi3GetUInt16", "fmi3SetUInt16"),
            int32: Access::find(library, "fmi3GetInt32", "fmi3SetInt32"),
            uint32: Access::find(library, "fmi3GetUInt32", "fmi3SetUInt32"),
            int64: Access::find(library, "fmi3GetInt64", "fmi3SetInt64"),
            uint64: Access::find(library, "fmi3GetUInt64", "fmi3SetUInt64"),
            boolean: Access::find(library, "fmi3GetBoolean", "fmi3SetBoolean"),
            string: Access::find(library, "fmi3GetString", "fmi3SetString"),
        })
    }
}
