//! Model Exchange.

use crate::boundary::guard::enter;
use crate::boundary::instance::Instance;
use crate::boundary::raw::{place, values, values_mut};
use crate::fmi2::functions;
use crate::fmi2::types::{Boolean, Component, EventInfo, FALSE, Real, Status};
use crate::model::Model;

/// Defines functions that take or give a number for each state.
macro_rules! vectors {
    ($($(#[$doc:meta])* $name:ident = $function:ident, $method:ident($pointer:ty, $slice:ident);)*) => {$(
        $(#[$doc])*
        pub unsafe fn $name<M: Model>(component: Component, value: $pointer, n: usize) -> Status {
            let body = |instance: &mut Instance<M>| {
                // SAFETY: as the host vouches.
                let value = unsafe { $slice(value, n, "values") }?;
                instance.$method(value)
            };
            // SAFETY: as the host vouches.
            unsafe { enter(component, &functions::$function, body) }
        }
    )*};
}

vectors! {
    /// `fmi2SetContinuousStates`.
    set_continuous_states = SET_STATES, set_states(*const Real, values);
    /// `fmi2GetDerivatives`.
    get_derivatives = GET_RATES, get_rates(*mut Real, values_mut);
    /// `fmi2GetContinuousStates`.
    get_continuous_states = GET_STATES, get_states(*mut Real, values_mut);
    /// `fmi2GetNominalsOfContinuousStates`.
    get_nominals_of_continuous_states = GET_NOMINALS, get_nominals(*mut Real, values_mut);
    /// `fmi2GetEventIndicators`: there are none.
    get_event_indicators = GET_INDICATORS, get_indicators(*mut Real, values_mut);
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
    /// `fmi2EnterEventMode`.
    enter_event_mode = ENTER_EVENT_MODE, enter_event;
    /// `fmi2EnterContinuousTimeMode`.
    enter_continuous_time_mode = ENTER_CONTINUOUS_TIME, enter_continuous;
}

/// `fmi2SetTime`.
pub unsafe fn set_time<M: Model>(component: Component, time: Real) -> Status {
    let body = |instance: &mut Instance<M>| instance.set_time(time);
    // SAFETY: as the host vouches.
    unsafe { enter(component, &functions::SET_TIME, body) }
}

/// `fmi2CompletedIntegratorStep`. A completed step changes nothing.
pub unsafe fn completed_integrator_step<M: Model>(
    component: Component,
    _no_set_state_prior: Boolean,
    enter_event_mode: *mut Boolean,
    terminate: *mut Boolean,
) -> Status {
    let body = |_: &mut Instance<M>| {
        // SAFETY: as the host vouches.
        let flags = unsafe {
            [
                place(enter_event_mode, "enterEventMode")?,
                place(terminate, "terminateSimulation")?,
            ]
        };
        for flag in flags {
            *flag = FALSE;
        }
        Ok(Status::Ok)
    };
    // SAFETY: as the host vouches.
    unsafe { enter(component, &functions::COMPLETED_STEP, body) }
}

/// `fmi2NewDiscreteStates`. Nothing ever happens.
pub unsafe fn new_discrete_states<M: Model>(component: Component, info: *mut EventInfo) -> Status {
    let body = |_: &mut Instance<M>| {
        // SAFETY: as the host vouches.
        *unsafe { place(info, "eventInfo") }? = EventInfo::default();
        Ok(Status::Ok)
    };
    // SAFETY: as the host vouches.
    unsafe { enter(component, &functions::NEW_DISCRETE_STATES, body) }
}
