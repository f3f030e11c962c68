//! Model Exchange: the host integrates the lag.

use std::ptr::{null, null_mut};

use fmu_export::description::{self, Interface, Version};
use fmu_export::fmi2::calls;
use fmu_export::fmi2::types::{EventInfo, Status};
use fmu_export::fmi3;
use lag::Lag;

use crate::answer;
use crate::host::{Discard, Error, Fatal, Host, Ok, vr};

/// The value references of the state and of its derivative.
const STATE: u32 = 1_000_000_000;
const RATE: u32 = 1_100_000_000;

/// An instance in continuous-time mode.
fn integrated() -> Host {
    let host = Host::exchange();
    assert_eq!([host.setup(None), host.enter(), host.exit()], [Ok; 3]);
    assert_eq!([new_states(&host), enter_continuous(&host)], [Ok; 2]);
    host
}

// SAFETY of all: the component is alive, and the pointers are ours.
#[allow(clippy::undocumented_unsafe_blocks)]
mod functions {
    use super::*;

    pub fn new_states(host: &Host) -> Status {
        let mut info = EventInfo { next_event_time_defined: 7, ..EventInfo::default() };
        let status = unsafe { calls::fmi2NewDiscreteStates::<Lag>(host.component, &mut info) };
        if status == Ok {
            assert_eq!(info.next_event_time_defined + info.new_discrete_states_needed, 0);
        }
        status
    }

    pub fn enter_continuous(host: &Host) -> Status {
        unsafe { calls::fmi2EnterContinuousTimeMode::<Lag>(host.component) }
    }

    pub fn enter_event(host: &Host) -> Status {
        unsafe { calls::fmi2EnterEventMode::<Lag>(host.component) }
    }

    pub fn set_time(host: &Host, time: f64) -> Status {
        unsafe { calls::fmi2SetTime::<Lag>(host.component, time) }
    }

    pub fn set_state(host: &Host, state: &[f64]) -> Status {
        unsafe { calls::fmi2SetContinuousStates::<Lag>(host.component, state.as_ptr(), state.len()) }
    }

    pub fn set(host: &Host, reference: u32) -> Status {
        unsafe { calls::fmi2SetReal::<Lag>(host.component, &reference, 1, &1.0) }
    }

    pub fn state(host: &Host) -> f64 {
        let mut state = f64::NAN;
        let status = unsafe { calls::fmi2GetContinuousStates::<Lag>(host.component, &mut state, 1) };
        assert_eq!(status, Ok);
        state
    }

    pub fn rate(host: &Host) -> Result<f64, Status> {
        let mut rate = f64::NAN;
        let status = unsafe { calls::fmi2GetDerivatives::<Lag>(host.component, &mut rate, 1) };
        if status == Ok { Result::Ok(rate) } else { Err(status) }
    }

    pub fn get(host: &Host, reference: u32) -> f64 {
        let mut value = f64::NAN;
        let status = unsafe { calls::fmi2GetReal::<Lag>(host.component, &reference, 1, &mut value) };
        assert_eq!(status, Ok);
        value
    }

    pub fn completed(host: &Host) -> (Status, [i32; 2]) {
        let mut flags = [7; 2];
        let [event, end] = &mut flags;
        let status = unsafe { calls::fmi2CompletedIntegratorStep::<Lag>(host.component, 1, event, end) };
        (status, flags)
    }
}
use functions::*;

/// One step of the classical Runge-Kutta method.
fn step(host: &Host, time: f64, h: f64) {
    let start = state(host);
    let slope = |time: f64, value: f64| {
        assert_eq!([set_time(host, time), set_state(host, &[value])], [Ok; 2]);
        rate(host).unwrap()
    };
    let a = slope(time, start);
    let b = slope(time + h / 2.0, start + h / 2.0 * a);
    let c = slope(time + h / 2.0, start + h / 2.0 * b);
    let d = slope(time + h, start + h * c);
    let end = start + h / 6.0 * (a + 2.0 * b + 2.0 * c + d);
    assert_eq!(set_state(host, &[end]), Ok);
    assert_eq!(completed(host), (Ok, [0; 2]));
}

