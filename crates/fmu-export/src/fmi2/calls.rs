//! The functions of FMI 2.0, generic over the model. [`export!`](crate::export)
//! gives them their C names.
//!
//! # Safety
//! The functions take what a C host passes, and rely on this: a component is NULL or points to at least eight readable
//! bytes, and was not freed; a pointer with a count points to that many values; strings end with NUL; a saved state is
//! NULL or was not freed. NULL in place of a value, foreign handles and calls at the wrong time are refused.
#![allow(clippy::missing_safety_doc)] // said above for all functions

mod access;
mod exchange;
mod states;
mod status;

use std::ffi::c_int;
use std::panic::{AssertUnwindSafe, catch_unwind};

use super::description;
use super::functions;
use super::types::{
    Boolean, CO_SIMULATION, CallbackFunctions, Component, FALSE, MODEL_EXCHANGE, Real, Status, Text,
};
use crate::boundary::calls::plain;
use crate::boundary::guard::{Handle, enter};
use crate::boundary::instance::{Instance, Request};
use crate::boundary::logger::{Callback, Logger, c_string};
use crate::boundary::raw::{lossy, texts, values};
use crate::boundary::refusal::Refusal;
use crate::boundary::version::Version;
use crate::model::{Model, offered};

pub use access::*;
pub use exchange::*;
pub use states::*;
pub use status::*;

/// `fmi2Instantiate`.
pub unsafe fn instantiate<M: Model>(
    name: Text,
    kind: c_int,
    guid: Text,
    resources: Text,
    callbacks: *const CallbackFunctions,
    _visible: Boolean,
    logging: Boolean,
) -> Component {
    let make = || {
        // SAFETY: as the host vouches. The struct is copied, as hosts may keep it on their stack.
        let callbacks = unsafe { values(callbacks, 1, "functions") }.ok()?[0];
        // SAFETY: as the host vouches. Some hosts write names and paths in their system's code page, not in UTF-8.
        let [name, guid, resources] = unsafe { [lossy(name), lossy(guid), lossy(resources)] };
        let name = name.as_deref().unwrap_or_default();
        let callback = (callbacks.logger).map(|logger| Callback::Two(logger, c_string(name)));
        let logger = Logger::new(callback, callbacks.component_environment, logging != FALSE);
        let fingerprint = match (kind, offered::<M>()) {
            (CO_SIMULATION, _) => description::fingerprint::<M>(),
            (MODEL_EXCHANGE, Some(_)) => description::exchange_fingerprint::<M>(),
            (_, offered) => {
                let refusal = Refusal::Argument {
                    name: "fmuType",
                    value: kind.to_string(),
                    why: match offered {
                        Some(_) => "it must be Model Exchange (0) or Co-Simulation (1)",
                        None => "this FMU supports Co-Simulation (1) only",
                    },
                };
                logger.refuse("fmi2Instantiate", &refusal);
                return None;
            }
        };
        let request = Request {
            function: "fmi2Instantiate",
            version: Version::Two,
            name,
            token: ("fmuGUID", guid.as_deref().unwrap_or_default()),
            expected: &description::guid(fingerprint),
            fingerprint,
            exchange: kind == MODEL_EXCHANGE,
            resources: resources.as_deref(),
        };
        Instance::<M>::new(&request, logger).map(Handle::give)
    };
    catch_unwind(AssertUnwindSafe(make))
        .ok()
        .flatten()
        .unwrap_or(std::ptr::null_mut())
}

/// `fmi2FreeInstance`.
pub unsafe fn free_instance<M: Model>(component: Component) {
    // SAFETY: as the host vouches.
    unsafe { Handle::<M>::end(component, Version::Two) }
}

/// `fmi2SetDebugLogging`.
pub unsafe fn set_debug_logging<M: Model>(
    component: Component,
    on: Boolean,
    n: usize,
    categories: *const Text,
) -> Status {
    let body = |instance: &mut Instance<M>| {
        // SAFETY: as the host vouches.
        let categories = unsafe { texts(categories, n, "categories") }?;
        instance.set_logging(on != FALSE, &categories)
    };
    // SAFETY: as the host vouches.
    unsafe { enter(component, &functions::SET_DEBUG_LOGGING, body) }
}

/// `fmi2SetupExperiment`.
pub unsafe fn setup_experiment<M: Model>(
    component: Component,
    tolerance_defined: Boolean,
    tolerance: Real,
    start: Real,
    stop_defined: Boolean,
    stop: Real,
) -> Status {
    let tolerance = (tolerance_defined != FALSE).then_some(tolerance);
    let stop = (stop_defined != FALSE).then_some(stop);
    let body = |instance: &mut Instance<M>| instance.setup(tolerance, start, stop);
    // SAFETY: as the host vouches.
    unsafe { enter(component, &functions::SETUP_EXPERIMENT, body) }
}

plain! {
    /// `fmi2EnterInitializationMode`.
    enter_initialization_mode = ENTER_INITIALIZATION, enter_initialization;
    /// `fmi2ExitInitializationMode`.
    exit_initialization_mode = EXIT_INITIALIZATION, exit_initialization;
    /// `fmi2Terminate`.
    terminate = TERMINATE, terminate;
    /// `fmi2Reset`.
    reset = RESET, reset;
}

/// `fmi2DoStep`. Saved states are copies, so that it does not matter whether the host goes back to an earlier one.
pub unsafe fn do_step<M: Model>(
    component: Component,
    from: Real,
    step: Real,
    _no_set_state_prior: Boolean,
) -> Status {
    // SAFETY: as the host vouches.
    unsafe {
        enter(
            component,
            &functions::DO_STEP,
            |instance: &mut Instance<M>| instance.step(from, step),
        )
    }
}

/// `fmi2CancelStep`. Steps are synchronous, so there is none to cancel: it is refused in every phase.
pub unsafe fn cancel_step<M: Model>(component: Component) -> Status {
    // SAFETY: as the host vouches.
    unsafe {
        enter(component, &functions::CANCEL_STEP, |_: &mut Instance<M>| {
            Ok(Status::Ok)
        })
    }
}
