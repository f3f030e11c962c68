//! Values of variables, and derivatives. All variables are scalars, so there is one value for each reference.

use crate::boundary::guard::enter;
use crate::boundary::instance::Instance;
use crate::boundary::raw::{texts, values, values_mut};
use crate::boundary::refusal::{Outcome, Refusal};
use crate::fmi3::functions;
use crate::fmi3::types::{Binary, Boolean, Component, Real, Status, Text, ValueReference};
use crate::model::Model;

/// Checks that there is one value for each reference.
fn scalars(name: &'static str, n: usize, expected: usize) -> Outcome<()> {
    if n == expected {
        return Ok(());
    }
    Err(Refusal::Argument {
        name,
        value: n.to_string(),
        why: "all variables are scalars: there must be as many values as value references",
    })
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
            n_values: usize,
        ) -> Status {
            let body = |instance: &mut Instance<M>| {
                scalars("nValues", n_values, n)?;
                // SAFETY: as the host vouches.
                let references = unsafe { values(references, n, "valueReferences") }?;
                // SAFETY: as the host vouches.
                let value = unsafe { $slice(value, n, "values") }?;
                instance.$method(references, value)
            };
            // SAFETY: as the host vouches.
            unsafe { enter(component, &functions::$function, body) }
        }
    )*};
}

access! {
    /// `fmi3GetFloat64`.
    get_float64 = GET_FLOAT64, get_real(*mut Real, values_mut);
    /// `fmi3GetInt32`.
    get_int32 = GET_INT32, get_int32(*mut i32, values_mut);
    /// `fmi3GetInt64`, for enumerations.
    get_int64 = GET_INT64, get_int64(*mut i64, values_mut);
    /// `fmi3GetBoolean`.
    get_boolean = GET_BOOLEAN, get_boolean(*mut Boolean, values_mut);
    /// `fmi3GetString`.
    get_string = GET_STRING, get_string(*mut Text, values_mut);
    /// `fmi3SetFloat64`.
    set_float64 = SET_FLOAT64, set_real(*const Real, values);
    /// `fmi3SetInt32`.
    set_int32 = SET_INT32, set_int32(*const i32, values);
    /// `fmi3SetInt64`, for enumerations.
    set_int64 = SET_INT64, set_int64(*const i64, values);
    /// `fmi3SetBoolean`.
    set_boolean = SET_BOOLEAN, set_boolean(*const Boolean, values);
}

