//! Intermediate updates of FMI 3.0, and early returns.

use std::cell::RefCell;
use std::ffi::{CStr, CString, c_void};
use std::ptr::null_mut;

use fmu_export::description::{self, Interface, Version};
use fmu_export::fmi3::calls;
use fmu_export::fmi3::types::{
    Boolean, Component, ComponentEnvironment, FALSE, IntermediateUpdateCallback, Status, TRUE, Text, ValueReference,
};
use lag::Lag;

use crate::host::{Discard, Error, Ok, vr};

/// The lag's inner step, s: a power of two, so that sums of it are exact.
const INNER: f64 = 0.0625;

/// The FMU's arguments in an update.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Update {
    time: f64,
    set: bool,
    early: bool,
}

/// A host's reaction to an update; it may ask for an early return.
type Script = Box<dyn FnMut(Component, Update) -> Option<f64>>;

/// The host's data behind the environment pointer.
struct World {
    messages: RefCell<Vec<String>>,
    updates: RefCell<Vec<Update>>,
    component: RefCell<Component>,
    script: RefCell<Script>,
}

unsafe extern "C" fn logger(environment: ComponentEnvironment, _: Status, _: Text, message: Text) {
    // SAFETY: the environment is the host's; the boundary sends C strings.
    let (world, message) = unsafe { (&*environment.cast::<World>(), CStr::from_ptr(message)) };
    let message = message.to_string_lossy().into_owned();
    world.messages.borrow_mut().push(message);
}

unsafe extern "C" fn update(
    environment: ComponentEnvironment,
    time: f64,
    set: bool,
    get: bool,
    finished: bool,
    early: bool,
    requested: *mut u8,
    at: *mut f64,
) {
    assert!(get && finished);
    // SAFETY: the environment is the host's.
    let world = unsafe { &*environment.cast::<World>() };
    let update = Update { time, set, early };
    world.updates.borrow_mut().push(update);
    let component = *world.component.borrow();
    if let Some(time) = world.script.borrow_mut()(component, update) {
        // SAFETY: the FMU's places for the answer.
        unsafe { (*requested, *at) = (TRUE, time) };
    }
}

struct Host(Component, Box<World>);

impl Drop for Host {
    fn drop(&mut self) {
        // SAFETY: our own component, freed once.
        unsafe { calls::fmi3FreeInstance::<Lag>(self.0) }
    }
}

// SAFETY of all: the component is alive, and the pointers are ours.
#[allow(clippy::undocumented_unsafe_blocks)]
impl Host {
    fn with(script: Option<Script>, variables: &[ValueReference], early: Boolean) -> Result<Self, String> {
        let callback = script.is_some().then_some(update as _);
        let world = Box::new(World {
            messages: RefCell::default(),
            updates: RefCell::default(),
            component: RefCell::new(null_mut()),
            script: RefCell::new(script.unwrap_or_else(|| Box::new(|_, _| None))),
        });
        let callback: Option<IntermediateUpdateCallback> = callback;
        let token =
            CString::new(description::token(description::fingerprint::<Lag>(Version::Three, Interface::CoSimulation)))
                .unwrap();
        let environment = (&raw const *world).cast::<c_void>().cast_mut();
        let component = unsafe {
            calls::fmi3InstantiateCoSimulation::<Lag>(
                c"lag".as_ptr(),
                token.as_ptr(),
                c"/tmp/".as_ptr(),
                FALSE,
                FALSE,
                FALSE,
                early,
                variables.as_ptr(),
                variables.len(),
                environment,
                Some(logger),
                callback,
            )
        };
        if component.is_null() {
            return Err(world.messages.borrow().join("\n"));
        }
        *world.component.borrow_mut() = component;
        unsafe {
            let entered = calls::fmi3EnterInitializationMode::<Lag>(component, 0, 0.0, 0.0, 0, 0.0);
            assert_eq!(entered, Ok);
            assert_eq!(calls::fmi3ExitInitializationMode::<Lag>(component), Ok);
        }
        assert_eq!(set(component, "input", 1.0), Ok);
        Result::Ok(Self(component, world))
    }

    /// Takes a step; returns its status, whether it ended early, and the time that was reached.
    fn step(&self, from: f64, step: f64) -> (Status, Boolean, f64) {
        let (mut event, mut end, mut early, mut reached) = (7, 7, 7, f64::NAN);
        let status =
            unsafe { calls::fmi3DoStep::<Lag>(self.0, from, step, 1, &mut event, &mut end, &mut early, &mut reached) };
        assert_eq!([event, end], [FALSE; 2]);
        (status, early, reached)
    }