#[test]
fn an_integration_meets_the_exact_solution() {
    let host = integrated();
    assert_eq!(host.set("input", 3.0), Ok);
    for i in 0..1000 {
        step(&host, f64::from(i) / 1000.0, 1e-3);
    }
    assert!((host.get("output") - answer(3.0, 1.0)).abs() < 1e-9);
    assert_eq!(get(&host, STATE), state(&host));
    assert_eq!(Result::Ok(get(&host, RATE)), rate(&host));
    assert_eq!(rate(&host), Result::Ok((6.0 - state(&host)) / 0.5));
    assert_eq!(host.get_string("report"), c"lag is at 1 s");
    assert_eq!(host.terminate(), Ok);
    assert_eq!(rate(&host), Result::Ok((6.0 - state(&host)) / 0.5));
}

#[test]
fn functions_have_their_modes() {
    let mut host = Host::exchange();
    assert_eq!(rate(&host), Err(Error));
    assert_eq!([host.setup(None), host.enter()], [Ok; 2]);
    assert_eq!(host.set("initialState", 7.0), Ok);
    assert_eq!(state(&host), 7.0, "the initialization follows what is set within it");
    assert_eq!([set_time(&host, 0.0), set_state(&host, &[1.0]), enter_continuous(&host)], [Error; 3]);
    assert_eq!(host.exit(), Ok);
    assert_eq!([host.step(0.0, 0.1), enter_event(&host)], [Error; 2]);
    assert_eq!([host.set("gain", 3.0), host.set_boolean("inverted", 1)], [Ok; 2], "in event mode");
    assert_eq!(host.set("initialState", 8.0), Error);
    assert_eq!([set(&host, STATE), set(&host, RATE)], [Error; 2]);
    assert!(host.said("a state is set by SetContinuousStates"));
    assert_eq!(set(&host, STATE + 1), Error);
    assert!(host.said("no variable has the value reference"));
    assert_eq!([new_states(&host), enter_continuous(&host)], [Ok; 2]);
    assert_eq!([new_states(&host), enter_continuous(&host)], [Error; 2]);
    assert_eq!(
        [host.set("gain", 2.0), host.set_boolean("inverted", 0)],
        [Error; 2],
        "only continuous inputs change now"
    );
    assert!(host.said("which cannot be set in continuous-time mode"));
    assert_eq!([host.set("input", 1.0), enter_event(&host)], [Ok; 2]);
    assert_eq!([host.reset(), host.setup(None), host.enter(), host.exit()], [Ok; 4]);
    assert_eq!(enter_continuous(&host), Ok, "still for Model Exchange");
}

#[test]
fn what_cannot_be_is_refused_and_changes_nothing() {
    let mut host = integrated();
    assert_eq!(set_state(&host, &[1.0, 2.0]), Error);
    assert!(host.said("`nContinuousStates` = 2"));
    assert_eq!(set_state(&host, &[f64::NAN]), Discard);
    assert_eq!(set_time(&host, f64::INFINITY), Error);
    // SAFETY: NULL is what the test is about.
    unsafe {
        let component = host.component;
        assert_eq!(calls::fmi2SetContinuousStates::<Lag>(component, null(), 1), Error);
        assert_eq!(calls::fmi2GetDerivatives::<Lag>(component, null_mut(), 1), Error);
        assert_eq!(calls::fmi2NewDiscreteStates::<Lag>(component, null_mut()), Error);
        assert_eq!(calls::fmi2GetEventIndicators::<Lag>(component, null_mut(), 0), Ok);
        assert_eq!(calls::fmi2GetEventIndicators::<Lag>(component, &mut 0.0, 1), Error);
    }
    assert_eq!(state(&host), 1.0);
    for (trouble, ended) in [(2, Discard), (3, Error), (1, Ok), (4, Fatal)] {
        assert_eq!(enter_event(&host), Ok);
        assert_eq!([host.set_integer("trouble", trouble), enter_continuous(&host)], [Ok; 2]);
        assert_eq!(rate(&host).err().unwrap_or(Ok), ended);
    }
}

#[test]
fn saved_states_belong_to_one_interface() {
    let (host, other) = (integrated(), Host::started());
    assert_eq!([set_time(&host, 0.5), set_state(&host, &[4.0])], [Ok; 2]);
    let saved = host.save();
    let bytes = host.bytes(saved);
    assert_eq!(set_state(&host, &[5.0]), Ok);
    assert_eq!([other.restore(saved), host.restore(saved), host.free(saved)], [Error, Ok, Ok]);
    assert_eq!(state(&host), 4.0);
    let again = integrated();
    let copy = again.state_of(&bytes).unwrap();
    assert_eq!([again.restore(copy), again.free(copy)], [Ok; 2]);
    assert_eq!((state(&again), rate(&again)), (4.0, rate(&host)));
    assert!(other.state_of(&bytes).is_err(), "another description");
}

