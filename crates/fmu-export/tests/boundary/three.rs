//! FMI 3.0, as far as it differs from FMI 2.0.

use std::ffi::{CStr, CString, c_void};
use std::ptr::{null, null_mut};

use fmu_export::description::{self, Interface, Version};
use fmu_export::fmi2;
use fmu_export::fmi3::calls;
use fmu_export::fmi3::types::{
    Boolean, Component, ComponentEnvironment, FALSE, LogMessageCallback, Status, Text, ValueReference,
};
use lag::Lag;

use crate::answer;
use crate::host::{Discard, Error, Fatal, Ok, vr};

/// The value reference of time.
const TIME: ValueReference = i32::MAX as ValueReference;

type Messages = Vec<(Status, String)>;

unsafe extern "C" fn logger(environment: ComponentEnvironment, status: Status, _: Text, message: Text) {
    // SAFETY: the environment is the host's list; the boundary sends C strings.
    let (messages, message) = unsafe { (&mut *environment.cast::<Messages>(), CStr::from_ptr(message)) };
    messages.push((status, message.to_string_lossy().into_owned()));
}

/// The lag in a host of FMI 3.0.
struct Host {
    component: Component,
    // Boxed: the boundary keeps a pointer to the list.
    messages: Box<Messages>,
}

impl Drop for Host {
    fn drop(&mut self) {
        // SAFETY: our own component, freed once.
        unsafe { calls::fmi3FreeInstance::<Lag>(self.component) }
    }
}

/// How a step ended: status, the flags event, terminate and early return, and the time that was reached.
type Stepped = (Status, [Boolean; 3], f64);

// SAFETY of all: the component is alive, and the pointers are ours.
#[allow(clippy::undocumented_unsafe_blocks)]
impl Host {
    fn with(token: &CStr, event_mode: Boolean) -> Self {
        let mut messages = Box::<Messages>::default();
        let environment = (&raw mut *messages).cast::<c_void>();
        let log: Option<LogMessageCallback> = Some(logger);
        let (name, token, folder) = (c"lag".as_ptr(), token.as_ptr(), c"/tmp/".as_ptr());
        let component = unsafe {
            calls::fmi3InstantiateCoSimulation::<Lag>(
                name,
                token,
                folder,
                FALSE,
                FALSE,
                event_mode,
                1,
                null(),
                0,
                environment,
                log,
                None,
            )
        };
        Self { component, messages }
    }

    fn new() -> Self {
        let host = Self::with(&token(), FALSE);
        assert!(!host.component.is_null(), "{:?}", host.messages);
        host
    }

    fn enter(&self, stop: Option<f64>) -> Status {
        let (defined, stop) = (stop.is_some().into(), stop.unwrap_or(f64::NAN));
        unsafe { calls::fmi3EnterInitializationMode::<Lag>(self.component, FALSE, f64::NAN, 0.0, defined, stop) }
    }

    fn exit(&self) -> Status {
        unsafe { calls::fmi3ExitInitializationMode::<Lag>(self.component) }
    }

    fn started() -> Self {
        let host = Self::new();
        assert_eq!([host.enter(None), host.exit()], [Ok; 2]);
        host
    }

    fn step(&self, from: f64, step: f64) -> Stepped {
        let (mut flags, mut reached) = ([7; 3], f64::NAN);
        let [event, end, early] = &mut flags;
        let status =
            unsafe { calls::fmi3DoStep::<Lag>(self.component, from, step, 1, event, end, early, &mut reached) };
        (status, flags, reached)
    }

    fn get(&self, reference: ValueReference) -> Result<f64, Status> {
        let mut value = f64::NAN;
        let status = unsafe { calls::fmi3GetFloat64::<Lag>(self.component, &reference, 1, &mut value, 1) };
        if status == Ok { Result::Ok(value) } else { Err(status) }
    }

    fn set(&self, name: &str, value: f64) -> Status {
        unsafe { calls::fmi3SetFloat64::<Lag>(self.component, &vr(name), 1, &value, 1) }
    }

    fn trouble(&self, value: i64) -> Status {
        unsafe { calls::fmi3SetInt64::<Lag>(self.component, &vr("trouble"), 1, &value, 1) }
    }

    /// The last message; all are taken.
    fn said(&mut self) -> String {
        let last = std::mem::take(&mut *self.messages).pop();
        last.map(|(_, text)| text).unwrap_or_default()
    }
}

fn token() -> CString {
    CString::new(description::token(description::fingerprint::<Lag>(Version::Three, Interface::CoSimulation))).unwrap()
}

