//! The C functions of FMI 2.0 under their own names.

/// Defines the C functions of FMI for a model, the 44 of FMI 2.0 and the 75 of FMI 3.0:
/// `fmu_export::export!(Tank);`
///
/// Write it once, at the root of a crate whose `crate-type` is `["lib", "cdylib"]`. Which interface a library serves is
/// said by the model description beside it.
#[macro_export]
macro_rules! export {
    ($model:ty) => {
        $crate::export_fmi2! { $model }
        $crate::export_fmi3! { $model }
    };
}

/// Defines the C functions of FMI 2.0 for a model; [`export!`](crate::export) calls it.
#[doc(hidden)]
#[macro_export]
macro_rules! export_fmi2 {
    ($model:ty) => {
        $crate::export_fmi2_functions! { $model:
            fmi2Instantiate = instantiate(name: Text, kind: c_int, guid: Text, resources: Text,
                callbacks: *const CallbackFunctions, visible: Boolean, logging: Boolean) -> Component;
            fmi2FreeInstance = free_instance(component: Component);
            fmi2SetDebugLogging = set_debug_logging(component: Component, on: Boolean, n: usize,
                categories: *const Text) -> Status;
            fmi2SetupExperiment = setup_experiment(component: Component, tolerance_defined: Boolean,
                tolerance: Real, start: Real, stop_defined: Boolean, stop: Real) -> Status;
            fmi2EnterInitializationMode = enter_initialization_mode(component: Component) -> Status;
            fmi2ExitInitializationMode = exit_initialization_mode(component: Component) -> Status;
            fmi2Terminate = terminate(component: Component) -> Status;
            fmi2Reset = reset(component: Component) -> Status;
            fmi2GetReal = get_real(component: Component, references: *const ValueReference, n: usize,
                value: *mut Real) -> Status;
            fmi2GetInteger = get_integer(component: Component, references: *const ValueReference,
                n: usize, value: *mut Integer) -> Status;
            fmi2GetBoolean = get_boolean(component: Component, references: *const ValueReference,
                n: usize, value: *mut Boolean) -> Status;
            fmi2GetString = get_string(component: Component, references: *const ValueReference,
                n: usize, value: *mut Text) -> Status;
            fmi2SetReal = set_real(component: Component, references: *const ValueReference, n: usize,
                value: *const Real) -> Status;
            fmi2SetInteger = set_integer(component: Component, references: *const ValueReference,
                n: usize, value: *const Integer) -> Status;
            fmi2SetBoolean = set_boolean(component: Component, references: *const ValueReference,
                n: usize, value: *const Boolean) -> Status;
            fmi2SetString = set_string(component: Component, references: *const ValueReference,
                n: usize, value: *const Text) -> Status;
            fmi2GetFMUstate = get_fmu_state(component: Component, state: *mut FmuState) -> Status;
            fmi2SetFMUstate = set_fmu_state(component: Component, state: FmuState) -> Status;
            fmi2FreeFMUstate = free_fmu_state(component: Component, state: *mut FmuState) -> Status;
            fmi2SerializedFMUstateSize = serialized_fmu_state_size(component: Component,
                state: FmuState, size: *mut usize) -> Status;
            fmi2SerializeFMUstate = serialize_fmu_state(component: Component, state: FmuState,
                serialized: *mut Byte, size: usize) -> Status;
            fmi2DeSerializeFMUstate = deserialize_fmu_state(component: Component,
                serialized: *const Byte, size: usize, state: *mut FmuState) -> Status;
            fmi2GetDirectionalDerivative = get_directional_derivative(component: Component,
                unknowns: *const ValueReference, n_unknowns: usize, knowns: *const ValueReference,
                n_knowns: usize, direction: *const Real, derivative: *mut Real) -> Status;
            fmi2SetRealInputDerivatives = set_real_input_derivatives(component: Component,
                references: *const ValueReference, n: usize, orders: *const Integer,
                value: *const Real) -> Status;
            fmi2GetRealOutputDerivatives = get_real_output_derivatives(component: Component,
                references: *const ValueReference, n: usize, orders: *const Integer,
                value: *mut Real) -> Status;
            fmi2EnterEventMode = enter_event_mode(component: Component) -> Status;
            fmi2NewDiscreteStates = new_discrete_states(component: Component, info: *mut EventInfo) -> Status;
            fmi2EnterContinuousTimeMode = enter_continuous_time_mode(component: Component) -> Status;
            fmi2CompletedIntegratorStep = completed_integrator_step(component: Component,
                no_set_state_prior: Boolean, enter_event_mode: *mut Boolean, terminate: *mut Boolean) -> Status;
            fmi2SetTime = set_time(component: Component, time: Real) -> Status;
            fmi2SetContinuousStates = set_continuous_states(component: Component, value: *const Real,
                n: usize) -> Status;
            fmi2GetDerivatives = get_derivatives(component: Component, value: *mut Real, n: usize) -> Status;
            fmi2GetEventIndicators = get_event_indicators(component: Component, value: *mut Real,
                n: usize) -> Status;
            fmi2GetContinuousStates = get_continuous_states(component: Component, value: *mut Real,
                n: usize) -> Status;
            fmi2GetNominalsOfContinuousStates = get_nominals_of_continuous_states(component: Component,
                value: *mut Real, n: usize) -> Status;
            fmi2DoStep = do_step(component: Component, from: Real, step: Real,
                no_set_state_prior: Boolean) -> Status;
            fmi2CancelStep = cancel_step(component: Component) -> Status;
            fmi2GetStatus = get_status(component: Component, kind: c_int, value: *mut Status) -> Status;
            fmi2GetRealStatus = get_real_status(component: Component, kind: c_int,
                value: *mut Real) -> Status;
            fmi2GetIntegerStatus = get_integer_status(component: Component, kind: c_int,
                value: *mut Integer) -> Status;
            fmi2GetBooleanStatus = get_boolean_status(component: Component, kind: c_int,
                value: *mut Boolean) -> Status;
            fmi2GetStringStatus = get_string_status(component: Component, kind: c_int,
                value: *mut Text) -> Status;
        }
    };
}

/// Defines the functions that `export_fmi2!` lists.
#[doc(hidden)]
#[macro_export]
macro_rules! export_fmi2_functions {
    ($model:ty: $($name:ident = $call:ident($($argument:ident: $of:ty),*) $(-> $result:ty)?;)*) => {
        /// The C functions of FMI 2.0. `fmu_export::fmi2::calls` says what they rely on.
        #[allow(non_snake_case, missing_docs)]
        #[allow(clippy::missing_safety_doc, clippy::too_many_arguments)]
        pub mod c_functions {
            use std::ffi::c_int;
            // The model. If its crate has a type `Status`, too, the one below counts: it is imported by its name.
            #[allow(unused_imports)]
            use super::*;
            use $crate::fmi2::calls;
            use $crate::fmi2::types::{
                Boolean, Byte, CallbackFunctions, Component, EventInfo, FmuState, Integer, Real, Status, Text, ValueReference,
            };

            #[unsafe(no_mangle)]
            pub extern "C" fn fmi2GetTypesPlatform() -> Text {
                c"default".as_ptr()
            }

            #[unsafe(no_mangle)]
            pub extern "C" fn fmi2GetVersion() -> Text {
                c"2.0".as_ptr()
            }

            $(
                #[unsafe(no_mangle)]
                pub unsafe extern "C" fn $name($($argument: $of),*) $(-> $result)? {
                    // SAFETY: the generic function asks the same of its caller.
                    unsafe { calls::$call::<$model>($($argument),*) }
                }
            )*
        }
    };
}