    /// The updates so far.
    fn updates(&self) -> Vec<Update> {
        self.1.updates.borrow().clone()
    }

    /// The last message; all are taken.
    fn said(&self) -> String {
        self.1.messages.take().pop().unwrap_or_default()
    }
}

fn set(component: Component, name: &str, value: f64) -> Status {
    // SAFETY: the component is alive, and the pointers are ours.
    unsafe { calls::fmi3SetFloat64::<Lag>(component, &vr(name), 1, &value, 1) }
}

fn get(component: Component, name: &str) -> Result<f64, Status> {
    let mut value = f64::NAN;
    // SAFETY: the component is alive, and the pointers are ours.
    let status = unsafe { calls::fmi3GetFloat64::<Lag>(component, &vr(name), 1, &mut value, 1) };
    if status == Ok { Result::Ok(value) } else { Err(status) }
}

fn trouble(component: Component, value: i64) -> Status {
    // SAFETY: the component is alive, and the pointers are ours.
    unsafe { calls::fmi3SetInt64::<Lag>(component, &vr("trouble"), 1, &value, 1) }
}

/// A host that reads and sets nothing.
fn silent() -> Option<Script> {
    Some(Box::new(|_, _| None))
}

#[test]
fn a_watched_step_is_a_host_s_steps_by_inner_steps_to_the_last_bit() {
    let watched = Host::with(silent(), &[], FALSE).unwrap();
    let plain = Host::with(None, &[], FALSE).unwrap();
    assert_eq!(watched.step(0.0, 0.25), (Ok, FALSE, 0.25));
    for i in 0..4 {
        plain.step(f64::from(i) * INNER, INNER);
    }
    assert_eq!(get(watched.0, "output"), get(plain.0, "output"));
    let told = [1.0, 2.0, 3.0, 4.0].map(|i| Update { time: i * INNER, set: i < 4.0, early: false });
    assert_eq!(watched.updates(), told);
    assert_eq!(plain.updates(), []);
}

#[test]
fn a_step_that_is_one_inner_step_is_that_without_updates_to_the_last_bit() {
    let watched = Host::with(silent(), &[], TRUE).unwrap();
    let plain = Host::with(None, &[], TRUE).unwrap();
    for i in 0..60 {
        let from = f64::from(i) / 60.0;
        assert_eq!(watched.step(from, 1.0 / 60.0), plain.step(from, 1.0 / 60.0));
        assert_eq!(get(watched.0, "output"), get(plain.0, "output"));
    }
    assert_eq!(watched.updates().len(), 60);
}

#[test]
fn a_host_reads_and_sets_announced_variables_and_nothing_else() {
    let script: Script = Box::new(|lag, update| {
        let output = get(lag, "output").unwrap();
        let rate = {
            let mut rate = f64::NAN;
            // SAFETY: the component is alive, and the pointers are ours.
            let status = unsafe { calls::fmi3GetOutputDerivatives::<Lag>(lag, &vr("output"), 1, &1, &mut rate, 1) };
            assert_eq!(status, Ok);
            rate
        };
        // d output/dt = (gain input - output)/constant, with the input of the inner step that has ended.
        let input = update.time / INNER;
        assert!((rate - (2.0 * input - output) / 0.5).abs() < 1e-12);
        let next = set(lag, "input", input + 1.0);
        assert_eq!(next, if update.set { Ok } else { Error });
        assert!(get(lag, "feed").is_ok(), "an output that was not announced");
        // Not accessible, not settable, or not announced.
        assert_eq!(set(lag, "gain", 3.0), Error);
        assert_eq!(get(lag, "gain"), Err(Error));
        assert_eq!(set(lag, "output", 3.0), Error);
        assert_eq!(set(lag, "feed", 3.0), Error);
        assert_eq!(trouble(lag, 2), Error);
        let mut state = null_mut();
        let (a, b, c, d) = (&mut 0, &mut 0, &mut 0, &mut 0.0);
        // SAFETY: the component is alive, and the pointers are ours.
        let others = unsafe {
            [
                calls::fmi3DoStep::<Lag>(lag, 0.0, 1.0, 1, a, b, c, d),
                calls::fmi3Reset::<Lag>(lag),
                calls::fmi3Terminate::<Lag>(lag),
                calls::fmi3GetFMUState::<Lag>(lag, &mut state),
            ]
        };
        assert_eq!(others, [Error; 4]);
        // SAFETY: the component is alive, and stays so.
        unsafe { calls::fmi3FreeInstance::<Lag>(lag) };
        None
    });
    let host = Host::with(Some(script), &[vr("output"), vr("input")], FALSE).unwrap();
    assert_eq!(host.step(0.0, 4.0 * INNER), (Ok, FALSE, 4.0 * INNER));
    assert_eq!(host.updates().len(), 4);
    let messages = host.1.messages.take();
    for expected in [
        "fmi3SetFloat64: gain cannot be accessed in intermediate update mode: it has no intermediateUpdate attribute",
        "fmi3SetFloat64: feed cannot be accessed in intermediate update mode: it is not among the requiredIntermediateVariables",
        "fmi3SetFloat64: output is an output, which cannot be set in intermediate update mode",
        "fmi3DoStep: this function must not be called in intermediate update mode",
        "fmi3SetFloat64: input cannot be accessed in intermediate update mode: the step is complete",
    ] {
        let said = messages.iter().any(|message| message.contains(expected));
        assert!(said, "{expected} is not among {messages:?}");
    }
    // The exact answer to an input of 1, 2, 3 and 4 in the four inner steps.
    let plain = Host::with(None, &[], FALSE).unwrap();
    for i in 0..4 {
        assert_eq!(set(plain.0, "input", f64::from(i) + 1.0), Ok);
        plain.step(f64::from(i) * INNER, INNER);
    }
    assert_eq!(get(host.0, "output"), get(plain.0, "output"));
}

