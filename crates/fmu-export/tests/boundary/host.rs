//! A host for tests: the C functions of the lag, called as a C host calls them.
#![expect(clippy::unwrap_used, reason = "only tests use it")]

use std::ffi::{CStr, CString, c_char, c_void};
use std::ptr::{null, null_mut};

use fmu_export::description::{self, Interface, Version};
use fmu_export::fmi2::calls;
use fmu_export::fmi2::types::{
    CO_SIMULATION, CallbackFunctions, CallbackLogger, Component, ComponentEnvironment, FALSE, FmuState, Status, TRUE,
    Text, ValueReference,
};
use fmu_export::model::Model;
use lag::Lag;

pub use Status::{Discard, Error, Fatal, Ok};

/// A message that arrived at the host.
#[derive(Clone, Debug, PartialEq)]
pub struct Message {
    pub status: Status,
    pub category: String,
    pub text: String,
}

/// The type of the logger as it is defined below. Rust cannot define variadic functions; on the
/// platforms that run the tests, a function with one named argument in place of the variadic one
/// is called in the same way.
type Fixed = unsafe extern "C" fn(ComponentEnvironment, Text, Status, Text, Text, *const c_char);

unsafe extern "C" fn logger(
    environment: ComponentEnvironment,
    _instance: Text,
    status: Status,
    category: Text,
    format: Text,
    message: *const c_char,
) {
    // SAFETY: the environment is the host's list; the boundary sends C strings.
    let (messages, category, format, text) = unsafe {
        (
            &mut *environment.cast::<Vec<Message>>(),
            CStr::from_ptr(category),
            CStr::from_ptr(format),
            CStr::from_ptr(message),
        )
    };
    assert_eq!(format, c"%s", "the message is data, never the format");
    let [category, text] = [category, text].map(|text| text.to_string_lossy().into_owned());
    messages.push(Message { status, category, text });
}

/// The lag in a host.
pub struct Host {
    pub component: Component,
    // Boxed: the boundary keeps a pointer to the list.
    #[expect(clippy::box_collection)]
    messages: Box<Vec<Message>>,
}

impl Host {
    /// An instance of the lag, not yet initialised.
    pub fn new() -> Self {
        let host = Self::with(c"lag", &guid(), CO_SIMULATION, c"file:///tmp");
        assert!(!host.component.is_null(), "{:?}", host.messages);
        host
    }

    /// An instance for Model Exchange, not yet initialised.
    pub fn exchange() -> Self {
        let guid = description::token(description::fingerprint::<Lag>(Version::Two, Interface::ModelExchange));
        let host = Self::with(c"lag", &CString::new(guid).unwrap(), 0, c"file:///tmp");
        assert!(!host.component.is_null(), "{:?}", host.messages);
        host
    }

    /// Calls `fmi2Instantiate` with these arguments.
    pub fn with(name: &CStr, guid: &CStr, kind: i32, resources: &CStr) -> Self {
        let mut messages = Box::new(Vec::<Message>::new());
        // SAFETY: the same calling convention for both, see `Fixed`. Miri refuses such a call.
        let logger = (!cfg!(miri)).then(|| unsafe { std::mem::transmute::<Fixed, CallbackLogger>(logger) });
        let component = {
            let callbacks = CallbackFunctions {
                logger,
                allocate_memory: None,
                free_memory: None,
                step_finished: None,
                component_environment: (&raw mut *messages).cast::<c_void>(),
            };
            // SAFETY: all arguments are what the standard asks for. The callbacks live only here.
            unsafe {
                calls::fmi2Instantiate::<Lag>(
                    name.as_ptr(),
                    kind,
                    guid.as_ptr(),
                    resources.as_ptr(),
                    &raw const callbacks,
                    FALSE,
                    FALSE,
                )
            }
        };
        Self { component, messages }
    }

    /// An instance at its first communication point.
    pub fn started() -> Self {
        let host = Self::new();
        assert_eq!(host.setup(None), Ok);
        assert_eq!(host.enter(), Ok);
        assert_eq!(host.exit(), Ok);
        host
    }

    /// Takes the messages that came so far.
    pub fn messages(&mut self) -> Vec<Message> {
        std::mem::take(&mut self.messages)
    }

    /// The list of messages.
    pub fn log(&mut self) -> &mut Vec<Message> {
        &mut self.messages
    }

    /// Whether the last message contains a text. Takes all messages. Miri cannot call the logger, so there it does.
    pub fn said(&mut self, text: &str) -> bool {
        let last = self.messages().pop();
        cfg!(miri) || last.is_some_and(|message| message.text.contains(text))
    }
}

impl Drop for Host {
    fn drop(&mut self) {
        // SAFETY: our own component, freed once.
        unsafe { calls::fmi2FreeInstance::<Lag>(self.component) }
    }
}

/// The GUID of the lag.
pub fn guid() -> CString {
    CString::new(description::token(description::fingerprint::<Lag>(Version::Two, Interface::CoSimulation))).unwrap()
}

/// The value reference of a variable of the lag.
pub fn vr(name: &str) -> ValueReference {
    let index = Lag::variables().iter().position(|variable| variable.name == name);
    index.unwrap().try_into().unwrap()
}

