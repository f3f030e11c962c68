//! The functions of FMI 3.0, generic over the model. [`export!`](crate::export) gives them their C names.
//!
//! # Safety
//! The functions take what a C host passes, and rely on this: an instance is NULL or points to at least eight readable
//! bytes, and was not freed; a pointer with a count points to that many values; strings end with NUL; a saved state is
//! NULL or was not freed. NULL in place of a value, foreign handles and calls at the wrong time are refused.
#![allow(clippy::missing_safety_doc)] // said above for all functions
#![allow(clippy::too_many_arguments)] // as many as the standard says

mod absent;
mod access;
mod exchange;
mod states;

use std::panic::{AssertUnwindSafe, catch_unwind};

use super::types::{
    Boolean, Component, ComponentEnvironment, FALSE, LogMessageCallback, Real, Status, Text,
    Unused, ValueReference,
};
use super::{description, functions};
use crate::boundary::guard::{Handle, enter};
use crate::boundary::instance::{Instance, Request};
use crate::boundary::logger::{Callback, Logger};
use crate::boundary::phase::Phase;
use crate::boundary::raw::{lossy, place, texts};
use crate::boundary::refusal::{Outcome, Refusal};
use crate::boundary::version::Version;
use crate::model::{Model, offered};

use absent::NO_CLOCKS;

pub use absent::*;
pub use access::*;
pub use exchange::*;
pub use states::*;

/// `fmi3InstantiateCoSimulation`. There are no intermediate updates, so it does not matter which variables the host would
/// want then, nor whether it allows early returns.
pub unsafe fn instantiate_co_simulation<M: Model>(
    name: Text,
    token: Text,
    resources: Text,
    _visible: Boolean,
    logging: Boolean,
    event_mode: Boolean,
    _early_return: Boolean,
    _intermediate: *const ValueReference,
    _n_intermediate: usize,
    environment: ComponentEnvironment,
    log: Option<LogMessageCallback>,
    _update: Unused,
) -> Component {
    const FUNCTION: &str = "fmi3InstantiateCoSimulation";
    let check = || {
        if event_mode == FALSE {
            return Ok(description::fingerprint::<M>());
        }
        Err(Refusal::Argument {
            name: "eventModeUsed",
            value: "fmi3True".to_owned(),
            why: "this FMU has no event mode",
        })
    };
    let logger = || Logger::new(log.map(Callback::Three), environment, logging != FALSE);
    // SAFETY: as the host vouches.
    unsafe { instantiate::<M>(FUNCTION, [name, token, resources], false, logger, check) }
}

/// `fmi3InstantiateModelExchange`.
pub unsafe fn instantiate_model_exchange<M: Model>(
    name: Text,
    token: Text,
    resources: Text,
    _visible: Boolean,
    logging: Boolean,
    environment: ComponentEnvironment,
    log: Option<LogMessageCallback>,
) -> Component {
    const FUNCTION: &str = "fmi3InstantiateModelExchange";
    let check = || match offered::<M>() {
        Some(_) => Ok(description::exchange_fingerprint::<M>()),
        None => Err(Refusal::Absent("this FMU supports Co-Simulation only")),
    };
    let logger = || Logger::new(log.map(Callback::Three), environment, logging != FALSE);
    // SAFETY: as the host vouches.
    unsafe { instantiate::<M>(FUNCTION, [name, token, resources], true, logger, check) }
}

/// `fmi3InstantiateScheduledExecution`: refused.
pub unsafe fn instantiate_scheduled_execution<M: Model>(
    name: Text,
    token: Text,
    resources: Text,
    _visible: Boolean,
    logging: Boolean,
    environment: ComponentEnvironment,
    log: Option<LogMessageCallback>,
    _update: Unused,
    _lock: Unused,
    _unlock: Unused,
) -> Component {
    const FUNCTION: &str = "fmi3InstantiateScheduledExecution";
    let check = || Err(Refusal::Absent(NO_CLOCKS));
    let logger = || Logger::new(log.map(Callback::Three), environment, logging != FALSE);
    // SAFETY: as the host vouches.
    unsafe { instantiate::<M>(FUNCTION, [name, token, resources], false, logger, check) }
}

