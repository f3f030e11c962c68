//! Model Exchange.

use crate::boundary::calls::{integration, plain, vectors};
use crate::boundary::guard::enter;
use crate::boundary::instance::Instance;
use crate::boundary::raw::{place, values, values_mut};
use crate::fmi2::functions;
use crate::fmi2::types::{Boolean, Component, EventInfo, FALSE, Real, Status};
use crate::model::Model;

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

plain! {
    /// `fmi2EnterEventMode`.
    enter_event_mode = ENTER_EVENT_MODE, enter_event;
    /// `fmi2EnterContinuousTimeMode`.
    enter_continuous_time_mode = ENTER_CONTINUOUS_TIME, enter_continuous;
}

integration! {
    /// `fmi2SetTime`.
    set_time;
    /// `fmi2CompletedIntegratorStep`. A completed step changes nothing.
    completed_integrator_step;
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
