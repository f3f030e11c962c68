//! The status of a step.

use std::ffi::c_int;

use crate::boundary::guard::enter;
use crate::boundary::instance::Instance;
use crate::boundary::phase::Function;
use crate::boundary::raw::place;
use crate::boundary::refusal::Refusal;
use crate::fmi2::functions;
use crate::fmi2::types::{
    Boolean, Component, DO_STEP_STATUS, FALSE, Integer, LAST_SUCCESSFUL_TIME, Real, Status,
    TERMINATED, Text,
};
use crate::model::Model;

/// Answers one of the `fmi2GetXxxStatus` functions.
unsafe fn answer<M: Model, T>(
    component: Component,
    function: &Function,
    value: *mut T,
    ask: impl FnOnce(&Instance<M>) -> Option<T>,
) -> Status {
    let body = |instance: &mut Instance<M>| {
        // SAFETY: as the host vouches.
        let place = unsafe { place(value, "value") }?;
        *place =
            ask(instance).ok_or(Refusal::Unsupported("this kind of status is not provided"))?;
        Ok(Status::Ok)
    };
    // SAFETY: as the host vouches.
    unsafe { enter(component, function, body) }
}

/// `fmi2GetStatus`: how the last step ended.
pub unsafe fn get_status<M: Model>(
    component: Component,
    kind: c_int,
    value: *mut Status,
) -> Status {
    let ask = |instance: &Instance<M>| (kind == DO_STEP_STATUS).then_some(instance.run.last_step);
    // SAFETY: as the host vouches.
    unsafe { answer(component, &functions::GET_STATUS, value, ask) }
}

/// `fmi2GetRealStatus`: the time that the last successful step has reached.
pub unsafe fn get_real_status<M: Model>(
    component: Component,
    kind: c_int,
    value: *mut Real,
) -> Status {
    let ask = |instance: &Instance<M>| (kind == LAST_SUCCESSFUL_TIME).then_some(instance.run.time);
    // SAFETY: as the host vouches.
    unsafe { answer(component, &functions::GET_REAL_STATUS, value, ask) }
}

/// `fmi2GetIntegerStatus`: the standard defines no such status.
pub unsafe fn get_integer_status<M: Model>(
    component: Component,
    _kind: c_int,
    value: *mut Integer,
) -> Status {
    // SAFETY: as the host vouches.
    unsafe {
        answer(
            component,
            &functions::GET_INTEGER_STATUS,
            value,
            |_: &Instance<M>| None,
        )
    }
}

/// `fmi2GetBooleanStatus`: whether the model wants to terminate. It never does.
pub unsafe fn get_boolean_status<M: Model>(
    component: Component,
    kind: c_int,
    value: *mut Boolean,
) -> Status {
    let ask = |_: &Instance<M>| (kind == TERMINATED).then_some(FALSE);
    // SAFETY: as the host vouches.
    unsafe { answer(component, &functions::GET_BOOLEAN_STATUS, value, ask) }
}

/// `fmi2GetStringStatus`: the state of a pending step. Steps are never pending.
pub unsafe fn get_string_status<M: Model>(
    component: Component,
    _kind: c_int,
    value: *mut Text,
) -> Status {
    // SAFETY: as the host vouches.
    unsafe {
        answer(
            component,
            &functions::GET_STRING_STATUS,
            value,
            |_: &Instance<M>| None,
        )
    }
}