/// Defines functions for types that no variable has. No value is touched.
macro_rules! none {
    ($($(#[$doc:meta])* $name:ident = $function:ident, $of:literal($($argument:ident: $type:ty),*);)*) => {$(
        $(#[$doc])*
        pub unsafe fn $name<M: Model>(
            component: Component,
            references: *const ValueReference,
            n: usize,
            $($argument: $type),*
        ) -> Status {
            $(let _ = $argument;)*
            let body = |instance: &mut Instance<M>| {
                // SAFETY: as the host vouches.
                let references = unsafe { values(references, n, "valueReferences") }?;
                instance.none_of(references, $of)
            };
            // SAFETY: as the host vouches.
            unsafe { enter(component, &functions::$function, body) }
        }
    )*};
}

none! {
    /// `fmi3GetFloat32`.
    get_float32 = GET_FLOAT32, "Float32"(value: *mut f32, n_values: usize);
    /// `fmi3GetInt8`.
    get_int8 = GET_INT8, "Int8"(value: *mut i8, n_values: usize);
    /// `fmi3GetUInt8`.
    get_uint8 = GET_UINT8, "UInt8"(value: *mut u8, n_values: usize);
    /// `fmi3GetInt16`.
    get_int16 = GET_INT16, "Int16"(value: *mut i16, n_values: usize);
    /// `fmi3GetUInt16`.
    get_uint16 = GET_UINT16, "UInt16"(value: *mut u16, n_values: usize);
    /// `fmi3GetUInt32`.
    get_uint32 = GET_UINT32, "UInt32"(value: *mut u32, n_values: usize);
    /// `fmi3GetUInt64`.
    get_uint64 = GET_UINT64, "UInt64"(value: *mut u64, n_values: usize);
    /// `fmi3GetBinary`.
    get_binary = GET_BINARY, "Binary"(sizes: *mut usize, value: *mut Binary, n_values: usize);
    /// `fmi3GetClock`.
    get_clock = GET_CLOCK, "Clock"(value: *mut Boolean);
    /// `fmi3SetFloat32`.
    set_float32 = SET_FLOAT32, "Float32"(value: *const f32, n_values: usize);
    /// `fmi3SetInt8`.
    set_int8 = SET_INT8, "Int8"(value: *const i8, n_values: usize);
    /// `fmi3SetUInt8`.
    set_uint8 = SET_UINT8, "UInt8"(value: *const u8, n_values: usize);
    /// `fmi3SetInt16`.
    set_int16 = SET_INT16, "Int16"(value: *const i16, n_values: usize);
    /// `fmi3SetUInt16`.
    set_uint16 = SET_UINT16, "UInt16"(value: *const u16, n_values: usize);
    /// `fmi3SetUInt32`.
    set_uint32 = SET_UINT32, "UInt32"(value: *const u32, n_values: usize);
    /// `fmi3SetUInt64`.
    set_uint64 = SET_UINT64, "UInt64"(value: *const u64, n_values: usize);
    /// `fmi3SetBinary`.
    set_binary = SET_BINARY, "Binary"(sizes: *const usize, value: *const Binary, n_values: usize);
    /// `fmi3SetClock`.
    set_clock = SET_CLOCK, "Clock"(value: *const Boolean);
}

/// `fmi3SetString`.
pub unsafe fn set_string<M: Model>(
    component: Component,
    references: *const ValueReference,
    n: usize,
    value: *const Text,
    n_values: usize,
) -> Status {
    let body = |instance: &mut Instance<M>| {
        scalars("nValues", n_values, n)?;
        // SAFETY: as the host vouches.
        let (references, texts) = unsafe {
            (
                values(references, n, "valueReferences")?,
                texts(value, n, "values")?,
            )
        };
        instance.set_string(references, &texts)
    };
    // SAFETY: as the host vouches.
    unsafe { enter(component, &functions::SET_STRING, body) }
}

/// `fmi3GetDirectionalDerivative`.
pub unsafe fn get_directional_derivative<M: Model>(
    component: Component,
    unknowns: *const ValueReference,
    n_unknowns: usize,
    knowns: *const ValueReference,
    n_knowns: usize,
    seed: *const Real,
    n_seed: usize,
    sensitivity: *mut Real,
    n_sensitivity: usize,
) -> Status {
    let body = |instance: &mut Instance<M>| {
        scalars("nSeed", n_seed, n_knowns)?;
        scalars("nSensitivity", n_sensitivity, n_unknowns)?;
        // SAFETY: as the host vouches.
        let (unknowns, knowns, seed, sensitivity) = unsafe {
            (
                values(unknowns, n_unknowns, "unknowns")?,
                values(knowns, n_knowns, "knowns")?,
                values(seed, n_knowns, "seed")?,
                values_mut(sensitivity, n_unknowns, "sensitivity")?,
            )
        };
        instance.get_directional_derivative(unknowns, knowns, seed, sensitivity)
    };
    // SAFETY: as the host vouches.
    unsafe { enter(component, &functions::DIRECTIONAL_DERIVATIVE, body) }
}

/// `fmi3GetAdjointDerivative`.
pub unsafe fn get_adjoint_derivative<M: Model>(
    component: Component,
    unknowns: *const ValueReference,
    n_unknowns: usize,
    knowns: *const ValueReference,
    n_knowns: usize,
    seed: *const Real,
    n_seed: usize,
    sensitivity: *mut Real,
    n_sensitivity: usize,
) -> Status {
    let body = |instance: &mut Instance<M>| {
        scalars("nSeed", n_seed, n_unknowns)?;
        scalars("nSensitivity", n_sensitivity, n_knowns)?;
        // SAFETY: as the host vouches.
        let (unknowns, knowns, seed, sensitivity) = unsafe {
            (
                values(unknowns, n_unknowns, "unknowns")?,
                values(knowns, n_knowns, "knowns")?,
                values(seed, n_unknowns, "seed")?,
                values_mut(sensitivity, n_knowns, "sensitivity")?,
            )
        };
        instance.get_adjoint_derivative(unknowns, knowns, seed, sensitivity)
    };
    // SAFETY: as the host vouches.
    unsafe { enter(component, &functions::ADJOINT_DERIVATIVE, body) }
}

/// `fmi3GetOutputDerivatives`.
pub unsafe fn get_output_derivatives<M: Model>(
    component: Component,
    references: *const ValueReference,
    n: usize,
    orders: *const i32,
    value: *mut Real,
    n_values: usize,
) -> Status {
    let body = |instance: &mut Instance<M>| {
        scalars("nValues", n_values, n)?;
        // SAFETY: as the host vouches.
        let (references, orders, value) = unsafe {
            (
                values(references, n, "valueReferences")?,
                values(orders, n, "orders")?,
                values_mut(value, n, "values")?,
            )
        };
        instance.get_output_derivatives(references, orders, value)
    };
    // SAFETY: as the host vouches.
    unsafe { enter(component, &functions::GET_OUTPUT_DERIVATIVES, body) }
}
