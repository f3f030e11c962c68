//! Model Exchange.

use crate::boundary::calls::{integration, plain, vectors};
use crate::boundary::guard::enter;
use crate::boundary::instance::Instance;
use crate::boundary::raw::{place, values, values_mut};
use crate::fmi3::functions;
use crate::fmi3::types::{Boolean, Component, FALSE, Real, Status};
use crate::model::Model;

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

plain! {
    /// `fmi3EnterEventMode`.
    enter_event_mode = ENTER_EVENT_MODE, enter_event;
    /// `fmi3EnterContinuousTimeMode`.
    enter_continuous_time_mode = ENTER_CONTINUOUS_TIME, enter_continuous;
}

integration! {
    /// `fmi3SetTime`.
    set_time;
    /// `fmi3CompletedIntegratorStep`. A completed step changes nothing.
    completed_integrator_step;
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