#[test]
fn a_run_is_that_of_fmi_2_to_the_last_bit() {
    let (two, three) = (crate::host::Host::started(), Host::started());
    for i in 0..60 {
        let (time, input) = (f64::from(i) / 60.0, f64::from(i % 7));
        assert_eq!([two.set("input", input), three.set("input", input)], [Ok; 2]);
        assert_eq!(two.step(time, 1.0 / 60.0), Ok);
        assert_eq!(three.step(time, 1.0 / 60.0), (Ok, [FALSE; 3], time + 1.0 / 60.0));
        assert_eq!(three.get(vr("output")), Result::Ok(two.get("output")));
    }
    assert!(three.get(TIME).is_ok_and(|time| (time - 1.0).abs() < 1e-12));
}

#[test]
fn instantiation_is_refused_with_a_reason() {
    for (token, event_mode, reason) in [
        (c"{1}", FALSE, "`instantiationToken` = {1}"),
        (token().as_c_str(), 1, "`eventModeUsed` = fmi3True: this FMU has no event mode"),
    ] {
        let mut host = Host::with(token, event_mode);
        assert!(host.component.is_null());
        assert!(host.said().contains(reason), "{reason}");
    }
    let mut messages = Box::<Messages>::default();
    let environment = (&raw mut *messages).cast::<c_void>();
    let (name, token, log) = (c"lag".as_ptr(), token(), Some(logger as LogMessageCallback));
    // SAFETY: all arguments are what the standard asks for.
    let others = unsafe {
        let token = token.as_ptr();
        [
            calls::fmi3InstantiateModelExchange::<Lag>(name, token, null(), 0, 0, environment, log),
            calls::fmi3InstantiateScheduledExecution::<Lag>(
                name,
                token,
                null(),
                0,
                0,
                environment,
                log,
                null(),
                null(),
                null(),
            ),
        ]
    };
    assert_eq!(others, [null_mut(); 2]);
    for (message, says) in messages.iter().zip(["does not belong to this binary", "has no input clocks"]) {
        assert!(message.1.contains(says), "{message:?}");
    }
    assert_eq!(messages.len(), 2);
}

#[test]
fn start_values_can_be_read_before_the_initialization() {
    let host = Host::new();
    assert_eq!(host.get(vr("timeConstant")), Result::Ok(0.5));
    assert_eq!(host.set("timeConstant", 0.25), Ok);
    assert_eq!(host.get(vr("timeConstant")), Result::Ok(0.25));
    assert_eq!(host.step(0.0, 0.1).0, Error);
    assert_eq!(host.enter(Some(-1.0)), Error);
    assert_eq!([host.enter(Some(1.0)), host.exit()], [Ok; 2]);
    assert_eq!([host.enter(None), host.exit()], [Error; 2]);
    assert_eq!(host.step(0.0, 1.1).0, Error, "beyond the stop time");
}

#[test]
fn a_discarded_step_can_be_tried_again_at_once() {
    let mut host = Host::started();
    assert_eq!(host.step(0.0, 0.25), (Ok, [FALSE; 3], 0.25));
    assert_eq!(host.trouble(2), Ok);
    assert_eq!(host.step(0.25, 0.25), (Discard, [FALSE; 3], 0.25));
    assert_eq!([host.trouble(1), host.set("input", 3.0)], [Ok; 2]);
    assert_eq!(host.step(0.25, 0.25), (Ok, [FALSE; 3], 0.5));
    assert_eq!(host.trouble(3), Ok);
    assert_eq!(host.step(0.5, 0.25), (Error, [FALSE; 3], 0.5));
    assert!(host.said().contains("fmi3DoStep: the lag does not like"));
    assert_eq!(host.step(0.5, 0.25).0, Error, "not before a reset");
    let other = Host::started();
    assert_eq!(other.trouble(4), Ok);
    assert_eq!(other.step(0.0, 0.1).0, Fatal, "a panic stops at the boundary");
}

/// Pointers of `fmi3DoStep` that are NULL are refused before anything is done.
#[test]
fn a_step_needs_a_place_for_each_answer() {
    let mut host = Host::started();
    let (mut flag, mut time) = (7, f64::NAN);
    // SAFETY: the component is alive; NULL is what the test is about.
    let status = unsafe {
        let flag = &raw mut flag;
        calls::fmi3DoStep::<Lag>(host.component, 0.0, 0.1, 1, flag, null_mut(), flag, &mut time)
    };
    assert_eq!((status, flag), (Error, 7));
    assert!(host.said().contains("`terminateSimulation` is NULL"));
    assert_eq!(host.get(TIME), Result::Ok(0.0));
}

