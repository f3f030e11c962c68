//! The functions of FMI 2.0 Co-Simulation, generic over the model. [`export!`](crate::export)
//! gives them their C names.
//!
//! # Safety
//! The functions take what a C host passes, and rely on this: a component is NULL or points to at least eight readable
//! bytes, and was not freed; a pointer with a count points to that many values; strings end with NUL; a saved state is
//! NULL or was not freed. NULL in place of a value, foreign handles and calls at the wrong time are refused.
#![allow(clippy::missing_safety_doc)] // said above for all functions

use std::ffi::c_int;
use std::panic::{AssertUnwindSafe, catch_unwind};

use super::guard::{Handle, enter};
use super::instance::{Instance, Request};
use super::phase::{self, Function};
use super::raw::{lossy, place, text, values, values_mut};
use super::refusal::{Outcome, Refusal};
use super::types::{
    Boolean, Byte, CallbackFunctions, Component, DO_STEP_STATUS, FALSE, FmuState, Integer,
    LAST_SUCCESSFUL_TIME, Real, Status, TERMINATED, Text, ValueReference,
};
use crate::model::Model;

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
        let request = Request {
            name: name.as_deref().unwrap_or_default(),
            kind,
            guid: guid.as_deref().unwrap_or_default(),
            resources: resources.as_deref(),
            logging: logging != FALSE,
        };
        Instance::<M>::new(&request, &callbacks).map(Handle::give)
    };
    catch_unwind(AssertUnwindSafe(make))
        .ok()
        .flatten()
        .unwrap_or(std::ptr::null_mut())
}

/// `fmi2FreeInstance`.
pub unsafe fn free_instance<M: Model>(component: Component) {
    // SAFETY: as the host vouches.
    unsafe { Handle::<M>::end(component) }
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
    unsafe { enter(component, &phase::SET_DEBUG_LOGGING, body) }
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
    unsafe { enter(component, &phase::SETUP_EXPERIMENT, body) }
}

