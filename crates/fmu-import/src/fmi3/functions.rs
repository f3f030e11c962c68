//! The functions that only a binary of FMI 3.0 exports.

use std::ffi::{c_char, c_int, c_void};

use crate::{
    description::Interface,
    symbols::{self, Component, Function, LibraryError, Plain, Symbols},
};

type Get<T> = unsafe extern "C" fn(Component, *const u32, usize, *mut T, usize) -> c_int;
type Set<T> = unsafe extern "C" fn(Component, *const u32, usize, *const T, usize) -> c_int;
/// `fmi3LogMessageCallback`.
pub type LogMessage = unsafe extern "C" fn(*const c_void, c_int, *const c_char, *const c_char);
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
pub enum Instantiates {
    CoSimulation(Function<Instantiate>),
    ModelExchange(Function<InstantiateExchange>),
}
/// `fmi3DoStep`. The flags are bytes rather than `bool`, as an FMU may write any.
type DoStep = unsafe extern "C" fn(Component, f64, f64, bool, *mut u8, *mut u8, *mut u8, *mut f64) -> c_int;

type GetBinary = unsafe extern "C" fn(Component, *const u32, usize, *mut usize, *mut *const u8, usize) -> c_int;
type SetBinary = unsafe extern "C" fn(Component, *const u32, usize, *const usize, *const *const u8, usize) -> c_int;

/// To read and write variables of one type. Some FMUs leave out those of types that they have not.
pub type Access<T> = symbols::Access<Get<T>, Set<T>>;

/// The functions that only FMI 3.0 has, or has in its own way, and that an importer calls.
#[derive(Clone, Copy, Debug)]
pub struct Functions {
    pub instantiate: Instantiates,
    pub set_debug_logging: Function<unsafe extern "C" fn(Component, bool, usize, *const *const c_char) -> c_int>,
    pub enter_initialization_mode: Function<unsafe extern "C" fn(Component, bool, f64, f64, bool, f64) -> c_int>,
    pub do_step: Function<DoStep>,
    pub float32: Access<f32>,
    pub float64: Access<f64>,
    pub int8: Access<i8>,
    pub uint8: Access<u8>,
    pub int16: Access<i16>,
    pub uint16: Access<u16>,
    pub int32: Access<i32>,
    pub uint32: Access<u32>,
    pub int64: Access<i64>,
    pub uint64: Access<u64>,
    /// Bytes, as an FMU may write others than 0 and 1.
    pub boolean: Access<u8>,
    pub string: Access<*const c_char>,
    pub binary: symbols::Access<GetBinary, SetBinary>,
    pub enter_configuration_mode: Function<Plain>,
    pub exit_configuration_mode: Function<Plain>,
}

impl Functions {
    /// Finds them in a loaded binary.
    pub fn find(symbols: &Symbols, interface: Interface) -> Result<Self, LibraryError> {
        Ok(Self {
            instantiate: match interface {
                Interface::CoSimulation => Instantiates::CoSimulation(symbols.need("InstantiateCoSimulation")?),
                Interface::ModelExchange => Instantiates::ModelExchange(symbols.need("InstantiateModelExchange")?),
            },
            set_debug_logging: symbols.find("SetDebugLogging"),
            enter_initialization_mode: symbols.need("EnterInitializationMode")?,
            // Some binaries for Model Exchange alone have none, and nobody calls it.
            do_step: symbols.need_if(interface == Interface::CoSimulation, "DoStep")?,
            float32: symbols.access("Float32"),
            float64: symbols.access("Float64"),
            int8: symbols.access("Int8"),
            uint8: symbols.access("UInt8"),
            int16: symbols.access("Int16"),
            uint16: symbols.access("UInt16"),
            int32: symbols.access("Int32"),
            uint32: symbols.access("UInt32"),
            int64: symbols.access("Int64"),
            uint64: symbols.access("UInt64"),
            boolean: symbols.access("Boolean"),
            string: symbols.access("String"),
            binary: symbols.access("Binary"),
            enter_configuration_mode: symbols.find("EnterConfigurationMode"),
            exit_configuration_mode: symbols.find("ExitConfigurationMode"),
        })
    }
}
