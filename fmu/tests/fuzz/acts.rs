//! The host's next action: a call of one of the standard's functions, with valid or invalid arguments.

use std::ffi::c_int;
use std::ptr::{null, null_mut};

use fmu_export::fmi2::types::*;
use fmu_export::model::Model;
use plain_bearing_stand::c_functions::*;
use plain_bearing_stand::stand::Stand;

use crate::host::Host;
use crate::states;
use crate::values::*;

/// The most instances and saved states at once.
pub const MOST: usize = 4;

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
            host.free()
        }
    }),
    (20, step),
    (20, get_real),
    (4, get_integer),
    (4, get_boolean),
    (4, get_string),
    (14, set_real),
    (4, set_integer),
    (3, set_boolean),
    (3, set_string),
    (6, set_slopes),
    (4, get_rates),
    (2, directional),
    (12, states::act),
    (8, status),
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
    experiment(host, component);
    small_film(host, component);
    // SAFETY of both: an instance that is alive, NULL, or readable memory.
    host.call("fmi2EnterInitializationMode", component, |c| {
        // SAFETY: as said above.
        unsafe { fmi2EnterInitializationMode(c) }
    });
    if host.random.once_in(5) {
        return; // where it may still be configured
    }
    host.call("fmi2ExitInitializationMode", component, |c| {
        // SAFETY: as said above.
        unsafe { fmi2ExitInitializationMode(c) }
    });
}

/// Brings an instance from one phase to another, in turn or not.
fn life(host: &mut Host, component: Component) {
    type Plain = unsafe extern "C" fn(Component) -> Status;
    let (name, function): (_, Plain) = match host.random.below(8) {
        0 => ("fmi2EnterInitializationMode", fmi2EnterInitializationMode),
        1 | 2 => ("fmi2ExitInitializationMode", fmi2ExitInitializationMode),
        3 => ("fmi2Terminate", fmi2Terminate),
        4 => ("fmi2CancelStep", fmi2CancelStep),
        5 => return start(host, component),
        _ => ("fmi2Reset", fmi2Reset),
    };
    // SAFETY: as for `start`.
    host.call(name, component, |c| unsafe { function(c) });
    if name == "fmi2Reset" {
        host.forged.remove(&component);
        small_film(host, component);
        start(host, component);
    }
}

/// A Reynolds film of few cells, so that ten million calls end some day.
fn small_film(host: &mut Host, component: Component) {
    let references = ["bearing.filmColumns", "bearing.filmRows"].map(reference_of);
    let values = [16, 2];
    // SAFETY: two references, two values.
    host.call("fmi2SetInteger", component, |c| unsafe {
        fmi2SetInteger(c, references.as_ptr(), 2, values.as_ptr())
    });
}

fn reference_of(name: &str) -> ValueReference {
    let index = Stand::variables().iter().position(|v| v.name == name);
    index
        .and_then(|index| index.try_into().ok())
        .unwrap_or(ValueReference::MAX)
}

fn experiment(host: &mut Host, component: Component) {
    let random = &mut host.random;
    let fair = !random.once_in(20);
    let (with_tolerance, with_stop) = (random.below(2) as i32, i32::from(random.once_in(10)));
    let (tolerance, start, stop) = if fair {
        (
            random.magnitude(1e-6, 1e-3),
            random.one(&[0.0, 0.0, -5.0, 1e3]),
            2e3,
        )
    } else {
        (random.hostile(), random.hostile(), random.hostile())
    };
    // SAFETY: as for `start`.
    host.call("fmi2SetupExperiment", component, |c| unsafe {
        fmi2SetupExperiment(c, with_tolerance, tolerance, start, with_stop, stop)
    });
}

fn step(host: &mut Host, component: Component) {
    let mut time = 0.0;
    // SAFETY of both: as for `start`; the place is ours.
    host.call("fmi2GetRealStatus", component, |c| {
        // SAFETY: as said above.
        unsafe { fmi2GetRealStatus(c, LAST_SUCCESSFUL_TIME, &raw mut time) }
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
    let prior = random.integer();
    host.call("fmi2DoStep", component, |c| {
        // SAFETY: as said above.
        unsafe { fmi2DoStep(c, from, step, prior) }
    });
}

fn status(host: &mut Host, component: Component) {
    let kind: c_int = host.random.one(&[0, 1, 2, 3, 4, -1]);
    let missing = host.random.once_in(10);
    let (mut ended, mut real, mut integer, mut text) = (Status::Ok, 0.0, 0, null());
    // SAFETY of all: as for `start`; the places are ours, or NULL.
    match host.random.below(5) {
        0 => host.call("fmi2GetStatus", component, |c| {
            // SAFETY: as said above.
            unsafe { fmi2GetStatus(c, kind, hidden(&mut ended, missing)) }
        }),
        1 => host.call("fmi2GetRealStatus", component, |c| {
            // SAFETY: as said above.
            unsafe { fmi2GetRealStatus(c, kind, hidden(&mut real, missing)) }
        }),
        2 => host.call("fmi2GetIntegerStatus", component, |c| {
            // SAFETY: as said above.
            unsafe { fmi2GetIntegerStatus(c, kind, hidden(&mut integer, missing)) }
        }),
        3 => host.call("fmi2GetBooleanStatus", component, |c| {
            // SAFETY: as said above.
            unsafe { fmi2GetBooleanStatus(c, kind, hidden(&mut integer, missing)) }
        }),
        _ => host.call("fmi2GetStringStatus", component, |c| {
            // SAFETY: as said above.
            unsafe { fmi2GetStringStatus(c, kind, hidden(&mut text, missing)) }
        }),
    };
    assert!(real.is_finite());
}

/// A place, or NULL.
fn hidden<T>(place: &mut T, missing: bool) -> *mut T {
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
    let n = host.random.below(3);
    let on = host.random.integer();
    // SAFETY: up to two texts that end with NUL.
    host.call("fmi2SetDebugLogging", component, |c| unsafe {
        fmi2SetDebugLogging(c, on, n, chosen.as_ptr())
    });
}