/// FMI 3.0 comes down to the same.
#[test]
fn fmi_3_gives_the_same_rates() {
    use fmi3::calls;
    let token = description::token(description::fingerprint::<Lag>(Version::Three, Interface::ModelExchange)) + "\0";
    let two = integrated();
    let (mut state, mut rate, mut nominal, mut n) = (f64::NAN, f64::NAN, f64::NAN, 9);
    let (mut flags, mut time) = ([7_u8; 5], f64::NAN);
    // SAFETY: all arguments are what the standard asks for.
    unsafe {
        let (name, token) = (c"lag".as_ptr(), token.as_ptr().cast());
        let component = calls::fmi3InstantiateModelExchange::<Lag>(name, token, null(), 0, 0, null_mut(), None);
        assert!(!component.is_null());
        let done = [
            calls::fmi3EnterInitializationMode::<Lag>(component, 0, 0.0, 0.0, 0, 0.0),
            calls::fmi3ExitInitializationMode::<Lag>(component),
        ];
        assert_eq!(done, [Ok; 2]);
        let [a, b, c, d, e] = &mut flags;
        let update = calls::fmi3UpdateDiscreteStates::<Lag>(component, a, b, c, d, e, &mut time);
        assert_eq!((update, flags), (Ok, [0; 5]));
        assert_eq!(calls::fmi3GetNumberOfContinuousStates::<Lag>(component, &mut n), Ok);
        assert_eq!(n, 1);
        assert_eq!(calls::fmi3GetNumberOfEventIndicators::<Lag>(component, &mut n), Ok);
        assert_eq!(n, 0);
        assert_eq!(calls::fmi3EnterContinuousTimeMode::<Lag>(component), Ok);
        assert_eq!(calls::fmi3SetFloat64::<Lag>(component, &vr("input"), 1, &3.0, 1), Ok);
        assert_eq!(calls::fmi3SetTime::<Lag>(component, 0.25), Ok);
        assert_eq!(calls::fmi3SetContinuousStates::<Lag>(component, &2.5, 1), Ok);
        assert_eq!(calls::fmi3GetContinuousStates::<Lag>(component, &mut state, 1), Ok);
        assert_eq!(calls::fmi3GetContinuousStateDerivatives::<Lag>(component, &mut rate, 1), Ok);
        assert_eq!(calls::fmi3GetNominalsOfContinuousStates::<Lag>(component, &mut nominal, 1), Ok);
        let mut step = [7_u8; 2];
        let [event, end] = &mut step;
        assert_eq!(calls::fmi3CompletedIntegratorStep::<Lag>(component, 1, event, end), Ok);
        assert_eq!(step, [0; 2]);
        assert_eq!(calls::fmi3EnterEventMode::<Lag>(component), Ok);
        calls::fmi3FreeInstance::<Lag>(component);
    }
    assert_eq!([two.set("input", 3.0), set_state(&two, &[2.5])], [Ok; 2]);
    assert_eq!((state, rate, nominal), (2.5, functions::rate(&two).unwrap(), 1.0));
}

#[test]
fn descriptions_say_which_states_there_are() {
    for (xml, unknown) in [
        (description::xml::<Lag>(Version::Two, Interface::ModelExchange), "Derivatives"),
        (description::xml::<Lag>(Version::Three, Interface::ModelExchange), "ContinuousStateDerivative"),
    ] {
        let document = roxmltree::Document::parse(&xml).unwrap();
        let named = |name: &str| document.descendants().find(|node| node.attribute("name") == Some(name));
        assert!(named("steps").is_none(), "the lag counts its own steps");
        let reference = |name: &str| named(name).and_then(|node| node.attribute("valueReference"));
        assert_eq!(reference("state"), Some("1000000000"));
        assert_eq!(reference("der(state)"), Some("1100000000"));
        assert!(document.descendants().any(|node| node.has_tag_name(unknown)));
        assert!(document.descendants().any(|node| node.has_tag_name("ModelExchange")));
        assert!(!document.descendants().any(|node| node.has_tag_name("CoSimulation")));
    }
}
