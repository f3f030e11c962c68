//! Values of variables, and derivatives.

use crate::boundary::guard::enter;
use crate::boundary::instance::Instance;
use crate::boundary::raw::{texts, values, values_mut};
use crate::fmi2::functions;
use crate::fmi2::types::{Boolean, Component, Integer, Real, Status, Text, ValueReference};
use crate::model::Model;

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
            unsafe { enter(component, &functions::$function, body) }
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
    unsafe { enter(component, &functions::SET_STRING, body) }
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
    unsafe { enter(component, &functions::DIRECTIONAL_DERIVATIVE, body) }
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
    unsafe { enter(component, &functions::SET_INPUT_DERIVATIVES, body) }
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
    unsafe { enter(component, &functions::GET_OUTPUT_DERIVATIVES, body) }
}
