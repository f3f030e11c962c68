//! Model Exchange: the host integrates, in turn or not. For instances of Co-Simulation all of it is refused.

use std::ptr::{null, null_mut};

use fmu_export::fmi3::types::{Component, Status};

use crate::host::{Host, Named, Plain};
use crate::values::watched;

type Read = unsafe extern "C" fn(Component, *mut f64, usize) -> Status;

/// How a call ended, and the flags that it gave.
pub type Told = (Status, Vec<bool>);

/// The functions for Model Exchange, with their names in a version of the standard.
pub struct Functions {
    pub enter_event: Named<Plain>,
    pub enter_continuous: Named<Plain>,
    pub set_time: Named<unsafe extern "C" fn(Component, f64) -> Status>,
    pub set_states: Named<unsafe extern "C" fn(Component, *const f64, usize) -> Status>,
    pub get_states: Named<Read>,
    pub get_rates: Named<Read>,
    pub get_nominals: Named<Read>,
    pub get_indicators: Named<Read>,
    /// Ends a step of the solver or, if told so, updates the discrete states. One of the places is NULL, if its number is
    /// given. Returns the flags.
    pub tell: fn(&mut Host, Component, discrete: bool, missing: usize) -> Told,
    /// Counts states and event indicators, where this version has functions for it.
    pub count: Option<[Named<unsafe extern "C" fn(Component, *mut usize) -> Status>; 2]>,
}

/// The number of the stand's states.
const STATES: usize = 8;

/// Does something that only Model Exchange has.
pub fn act(host: &mut Host, component: Component) {
    let functions = &host.interface.exchange;
    match host.random.below(12) {
        0 => {
            host.plainly(functions.enter_event, component);
        }
        1 => go_on(host, component),
        2 => {
            let time = host.random.hostile();
            set_time(host, component, time);
        }
        3 => {
            let states = [(); STATES].map(|()| host.random.hostile());
            set_states(host, component, &states);
        }
        4 => {
            let missing = host.random.below(6);
            tell(host, component, false, missing);
        }
        5 => {
            let missing = host.random.below(12);
            tell(host, component, true, missing);
        }
        6 => read(host, component, functions.get_nominals, STATES),
        7 => read(host, component, functions.get_indicators, 0),
        8 => count(host, component),
        _ => integrate(host, component),
    }
}

/// From event mode to continuous time.
pub fn go_on(host: &mut Host, component: Component) {
    tell(host, component, true, usize::MAX);
    host.plainly(host.interface.exchange.enter_continuous, component);
}

/// Functions for Model Exchange only are refused by the other instances.
fn check(host: &Host, component: Component, name: &str, status: Status) {
    let refused = status == Status::Error || host.exchange.contains(&component);
    assert!(refused, "{name} of an instance for Co-Simulation");
}

/// Ends a step or updates discrete states: a step may ask for the event mode, where it passes a limit of the model, and nothing
/// else ever happens.
fn tell(host: &mut Host, component: Component, discrete: bool, missing: usize) {
    let (status, flags) = (host.interface.exchange.tell)(host, component, discrete, missing);
    check(host, component, "telling", status);
    let never = if discrete { &flags[..] } else { &flags[1..] };
    assert!(status != Status::Ok || !never.contains(&true));
}

fn set_time(host: &mut Host, component: Component, time: f64) {
    let (name, function) = host.interface.exchange.set_time;
    // SAFETY: an instance that is alive, NULL, or readable memory.
    let status = watched(host, component, name, |c| unsafe { function(c, time) });
    check(host, component, name, status);
    assert!(status != Status::Ok || time.is_finite());
}

fn set_states(host: &mut Host, component: Component, states: &[f64]) {
    let (name, function) = host.interface.exchange.set_states;
    let (states, n) = match host.random.below(40) {
        0 => (null(), states.len()),
        1 => (states.as_ptr(), states.len() - 1),
        2 => (states.as_ptr(), usize::MAX),
        3 => (null(), 0),
        _ => (states.as_ptr(), states.len()),
    };
    // SAFETY: right, NULL, or a count that is refused before it is used.
    let status = watched(host, component, name, |c| unsafe { function(c, states, n) });
    check(host, component, name, status);
    assert!(status != Status::Ok || n == STATES);
}

/// Reads a number for each state, or for each event indicator.
fn read(host: &mut Host, component: Component, of: Named<Read>, n: usize) {
    let mut values = [f64::NAN; STATES];
    let (place, n) = match host.random.below(40) {
        0 => (null_mut(), n),
        1 => (values.as_mut_ptr(), host.random.below(STATES)),
        2 => (values.as_mut_ptr(), usize::MAX),
        _ => (values.as_mut_ptr(), n),
    };
    // SAFETY: right, NULL, or a count that is refused before it is used.
    let status = host.call(of.0, component, |c| unsafe { of.1(c, place, n) });
    check(host, component, of.0, status);
    if status == Status::Ok && !host.forged.contains(&component) {
        let values = &values[..n];
        let finite = values.iter().all(|value| value.is_finite());
        assert!(finite, "{} {values:?}", of.0);
    }
}

fn count(host: &mut Host, component: Component) {
    let Some(functions) = host.interface.exchange.count else {
        return;
    };
    for ((name, function), expected) in functions.into_iter().zip([STATES, 0]) {
        let mut n = usize::MAX;
        let missing = host.random.once_in(20);
        let place = if missing { null_mut() } else { &raw mut n };
        // SAFETY: the place is ours, or NULL.
        let status = host.call(name, component, |c| unsafe { function(c, place) });
        check(host, component, name, status);
        assert!(status != Status::Ok || n == expected);
    }
}

/// A step of the explicit Euler method, as hosts of Model Exchange take it, or a far too long one.
fn integrate(host: &mut Host, component: Component) {
    let Functions { get_states: (states, get_states), get_rates: (rates, get_rates), .. } = host.interface.exchange;
    let mut x = [0.0; STATES];
    let mut dx = [0.0; STATES];
    // SAFETY of both: as many places as states.
    let status = host.call(states, component, |c| {
        // SAFETY: as said above.
        unsafe { get_states(c, x.as_mut_ptr(), STATES) }
    });
    check(host, component, states, status);
    let status = host.call(rates, component, |c| {
        // SAFETY: as said above.
        unsafe { get_rates(c, dx.as_mut_ptr(), STATES) }
    });
    check(host, component, rates, status);
    if status == Status::Ok && !host.forged.contains(&component) {
        let finite = x.iter().chain(&dx).all(|value| value.is_finite());
        assert!(finite, "at {x:?} the rates are {dx:?}");
    }
    let random = &mut host.random;
    let step = if random.once_in(10) { random.magnitude(1e-9, 1e9) } else { random.magnitude(1e-9, 1e-5) };
    for (x, dx) in x.iter_mut().zip(dx) {
        *x += step * dx;
    }
    set_time(host, component, step);
    set_states(host, component, &x);
    tell(host, component, false, usize::MAX);
}