#[test]
fn a_step_ends_early_at_the_time_that_the_host_asks_for() {
    // The host's time, the end that follows, and the number of updates.
    let cases = [
        (0.1, 0.1, 2),        // later, within the next inner step
        (0.0, INNER, 1),      // it has passed: now
        (f64::NAN, INNER, 1), // none: now
        (0.5, 0.5, 8),        // much later
        (9.0, 1.0, 16),       // after the step, which ends as it would have
        (f64::INFINITY, 1.0, 16),
    ];
    for (asked, end, updates) in cases {
        let script: Script = Box::new(move |_, update| update.early.then_some(asked));
        let host = Host::with(Some(script), &[], TRUE).unwrap();
        assert_eq!(host.step(0.0, 1.0), (Ok, (end < 1.0).into(), end), "{asked}");
        assert_eq!(host.updates().len(), updates, "{asked}");
        let exact = crate::answer(1.0, end);
        assert!((get(host.0, "output").unwrap() - exact).abs() < 1e-14);
        // It goes on from there.
        assert_eq!(host.step(end, 0.01).0, Ok);
    }
}

#[test]
fn no_step_ends_early_unless_the_host_has_allowed_it() {
    let script: Script = Box::new(|_, update| Some(update.time));
    let host = Host::with(Some(script), &[], FALSE).unwrap();
    assert_eq!(host.step(0.0, 1.0), (Ok, FALSE, 1.0));
    assert!(host.updates().iter().all(|update| !update.early));
}

#[test]
fn a_watched_step_that_is_discarded_can_be_tried_again() {
    let host = Host::with(silent(), &[], FALSE).unwrap();
    let before = get(host.0, "output");
    assert_eq!(trouble(host.0, 2), Ok);
    assert_eq!(host.step(0.0, 1.0), (Discard, FALSE, 0.0));
    assert!(host.said().contains("the lag discards this step"));
    assert_eq!(get(host.0, "output"), before);
    assert_eq!(trouble(host.0, 1), Ok);
    assert_eq!(host.step(0.0, 1.0), (Ok, FALSE, 1.0));
}

#[test]
fn a_tiny_inner_step_does_not_make_endless_updates() {
    let host = Host::with(silent(), &[], FALSE).unwrap();
    assert_eq!(host.step(0.0, 1e4), (Ok, FALSE, 1e4));
    assert!((999..=1001).contains(&host.updates().len()));
}

#[test]
fn variables_that_cannot_be_accessed_are_refused_at_once() {
    for (name, why) in [
        ("gain", "gain cannot be accessed in intermediate update mode: it has no intermediateUpdate"),
        ("steps", "steps cannot be accessed"),
    ] {
        let refused = Host::with(silent(), &[vr("input"), vr(name)], TRUE).err().unwrap();
        assert!(refused.contains(why), "{refused}");
    }
    let refused = Host::with(silent(), &[999], TRUE).err().unwrap();
    assert!(refused.contains("no variable has the value reference 999"));
    // Without a callback nobody asks.
    assert!(Host::with(None, &[999], TRUE).is_ok());
}
