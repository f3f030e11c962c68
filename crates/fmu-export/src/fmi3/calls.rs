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
    Boolean, Component, ComponentEnvironment, FALSE, IntermediateUpdateCallback,
    LogMessageCallback, Real, Status, Text, Unused, ValueReference,
};
use super::{description, functions};
use crate::boundary::calls::plain;
use crate::boundary::guard::{Handle, enter};
use crate::boundary::instance::{Instance, Request};
use crate::boundary::logger::{Callback, Logger};
use crate::boundary::phase::Phase;
use crate::boundary::raw::{lossy, place, texts, values};
use crate::boundary::refusal::{Outcome, Refusal};
use crate::boundary::version::Version;
use crate::boundary::watch::Watch;
use crate::model::{Model, offered};

use absent::NO_CLOCKS;

pub use absent::*;
pub use access::*;
pub use exchange::*;
pub use states::*;

/// `fmi3InstantiateCoSimulation`. Without a callback for intermediate updates, or for a model without inner steps, it does not
/// matter which variables the host would want then, nor whether it allows early returns.
pub unsafe fn instantiate_co_simulation<M: Model>(
    name: Text,
    token: Text,
    resources: Text,
    _visible: Boolean,
    logging: Boolean,
    event_mode: Boolean,
    early_return: Boolean,
    intermediate: *const ValueReference,
    n_intermediate: usize,
    environment: ComponentEnvironment,
    log: Option<LogMessageCallback>,
    update: Option<IntermediateUpdateCallback>,
) -> Component {
    const FUNCTION: &str = "fmi3InstantiateCoSimulation";
    let check = || {
        if event_mode != FALSE {
            return Err(Refusal::Argument {
                name: "eventModeUsed",
                value: "fmi3True".to_owned(),
                why: "this FMU has no event mode",
            });
        }
        let (Some(update), Some(inner_step)) = (update, M::INNER_STEP) else {
            return Ok((description::fingerprint::<M>(), None));
        };
        let name = "requiredIntermediateVariables";
        // SAFETY: as the host vouches.
        let variables = unsafe { values(intermediate, n_intermediate, name) }?;
        let early = early_return != FALSE;
        let watch = Watch::new(update, environment, early, variables, inner_step)?;
        Ok((description::fingerprint::<M>(), Some(watch)))
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
        Some(_) => Ok((description::exchange_fingerprint::<M>(), None)),
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

/// Makes an instance, if `check` knows the fingerprint of its description and how the host looks into steps.
unsafe fn instantiate<M: Model>(
    function: &'static str,
    texts: [Text; 3],
    exchange: bool,
    logger: impl FnOnce() -> Logger,
    check: impl FnOnce() -> Outcome<(u128, Option<Watch<M>>)>,
) -> Component {
    let make = || {
        let logger = logger();
        let (fingerprint, watch) = check()
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
        let mut instance = Instance::<M>::new(&request, logger)?;
        instance.watch = watch;
        Some(Handle::give(instance))
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

plain! {
    /// `fmi3ExitInitializationMode`.
    exit_initialization_mode = EXIT_INITIALIZATION, exit_initialization;
    /// `fmi3Terminate`.
    terminate = TERMINATE, terminate;
    /// `fmi3Reset`.
    reset = RESET, reset;
}

/// `fmi3DoStep`. After a discarded step the instance is where it was, in step mode: the host may try a shorter one. A host that
/// looks into the step is called while the instance is free for it.
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
    let (mut answer, mut pause) = (None, None);
    loop {
        let body = |instance: &mut Instance<M>| {
            // SAFETY: as the host vouches.
            let (flags, early, reached) = unsafe {
                (
                    [
                        place(event_handling_needed, "eventHandlingNeeded")?,
                        place(terminate_simulation, "terminateSimulation")?,
                    ],
                    place(early_return, "earlyReturn")?,
                    place(last_successful_time, "lastSuccessfulTime")?,
                )
            };
            let outcome = match answer {
                None => instance.begin_step(from, step, &mut pause),
                Some(answer) => instance.go_on(answer, &mut pause),
            };
            for flag in flags {
                *flag = FALSE;
            }
            *early = (outcome.is_ok() && instance.run.time < from + step).into();
            *reached = instance.run.time;
            if instance.run.phase == Phase::StepFailed {
                instance.run.phase = Phase::StepComplete;
            }
            outcome
        };
        let function = match answer {
            None => &functions::DO_STEP,
            Some(_) => &functions::GO_ON,
        };
        // SAFETY: as the host vouches; it cannot free the instance in its callback.
        let status = unsafe { enter(component, function, body) };
        match pause.take() {
            None => return status,
            Some(update) => answer = Some(update.ask()),
        }
    }
}