/// Defines functions that take nothing but the component.
macro_rules! plain {
    ($($(#[$doc:meta])* $name:ident = $function:ident, $method:ident;)*) => {$(
        $(#[$doc])*
        pub unsafe fn $name<M: Model>(component: Component) -> Status {
            // SAFETY: as the host vouches.
            unsafe { enter(component, &phase::$function, Instance::<M>::$method) }
        }
    )*};
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

/// Defines functions that read or write values of one type.
macro_rules! access {
    ($($(#[$doc:meta])* $name:ident = $function:ident, $method:ident($pointer:ty, $slice:ident);)*) => {$(
        $(#[$doc])*
        pub unsafe fn $name<M: Model>(
            component: Component,
            references: *const ValueReference,
            n: usize,
            value: $pointer,
        ) -> Status {
            let body = |instance: &mut Instance<M>| {
                // SAFETY: as the host vouches.
                let references = unsafe { values(references, n, "vr") }?;
                // SAFETY: as the host vouches.
                let value = unsafe { $slice(value, n, "value") }?;
                instance.$method(references, value)
            };
            // SAFETY: as the host vouches.
            unsafe { enter(component, &phase::$function, body) }
        }
    )*};
}

access! {
    /// `fmi2GetReal`.
    get_real = GET_REAL, get_real(*mut Real, values_mut);
    /// `fmi2GetInteger`.
    get_integer = GET_INTEGER, get_integer(*mut Integer, values_mut);
    /// `fmi2GetBoolean`.
    get_boolean = GET_BOOLEAN, get_boolean(*mut Boolean, values_mut);
    /// `fmi2GetString`.
    get_string = GET_STRING, get_string(*mut Text, values_mut);
    /// `fmi2SetReal`.
    set_real = SET_REAL, set_real(*const Real, values);
    /// `fmi2SetInteger`.
    set_integer = SET_INTEGER, set_integer(*const Integer, values);
    /// `fmi2SetBoolean`.
    set_boolean = SET_BOOLEAN, set_boolean(*const Boolean, values);
}

/// `fmi2SetString`.
pub unsafe fn set_string<M: Model>(
    component: Component,
    references: *const ValueReference,
    n: usize,
    value: *const Text,
) -> Status {
    let body = |instance: &mut Instance<M>| {
        // SAFETY: as the host vouches.
        let (references, texts) =
            unsafe { (values(references, n, "vr")?, texts(value, n, "value")?) };
        instance.set_string(references, &texts)
    };
    // SAFETY: as the host vouches.
    unsafe { enter(component, &phase::SET_STRING, body) }
}

/// `n` texts.
unsafe fn texts<'a>(pointer: *const Text, n: usize, name: &'static str) -> Outcome<Vec<&'a str>> {
    // SAFETY: as the host vouches.
    unsafe {
        values(pointer, n, name)?
            .iter()
            .map(|pointer| text(*pointer, name))
            .collect()
    }
}

/// `fmi2GetFMUstate`.
pub unsafe fn get_fmu_state<M: Model>(component: Component, state: *mut FmuState) -> Status {
    // SAFETY: as the host vouches.
    let body = |instance: &mut Instance<M>| unsafe { instance.save(place(state, "FMUstate")?) };
    // SAFETY: as the host vouches.
    unsafe { enter(component, &phase::GET_STATE, body) }
}

/// `fmi2SetFMUstate`.
pub unsafe fn set_fmu_state<M: Model>(component: Component, state: FmuState) -> Status {
    // SAFETY: as the host vouches.
    let body = |instance: &mut Instance<M>| unsafe { instance.restore(state) };
    // SAFETY: as the host vouches.
    unsafe { enter(component, &phase::SET_STATE, body) }
}

/// `fmi2FreeFMUstate`. NULL, and a pointer to NULL, are left alone.
pub unsafe fn free_fmu_state<M: Model>(component: Component, state: *mut FmuState) -> Status {
    let body = |_: &mut Instance<M>| {
        if state.is_null() {
            return Ok(Status::Ok);
        }
        // SAFETY: as the host vouches.
        unsafe { Instance::<M>::free_state(place(state, "FMUstate")?) }
    };
    // SAFETY: as the host vouches.
    unsafe { enter(component, &phase::FREE_STATE, body) }
}

/// `fmi2SerializedFMUstateSize`.
pub unsafe fn serialized_fmu_state_size<M: Model>(
    component: Component,
    state: FmuState,
    size: *mut usize,
) -> Status {
    let body = |instance: &mut Instance<M>| {
        // SAFETY: as the host vouches.
        let (place, bytes) = unsafe { (place(size, "size")?, instance.serialize(state)?) };
        *place = bytes.len();
        Ok(Status::Ok)
    };
    // SAFETY: as the host vouches.
    unsafe { enter(component, &phase::SERIALIZED_SIZE, body) }
}

/// `fmi2SerializeFMUstate`.
pub unsafe fn serialize_fmu_state<M: Model>(
    component: Component,
    state: FmuState,
    serialized: *mut Byte,
    size: usize,
) -> Status {
    let body = |instance: &mut Instance<M>| {
        // SAFETY: as the host vouches.
        let bytes = unsafe { instance.serialize(state) }?;
        if size < bytes.len() {
            return Err(Refusal::Size {
                given: size,
                needed: bytes.len(),
            });
        }
        // SAFETY: as the host vouches; there is room for that many bytes.
        unsafe { values_mut(serialized.cast::<u8>(), bytes.len(), "serializedState") }?
            .copy_from_slice(&bytes);
        Ok(Status::Ok)
    };
    // SAFETY: as the host vouches.
    unsafe { enter(component, &phase::SERIALIZE, body) }
}

/// `fmi2DeSerializeFMUstate`.
pub unsafe fn deserialize_fmu_state<M: Model>(
    component: Component,
    serialized: *const Byte,
    size: usize,
    state: *mut FmuState,
) -> Status {
    let body = |instance: &mut Instance<M>| {
        // SAFETY: as the host vouches.
        let (bytes, place) = unsafe {
            (
                values(serialized.cast::<u8>(), size, "serializedState")?,
                place(state, "FMUstate")?,
            )
        };
        instance.deserialize(bytes, place)
    };
    // SAFETY: as the host vouches.
    unsafe { enter(component, &phase::DESERIALIZE, body) }
}

/// `fmi2GetDirectionalDerivative`.
pub unsafe fn get_directional_derivative<M: Model>(
    component: Component,
    unknowns: *const ValueReference,
    n_unknowns: usize,
    knowns: *const ValueReference,
    n_knowns: usize,
    direction: *const Real,
    derivative: *mut Real,
) -> Status {
    let body = |instance: &mut Instance<M>| {
        // SAFETY: as the host vouches.
        let (unknowns, knowns, direction, derivative) = unsafe {
            (
                values(unknowns, n_unknowns, "vUnknown_ref")?,
                values(knowns, n_knowns, "vKnown_ref")?,
                values(direction, n_knowns, "dvKnown")?,
                values_mut(derivative, n_unknowns, "dvUnknown")?,
            )
        };
        instance.get_directional_derivative(unknowns, knowns, direction, derivative)
    };
    // SAFETY: as the host vouches.
    unsafe { enter(component, &phase::DIRECTIONAL_DERIVATIVE, body) }
}

/// `fmi2SetRealInputDerivatives`.
pub unsafe fn set_real_input_derivatives<M: Model>(
    component: Component,
    references: *const ValueReference,
    n: usize,
    orders: *const Integer,
    value: *const Real,
) -> Status {
    let body = |instance: &mut Instance<M>| {
        // SAFETY: as the host vouches.
        let (references, orders, value) = unsafe {
            (
                values(references, n, "vr")?,
                values(orders, n, "order")?,
                values(value, n, "value")?,
            )
        };
        instance.set_input_derivatives(references, orders, value)
    };
    // SAFETY: as the host vouches.
    unsafe { enter(component, &phase::SET_INPUT_DERIVATIVES, body) }
}

/// `fmi2GetRealOutputDerivatives`.
pub unsafe fn get_real_output_derivatives<M: Model>(
    component: Component,
    references: *const ValueReference,
    n: usize,
    orders: *const Integer,
    value: *mut Real,
) -> Status {
    let body = |instance: &mut Instance<M>| {
        // SAFETY: as the host vouches.
        let (references, orders, value) = unsafe {
            (
                values(references, n, "vr")?,
                values(orders, n, "order")?,
                values_mut(value, n, "value")?,
            )
        };
        instance.get_output_derivatives(references, orders, value)
    };
    // SAFETY: as the host vouches.
    unsafe { enter(component, &phase::GET_OUTPUT_DERIVATIVES, body) }
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
        enter(component, &phase::DO_STEP, |instance: &mut Instance<M>| {
            instance.step(from, step)
        })
    }
}

/// `fmi2CancelStep`. Steps are synchronous, so there is none to cancel: it is refused in every phase.
pub unsafe fn cancel_step<M: Model>(component: Component) -> Status {
    // SAFETY: as the host vouches.
    unsafe {
        enter(component, &phase::CANCEL_STEP, |_: &mut Instance<M>| {
            Ok(Status::Ok)
        })
    }
}

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
    unsafe { answer(component, &phase::GET_STATUS, value, ask) }
}

/// `fmi2GetRealStatus`: the time that the last successful step has reached.
pub unsafe fn get_real_status<M: Model>(
    component: Component,
    kind: c_int,
    value: *mut Real,
) -> Status {
    let ask = |instance: &Instance<M>| (kind == LAST_SUCCESSFUL_TIME).then_some(instance.run.time);
    // SAFETY: as the host vouches.
    unsafe { answer(component, &phase::GET_REAL_STATUS, value, ask) }
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
            &phase::GET_INTEGER_STATUS,
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
    unsafe { answer(component, &phase::GET_BOOLEAN_STATUS, value, ask) }
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
            &phase::GET_STRING_STATUS,
            value,
            |_: &Instance<M>| None,
        )
    }
}