/// Calls of the C functions with one value, as tests mostly need them.
// SAFETY of all: the component is alive; pointers are to live values, their counts are right.
#[allow(clippy::undocumented_unsafe_blocks)]
impl Host {
    pub fn setup(&self, stop: Option<f64>) -> Status {
        let defined = if stop.is_some() { TRUE } else { FALSE };
        let stop = stop.unwrap_or(f64::NAN);
        unsafe { calls::fmi2SetupExperiment::<Lag>(self.component, FALSE, f64::NAN, 0.0, defined, stop) }
    }

    pub fn enter(&self) -> Status {
        unsafe { calls::fmi2EnterInitializationMode::<Lag>(self.component) }
    }

    pub fn exit(&self) -> Status {
        unsafe { calls::fmi2ExitInitializationMode::<Lag>(self.component) }
    }

    pub fn terminate(&self) -> Status {
        unsafe { calls::fmi2Terminate::<Lag>(self.component) }
    }

    pub fn reset(&self) -> Status {
        unsafe { calls::fmi2Reset::<Lag>(self.component) }
    }

    pub fn step(&self, from: f64, step: f64) -> Status {
        unsafe { calls::fmi2DoStep::<Lag>(self.component, from, step, TRUE) }
    }

    pub fn set(&self, name: &str, value: f64) -> Status {
        unsafe { calls::fmi2SetReal::<Lag>(self.component, &vr(name), 1, &value) }
    }

    pub fn try_get(&self, name: &str) -> Result<f64, Status> {
        let mut value = f64::NAN;
        let status = unsafe { calls::fmi2GetReal::<Lag>(self.component, &vr(name), 1, &mut value) };
        if status == Ok { Result::Ok(value) } else { Err(status) }
    }

    pub fn get(&self, name: &str) -> f64 {
        self.try_get(name).unwrap()
    }

    pub fn set_integer(&self, name: &str, value: i32) -> Status {
        unsafe { calls::fmi2SetInteger::<Lag>(self.component, &vr(name), 1, &value) }
    }

    pub fn get_integer(&self, name: &str) -> i32 {
        let mut value = i32::MIN;
        let status = unsafe { calls::fmi2GetInteger::<Lag>(self.component, &vr(name), 1, &mut value) };
        assert_eq!(status, Ok);
        value
    }

    pub fn set_boolean(&self, name: &str, value: i32) -> Status {
        unsafe { calls::fmi2SetBoolean::<Lag>(self.component, &vr(name), 1, &value) }
    }

    pub fn set_string(&self, name: &str, value: &CStr) -> Status {
        unsafe { calls::fmi2SetString::<Lag>(self.component, &vr(name), 1, &value.as_ptr()) }
    }

    pub fn get_string(&self, name: &str) -> &CStr {
        let mut value = null();
        let status = unsafe { calls::fmi2GetString::<Lag>(self.component, &vr(name), 1, &mut value) };
        assert_eq!(status, Ok);
        unsafe { CStr::from_ptr(value) }
    }

    pub fn slope(&self, name: &str, order: i32, value: f64) -> Status {
        unsafe { calls::fmi2SetRealInputDerivatives::<Lag>(self.component, &vr(name), 1, &order, &value) }
    }

    pub fn rate(&self, name: &str) -> f64 {
        let mut value = f64::NAN;
        let status =
            unsafe { calls::fmi2GetRealOutputDerivatives::<Lag>(self.component, &vr(name), 1, &1, &mut value) };
        assert_eq!(status, Ok);
        value
    }

    pub fn derivative(&self, unknown: &str, known: &str) -> f64 {
        let mut value = f64::NAN;
        let status = unsafe {
            calls::fmi2GetDirectionalDerivative::<Lag>(self.component, &vr(unknown), 1, &vr(known), 1, &1.0, &mut value)
        };
        assert_eq!(status, Ok);
        value
    }

    pub fn save(&self) -> FmuState {
        let mut state = null_mut();
        assert_eq!(unsafe { calls::fmi2GetFMUstate::<Lag>(self.component, &mut state) }, Ok);
        state
    }

    pub fn restore(&self, state: FmuState) -> Status {
        unsafe { calls::fmi2SetFMUstate::<Lag>(self.component, state) }
    }

    pub fn free(&self, mut state: FmuState) -> Status {
        unsafe { calls::fmi2FreeFMUstate::<Lag>(self.component, &mut state) }
    }

    pub fn bytes(&self, state: FmuState) -> Vec<u8> {
        let mut size = 0;
        let status = unsafe { calls::fmi2SerializedFMUstateSize::<Lag>(self.component, state, &mut size) };
        assert_eq!(status, Ok);
        let mut bytes = vec![0_u8; size];
        let status =
            unsafe { calls::fmi2SerializeFMUstate::<Lag>(self.component, state, bytes.as_mut_ptr().cast(), size) };
        assert_eq!(status, Ok);
        bytes
    }

    pub fn state_of(&self, bytes: &[u8]) -> Result<FmuState, Status> {
        let mut state = null_mut();
        let status = unsafe {
            let bytes_ = bytes.as_ptr().cast();
            calls::fmi2DeSerializeFMUstate::<Lag>(self.component, bytes_, bytes.len(), &mut state)
        };
        if status == Ok { Result::Ok(state) } else { Err(status) }
    }
}