#[test]
fn types_and_counts_must_fit() {
    let mut host = Host::started();
    let component = host.component;
    let (mut real, mut small, mut long, mut whole) = ([f64::NAN; 2], 0_u8, 0_i64, 0_i32);
    // SAFETY of all: the component is alive, the pointers are ours.
    let mut refused = |status: Status, says: &str| {
        assert_eq!(status, Error, "{says}");
        let said = host.said();
        assert!(said.contains(says), "{said}");
    };
    // SAFETY: as said above.
    unsafe {
        let (input, steps, trouble) = (vr("input"), vr("steps"), vr("trouble"));
        let real = real.as_mut_ptr();
        refused(
            calls::fmi3GetFloat64::<Lag>(component, &input, 1, real, 2),
            "`nValues` = 2: there must be a value for each scalar",
        );
        refused(
            calls::fmi3GetInt32::<Lag>(component, &trouble, 1, &mut whole, 1),
            "trouble is of type Enumeration, not Int32",
        );
        refused(calls::fmi3GetInt64::<Lag>(component, &steps, 1, &mut long, 1), "steps is of type Int32, not Int64");
        refused(calls::fmi3GetUInt8::<Lag>(component, &input, 1, &mut small, 1), "input is of type Float64, not UInt8");
        refused(
            calls::fmi3SetInt64::<Lag>(component, &trouble, 1, &((1 << 32) + 1), 1),
            "trouble cannot be set to 4294967297",
        );
        refused(calls::fmi3SetFloat64::<Lag>(component, &TIME, 1, &1.0, 1), "value reference 2147483647");
        refused(calls::fmi3EnterEventMode::<Lag>(component), "must not be called while running");
        refused(calls::fmi3EvaluateDiscreteStates::<Lag>(component), "evaluates no discrete states");
        assert_eq!(calls::fmi3GetUInt8::<Lag>(component, null(), 0, null_mut(), 0), Ok);
        assert_eq!(calls::fmi3GetInt32::<Lag>(component, &steps, 1, &mut whole, 1), Ok);
        assert_eq!(calls::fmi3GetInt64::<Lag>(component, &trouble, 1, &mut long, 1), Ok);
    }
    assert_eq!((whole, long), (0, 1));
}

#[test]
fn an_instance_of_one_version_is_none_of_the_other() {
    let (two, three) = (crate::host::Host::started(), Host::started());
    // SAFETY: both components are alive.
    unsafe {
        assert_eq!(calls::fmi3Reset::<Lag>(two.component), Error);
        assert_eq!(fmi2::calls::fmi2Reset::<Lag>(three.component), Error);
        let state = two.save();
        assert_eq!(calls::fmi3SetFMUState::<Lag>(three.component, state), Error);
        assert_eq!(two.free(state), Ok);
    }
}

#[test]
fn adjoint_derivatives_are_the_transposed_directional_ones() {
    let host = Host::started();
    assert_eq!(host.set("input", 3.0), Ok);
    let (unknowns, knowns) = ([vr("feed"), vr("output")], [vr("input"), vr("gain")]);
    let mut adjoint = [f64::NAN; 2];
    // SAFETY: two values each.
    let status = unsafe {
        calls::fmi3GetAdjointDerivative::<Lag>(
            host.component,
            unknowns.as_ptr(),
            2,
            knowns.as_ptr(),
            2,
            [10.0, 1.0].as_ptr(),
            2,
            adjoint.as_mut_ptr(),
            2,
        )
    };
    assert_eq!(status, Ok);
    // feed = gain input; the output depends on neither at this instant.
    assert!((adjoint[0] - 20.0).abs() < 1e-7 && (adjoint[1] - 30.0).abs() < 1e-7, "{adjoint:?}");
}

#[test]
fn saved_states_continue_bit_for_bit() {
    let host = Host::started();
    assert_eq!([host.set("input", 0.3), host.step(0.0, 0.2).0], [Ok; 2]);
    let mut state = null_mut();
    // SAFETY: the component and the state are alive, the place is ours.
    unsafe {
        assert_eq!(calls::fmi3GetFMUState::<Lag>(host.component, &mut state), Ok);
        assert_eq!(host.step(0.2, 0.3).0, Ok);
        let end = host.get(vr("output"));
        assert!(end.is_ok_and(|end| (end - answer(0.3, 0.5)).abs() < 1e-13));
        assert_eq!(calls::fmi3SetFMUState::<Lag>(host.component, state), Ok);
        assert_eq!(host.get(TIME), Result::Ok(0.2));
        assert_eq!(host.step(0.2, 0.3).0, Ok);
        assert_eq!(host.get(vr("output")), end);
        assert_eq!(calls::fmi3FreeFMUState::<Lag>(host.component, &mut state), Ok);
    }
    assert!(state.is_null());
}
