//! The host's next action: a call of one of the standard's functions, with valid or invalid arguments.

use std::ptr::null_mut;

use fmu_export::fmi3::types::*;
use fmu_export::model::Model;
use plain_bearing_stand::fmi3_functions::*;
use plain_bearing_stand::stand::Stand;

use crate::host::Host;
use crate::values::*;
use crate::{absent, states};

/// The most instances and saved states at once.
pub const MOST: usize = 4;

/// The value reference of time.
const TIME: ValueReference = i32::MAX as ValueReference;

/// An action of a host with one of its instances.
type Act = fn(&mut Host, Component);

/// The acts, each with how often it comes.
const ACTS: &[(usize, Act)] = &[
    (2, |host, _| {
        if host.instances.len() < MOST {
            host.instantiate();
            start_most(host);
        }
    }),
    (1, |host, _| {
        if host.instances.len() == MOST {
            host.free();
        }
    }),
    (20, step),
    (20, get_float64),
    (4, get_int32),
    (4, get_int64),
    (4, get_boolean),
    (4, get_string),
    (14, set_float64),
    (4, set_int32),
    (4, set_int64),
    (3, set_boolean),
    (3, set_string),
    (4, get_rates),
    (2, directional),
    (1, adjoint),
    (12, states::act),
    (8, absent::act),
    (2, logging),
    (2, life),
];

/// Performs one random action.
pub fn act(host: &mut Host) {
    let sum: usize = ACTS.iter().map(|(weight, _)| weight).sum();
    let mut left = host.random.below(sum);
    for (weight, act) in ACTS {
        if left < *weight {
            let component = component(host);
            return act(host, component);
        }
        left -= weight;
    }
}

/// An instance; now and then NULL or something else.
fn component(host: &mut Host) -> Component {
    if host.instances.is_empty() || host.random.once_in(100) {
        return if host.random.once_in(2) {
            null_mut()
        } else {
            host.foreign()
        };
    }
    let index = host.random.below(host.instances.len());
    host.instances[index]
}

/// Starts the newest instance, mostly.
fn start_most(host: &mut Host) {
    if let Some(component) = host.instances.last().copied()
        && !host.random.once_in(5)
    {
        start(host, component);
    }
}

/// Brings an instance to its first communication point.
fn start(host: &mut Host, component: Component) {
    small_film(host, component);
    enter(host, component);
    if host.random.once_in(5) {
        return; // where it may still be configured
    }
    host.call("fmi3ExitInitializationMode", component, |c| {
        // SAFETY: an instance that is alive, NULL, or readable memory.
        unsafe { fmi3ExitInitializationMode(c) }
    });
}

fn enter(host: &mut Host, component: Component) {
    let random = &mut host.random;
    let (with_tolerance, with_stop) = (random.below(3) as u8, u8::from(random.once_in(10)));
    let (tolerance, start, stop) = if random.once_in(20) {
        (random.hostile(), random.hostile(), random.hostile())
    } else {
        (
            random.magnitude(1e-6, 1e-3),
            random.one(&[0.0, 0.0, -5.0, 1e3]),
            2e3,
        )
    };
    // SAFETY: as for `start`.
    host.call("fmi3EnterInitializationMode", component, |c| unsafe {
        fmi3EnterInitializationMode(c, with_tolerance, tolerance, start, with_stop, stop)
    });
}

/// Brings an instance from one phase to another, in turn or not.
fn life(host: &mut Host, component: Component) {
    type Plain = unsafe extern "C" fn(Component) -> Status;
    let (name, function): (_, Plain) = match host.random.below(8) {
        0 => return enter(host, component),
        1 | 2 => ("fmi3ExitInitializationMode", fmi3ExitInitializationMode),
        3 => ("fmi3Terminate", fmi3Terminate),
        4 | 5 => return start(host, component),
        _ => ("fmi3Reset", fmi3Reset),
    };
    // SAFETY: as for `start`.
    host.call(name, component, |c| unsafe { function(c) });
    if name == "fmi3Reset" {
        host.forged.remove(&component);
        start(host, component);
    }
}

/// A Reynolds film of few cells, so that ten million calls end some day.
fn small_film(host: &mut Host, component: Component) {
    let references = ["bearing.filmColumns", "bearing.filmRows"].map(reference_of);
    let values = [16, 2];
    // SAFETY: two references, two values.
    host.call("fmi3SetInt32", component, |c| unsafe {
        fmi3SetInt32(c, references.as_ptr(), 2, values.as_ptr(), 2)
    });
}

fn reference_of(name: &str) -> ValueReference {
    let index = Stand::variables().iter().position(|v| v.name == name);
    index
        .and_then(|index| index.try_into().ok())
        .unwrap_or(ValueReference::MAX)
}

fn step(host: &mut Host, component: Component) {
    let mut time = 0.0;
    host.call("fmi3GetFloat64", component, |c| {
        // SAFETY: as for `start`; the place is ours.
        unsafe { fmi3GetFloat64(c, &TIME, 1, &raw mut time, 1) }
    });
    let random = &mut host.random;
    let (from, step) = match random.below(20) {
        0 => (random.hostile(), 1e-3),
        1 => (
            time,
            random.one(&[f64::NAN, f64::INFINITY, -1.0, 0.0, 5e-324, 1e-300, 1e-30]),
        ),
        2 => (time, random.one(&[0.1, 1.0 / 60.0, 1e-2])),
        3 if random.once_in(20) => (time, random.one(&[1.0, 10.0, 1e9])),
        _ => (time, random.magnitude(1e-7, 1e-2)),
    };
    let missing = if random.once_in(100) {
        random.below(4)
    } else {
        9
    };
    let (mut event, mut end, mut early, mut reached) = (9, 9, 9, f64::NAN);
    let status = host.call("fmi3DoStep", component, |c| {
        // SAFETY: as for `start`; the places are ours, or NULL.
        unsafe {
            fmi3DoStep(
                c,
                from,
                step,
                TRUE,
                hidden(&mut event, missing == 0),
                hidden(&mut end, missing == 1),
                hidden(&mut early, missing == 2),
                hidden(&mut reached, missing == 3),
            )
        }
    });
    if status == Status::Ok || status == Status::Discard {
        assert_eq!([event, end, early], [FALSE; 3]);
        let expected = if status == Status::Ok {
            from + step
        } else {
            time
        };
        assert!(reached == expected || host.forged.contains(&component));
    }
}

/// A place, or NULL.
pub fn hidden<T>(place: &mut T, missing: bool) -> *mut T {
    if missing { null_mut() } else { place }
}

fn logging(host: &mut Host, component: Component) {
    let names = [
        c"logAll",
        c"logStatusError",
        c"logEvents",
        c"logNothing",
        c"\xff",
    ];
    let chosen = [
        host.random.one(&names).as_ptr(),
        host.random.one(&names).as_ptr(),
    ];
    let (n, on) = (host.random.below(3), host.random.bits() as u8);
    // SAFETY: up to two texts that end with NUL.
    host.call("fmi3SetDebugLogging", component, |c| unsafe {
        fmi3SetDebugLogging(c, on, n, chosen.as_ptr())
    });
}