/// Makes an instance, if `check` knows the fingerprint of its description.
unsafe fn instantiate<M: Model>(
    function: &'static str,
    texts: [Text; 3],
    exchange: bool,
    logger: impl FnOnce() -> Logger,
    check: impl FnOnce() -> Outcome<u128>,
) -> Component {
    let make = || {
        let logger = logger();
        let fingerprint = check()
            .map_err(|refusal| logger.refuse(function, &refusal))
            .ok()?;
        // SAFETY: as the host vouches. Some hosts write names and paths in their system's code page, not in UTF-8.
        let [name, token, resources] = texts.map(|text| unsafe { lossy(text) });
        let request = Request {
            function,
            version: Version::Three,
            name: name.as_deref().unwrap_or_default(),
            token: ("instantiationToken", token.as_deref().unwrap_or_default()),
            expected: &description::token(fingerprint),
            fingerprint,
            exchange,
            resources: resources.as_deref(),
        };
        Instance::<M>::new(&request, logger).map(Handle::give)
    };
    catch_unwind(AssertUnwindSafe(make))
        .ok()
        .flatten()
        .unwrap_or(std::ptr::null_mut())
}

/// `fmi3FreeInstance`.
pub unsafe fn free_instance<M: Model>(component: Component) {
    // SAFETY: as the host vouches.
    unsafe { Handle::<M>::end(component, Version::Three) }
}

/// `fmi3SetDebugLogging`.
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

/// `fmi3EnterInitializationMode`.
pub unsafe fn enter_initialization_mode<M: Model>(
    component: Component,
    tolerance_defined: Boolean,
    tolerance: Real,
    start: Real,
    stop_defined: Boolean,
    stop: Real,
) -> Status {
    let tolerance = (tolerance_defined != FALSE).then_some(tolerance);
    let stop = (stop_defined != FALSE).then_some(stop);
    let body = |instance: &mut Instance<M>| {
        instance.setup(tolerance, start, stop)?;
        instance.enter_initialization()
    };
    // SAFETY: as the host vouches.
    unsafe { enter(component, &functions::ENTER_INITIALIZATION, body) }
}

/// Defines functions that take nothing but the instance.
macro_rules! plain {
    ($($(#[$doc:meta])* $name:ident = $function:ident, $method:ident;)*) => {$(
        $(#[$doc])*
        pub unsafe fn $name<M: Model>(component: Component) -> Status {
            // SAFETY: as the host vouches.
            unsafe { enter(component, &functions::$function, Instance::<M>::$method) }
        }
    )*};
}

plain! {
    /// `fmi3ExitInitializationMode`.
    exit_initialization_mode = EXIT_INITIALIZATION, exit_initialization;
    /// `fmi3Terminate`.
    terminate = TERMINATE, terminate;
    /// `fmi3Reset`.
    reset = RESET, reset;
}

/// `fmi3DoStep`. After a discarded step the instance is where it was, in step mode: the host may try a shorter one.
pub unsafe fn do_step<M: Model>(
    component: Component,
    from: Real,
    step: Real,
    _no_set_state_prior: Boolean,
    event_handling_needed: *mut Boolean,
    terminate_simulation: *mut Boolean,
    early_return: *mut Boolean,
    last_successful_time: *mut Real,
) -> Status {
    let body = |instance: &mut Instance<M>| {
        // SAFETY: as the host vouches.
        let (flags, reached) = unsafe {
            (
                [
                    place(event_handling_needed, "eventHandlingNeeded")?,
                    place(terminate_simulation, "terminateSimulation")?,
                    place(early_return, "earlyReturn")?,
                ],
                place(last_successful_time, "lastSuccessfulTime")?,
            )
        };
        for flag in flags {
            *flag = FALSE;
        }
        let outcome = instance.step(from, step);
        *reached = instance.run.time;
        if instance.run.phase == Phase::StepFailed {
            instance.run.phase = Phase::StepComplete;
        }
        outcome
    };
    // SAFETY: as the host vouches.
    unsafe { enter(component, &functions::DO_STEP, body) }
}
