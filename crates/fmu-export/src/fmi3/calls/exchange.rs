//! Model Exchange.

use crate::boundary::guard::enter;
use crate::boundary::instance::Instance;
use crate::boundary::raw::{place, values, values_mut};
use crate::fmi3::functions;
use crate::fmi3::types::{Boolean, Component, FALSE, Real, Status};
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
    /// `fmi3SetContinuousStates`.
    set_continuous_states = SET_STATES, set_states(*const Real, values);
    /// `fmi3GetContinuousStateDerivatives`.
    get_continuous_state_derivatives = GET_RATES, get_rates(*mut Real, values_mut);
    /// `fmi3GetContinuousStates`.
    get_continuous_states = GET_STATES, get_states(*mut Real, values_mut);
    /// `fmi3GetNominalsOfContinuousStates`.
    get_nominals_of_continuous_states = GET_NOMINALS, get_nominals(*mut Real, values_mut);
    /// `fmi3GetEventIndicators`: there are none.
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
    /// `fmi3EnterEventMode`.
    enter_event_mode = ENTER_EVENT_MODE, enter_event;
    /// `fmi3EnterContinuousTimeMode`.
    enter_continuous_time_mode = ENTER_CONTINUOUS_TIME, enter_continuous;
}

/// `fmi3SetTime`.
pub unsafe fn set_time<M: Model>(component: Component, time: Real) -> Status {
    let body = |instance: &mut Instance<M>| instance.set_time(time);
    // SAFETY: as the host vouches.
    unsafe { enter(component, &functions::SET_TIME, body) }
}

/// `fmi3CompletedIntegratorStep`. A completed step changes nothing.
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

/// `fmi3UpdateDiscreteStates`. Nothing ever happens.
pub unsafe fn update_discrete_states<M: Model>(
    component: Component,
    again: *mut Boolean,
    terminate: *mut Boolean,
    nominals: *mut Boolean,
    values: *mut Boolean,
    defined: *mut Boolean,
    time: *mut Real,
) -> Status {
    let body = |_: &mut Instance<M>| {
        // SAFETY: as the host vouches.
        let flags = unsafe {
            [
                place(again, "discreteStatesNeedUpdate")?,
                place(terminate, "terminateSimulation")?,
                place(nominals, "nominalsOfContinuousStatesChanged")?,
                place(values, "valuesOfContinuousStatesChanged")?,
                place(defined, "nextEventTimeDefined")?,
            ]
        };
        // SAFETY: as the host vouches.
        *unsafe { place(time, "nextEventTime") }? = 0.0;
        for flag in flags {
            *flag = FALSE;
        }
        Ok(Status::Ok)
    };
    // SAFETY: as the host vouches.
    unsafe { enter(component, &functions::UPDATE_DISCRETE_STATES, body) }
}

/// `fmi3GetNumberOfContinuousStates`.
pub unsafe fn get_number_of_continuous_states<M: Model>(
    component: Component,
    n: *mut usize,
) -> Status {
    let body = |instance: &mut Instance<M>| {
        // SAFETY: as the host vouches.
        *unsafe { place(n, "nContinuousStates") }? = instance.states()?;
        Ok(Status::Ok)
    };
    // SAFETY: as the host vouches.
    unsafe { enter(component, &functions::COUNT_STATES, body) }
}

/// `fmi3GetNumberOfEventIndicators`: there are none.
pub unsafe fn get_number_of_event_indicators<M: Model>(
    component: Component,
    n: *mut usize,
) -> Status {
    let body = |instance: &mut Instance<M>| {
        instance.states()?;
        // SAFETY: as the host vouches.
        *unsafe { place(n, "nEventIndicators") }? = 0;
        Ok(Status::Ok)
    };
    // SAFETY: as the host vouches.
    unsafe { enter(component, &functions::COUNT_INDICATORS, body) }
}
