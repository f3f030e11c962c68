//! The C functions of FMI 3.0 under their own names.

/// Defines the 75 C functions of FMI 3.0 for a model; [`export!`](crate::export) calls it.
#[doc(hidden)]
#[macro_export]
macro_rules! export_fmi3 {
    ($model:ty) => {
        $crate::export_fmi3_functions! { $model:
            fmi3InstantiateModelExchange = instantiate_model_exchange(name: Text, token: Text, resources: Text,
                visible: Boolean, logging: Boolean, environment: ComponentEnvironment, log:
                Option<LogMessageCallback>) -> Component;
            fmi3InstantiateCoSimulation = instantiate_co_simulation(name: Text, token: Text, resources: Text,
                visible: Boolean, logging: Boolean, event_mode: Boolean, early_return: Boolean, intermediate: *const
                ValueReference, n_intermediate: usize, environment: ComponentEnvironment, log:
                Option<LogMessageCallback>, update: Option<IntermediateUpdateCallback>) -> Component;
            fmi3InstantiateScheduledExecution = instantiate_scheduled_execution(name: Text, token: Text, resources:
                Text, visible: Boolean, logging: Boolean, environment: ComponentEnvironment, log:
                Option<LogMessageCallback>, update: Unused, lock: Unused, unlock: Unused) -> Component;
            fmi3FreeInstance = free_instance(component: Component);
            fmi3SetDebugLogging = set_debug_logging(component: Component, on: Boolean, n: usize, categories: *const
                Text) -> Status;
            fmi3EnterInitializationMode = enter_initialization_mode(component: Component, tolerance_defined:
                Boolean, tolerance: Real, start: Real, stop_defined: Boolean, stop: Real) -> Status;
            fmi3ExitInitializationMode = exit_initialization_mode(component: Component) -> Status;
            fmi3EnterEventMode = enter_event_mode(component: Component) -> Status;
            fmi3Terminate = terminate(component: Component) -> Status;
            fmi3Reset = reset(component: Component) -> Status;
            fmi3GetFloat32 = get_float32(component: Component, references: *const ValueReference, n: usize, value:
                *mut f32, n_values: usize) -> Status;
            fmi3GetFloat64 = get_float64(component: Component, references: *const ValueReference, n: usize, value:
                *mut Real, n_values: usize) -> Status;
            fmi3GetInt8 = get_int8(component: Component, references: *const ValueReference, n: usize, value: *mut
                i8, n_values: usize) -> Status;
            fmi3GetUInt8 = get_uint8(component: Component, references: *const ValueReference, n: usize, value: *mut
                u8, n_values: usize) -> Status;
            fmi3GetInt16 = get_int16(component: Component, references: *const ValueReference, n: usize, value: *mut
                i16, n_values: usize) -> Status;
            fmi3GetUInt16 = get_uint16(component: Component, references: *const ValueReference, n: usize, value:
                *mut u16, n_values: usize) -> Status;
            fmi3GetInt32 = get_int32(component: Component, references: *const ValueReference, n: usize, value: *mut
                i32, n_values: usize) -> Status;
            fmi3GetUInt32 = get_uint32(component: Component, references: *const ValueReference, n: usize, value:
                *mut u32, n_values: usize) -> Status;
            fmi3GetInt64 = get_int64(component: Component, references: *const ValueReference, n: usize, value: *mut
                i64, n_values: usize) -> Status;
            fmi3GetUInt64 = get_uint64(component: Component, references: *const ValueReference, n: usize, value:
                *mut u64, n_values: usize) -> Status;
            fmi3GetBoolean = get_boolean(component: Component, references: *const ValueReference, n: usize, value:
                *mut Boolean, n_values: usize) -> Status;
            fmi3GetString = get_string(component: Component, references: *const ValueReference, n: usize, value:
                *mut Text, n_values: usize) -> Status;
            fmi3GetBinary = get_binary(component: Component, references: *const ValueReference, n: usize, sizes:
                *mut usize, value: *mut Binary, n_values: usize) -> Status;
            fmi3GetClock = get_clock(component: Component, references: *const ValueReference, n: usize, value: *mut
                Boolean) -> Status;
            fmi3SetFloat32 = set_float32(component: Component, references: *const ValueReference, n: usize, value:
                *const f32, n_values: usize) -> Status;
            fmi3SetFloat64 = set_float64(component: Component, references: *const ValueReference, n: usize, value:
                *const Real, n_values: usize) -> Status;
            fmi3SetInt8 = set_int8(component: Component, references: *const ValueReference, n: usize, value: *const
                i8, n_values: usize) -> Status;
            fmi3SetUInt8 = set_uint8(component: Component, references: *const ValueReference, n: usize, value:
                *const u8, n_values: usize) -> Status;
            fmi3SetInt16 = set_int16(component: Component, references: *const ValueReference, n: usize, value:
                *const i16, n_values: usize) -> Status;
            fmi3SetUInt16 = set_uint16(component: Component, references: *const ValueReference, n: usize, value:
                *const u16, n_values: usize) -> Status;
            fmi3SetInt32 = set_int32(component: Component, references: *const ValueReference, n: usize, value:
                *const i32, n_values: usize) -> Status;
            fmi3SetUInt32 = set_uint32(component: Component, references: *const ValueReference, n: usize, value:
                *const u32, n_values: usize) -> Status;
            fmi3SetInt64 = set_int64(component: Component, references: *const ValueReference, n: usize, value:
                *const i64, n_values: usize) -> Status;
            fmi3SetUInt64 = set_uint64(component: Component, references: *const ValueReference, n: usize, value:
                *const u64, n_values: usize) -> Status;
            fmi3SetBoolean = set_boolean(component: Component, references: *const ValueReference, n: usize, value:
                *const Boolean, n_values: usize) -> Status;
            fmi3SetString = set_string(component: Component, references: *const ValueReference, n: usize, value:
                *const Text, n_values: usize) -> Status;
            fmi3SetBinary = set_binary(component: Component, references: *const ValueReference, n: usize, sizes:
                *const usize, value: *const Binary, n_values: usize) -> Status;
            fmi3SetClock = set_clock(component: Component, references: *const ValueReference, n: usize, value:
                *const Boolean) -> Status;
            fmi3GetNumberOfVariableDependencies = get_number_of_variable_dependencies(component: Component,
                reference: ValueReference, n: *mut usize) -> Status;
            fmi3GetVariableDependencies = get_variable_dependencies(component: Component, dependent: ValueReference,
                elements: *mut usize, independents: *mut ValueReference, independent_elements: *mut usize, kinds:
                *mut i32, n: usize) -> Status;
            fmi3GetFMUState = get_fmu_state(component: Component, state: *mut FmuState) -> Status;
            fmi3SetFMUState = set_fmu_state(component: Component, state: FmuState) -> Status;
            fmi3FreeFMUState = free_fmu_state(component: Component, state: *mut FmuState) -> Status;
            fmi3SerializedFMUStateSize = serialized_fmu_state_size(component: Component, state: FmuState, size: *mut
                usize) -> Status;
            fmi3SerializeFMUState = serialize_fmu_state(component: Component, state: FmuState, serialized: *mut
                Byte, size: usize) -> Status;
            fmi3DeserializeFMUState = deserialize_fmu_state(component: Component, serialized: *const Byte, size:
                usize, state: *mut FmuState) -> Status;
            fmi3GetDirectionalDerivative = get_directional_derivative(component: Component, unknowns: *const
                ValueReference, n_unknowns: usize, knowns: *const ValueReference, n_knowns: usize, seed: *const
                Real, n_seed: usize, sensitivity: *mut Real, n_sensitivity: usize) -> Status;
            fmi3GetAdjointDerivative = get_adjoint_derivative(component: Component, unknowns: *const ValueReference,
                n_unknowns: usize, knowns: *const ValueReference, n_knowns: usize, seed: *const Real, n_seed: usize,
                sensitivity: *mut Real, n_sensitivity: usize) -> Status;
            fmi3EnterConfigurationMode = enter_configuration_mode(component: Component) -> Status;
            fmi3ExitConfigurationMode = exit_configuration_mode(component: Component) -> Status;
            fmi3GetIntervalDecimal = get_interval_decimal(component: Component, references: *const ValueReference,
                n: usize, intervals: *mut Real, qualifiers: *mut i32) -> Status;
            fmi3GetIntervalFraction = get_interval_fraction(component: Component, references: *const ValueReference,
                n: usize, counters: *mut u64, resolutions: *mut u64, qualifiers: *mut i32) -> Status;
            fmi3GetShiftDecimal = get_shift_decimal(component: Component, references: *const ValueReference, n:
                usize, shifts: *mut Real) -> Status;
            fmi3GetShiftFraction = get_shift_fraction(component: Component, references: *const ValueReference, n:
                usize, counters: *mut u64, resolutions: *mut u64) -> Status;
            fmi3SetIntervalDecimal = set_interval_decimal(component: Component, references: *const ValueReference,
                n: usize, intervals: *const Real) -> Status;
            fmi3SetIntervalFraction = set_interval_fraction(component: Component, references: *const ValueReference,
                n: usize, counters: *const u64, resolutions: *const u64) -> Status;
            fmi3SetShiftDecimal = set_shift_decimal(component: Component, references: *const ValueReference, n:
                usize, shifts: *const Real) -> Status;
            fmi3SetShiftFraction = set_shift_fraction(component: Component, references: *const ValueReference, n:
                usize, counters: *const u64, resolutions: *const u64) -> Status;
            fmi3EvaluateDiscreteStates = evaluate_discrete_states(component: Component) -> Status;
            fmi3UpdateDiscreteStates = update_discrete_states(component: Component, again: *mut Boolean, terminate:
                *mut Boolean, nominals: *mut Boolean, values: *mut Boolean, defined: *mut Boolean, time: *mut Real)
                -> Status;
            fmi3EnterContinuousTimeMode = enter_continuous_time_mode(component: Component) -> Status;
            fmi3CompletedIntegratorStep = completed_integrator_step(component: Component, no_set_state_prior:
                Boolean, enter_event_mode: *mut Boolean, terminate: *mut Boolean) -> Status;
            fmi3SetTime = set_time(component: Component, time: Real) -> Status;
            fmi3SetContinuousStates = set_continuous_states(component: Component, states: *const Real, n: usize) ->
                Status;
            fmi3GetContinuousStateDerivatives = get_continuous_state_derivatives(component: Component, rates: *mut
                Real, n: usize) -> Status;
            fmi3GetEventIndicators = get_event_indicators(component: Component, indicators: *mut Real, n: usize) ->
                Status;
            fmi3GetContinuousStates = get_continuous_states(component: Component, states: *mut Real, n: usize) ->
                Status;
            fmi3GetNominalsOfContinuousStates = get_nominals_of_continuous_states(component: Component, nominals:
                *mut Real, n: usize) -> Status;
            fmi3GetNumberOfEventIndicators = get_number_of_event_indicators(component: Component, n: *mut usize) ->
                Status;
            fmi3GetNumberOfContinuousStates = get_number_of_continuous_states(component: Component, n: *mut usize)
                -> Status;
            fmi3EnterStepMode = enter_step_mode(component: Component) -> Status;
            fmi3GetOutputDerivatives = get_output_derivatives(component: Component, references: *const
                ValueReference, n: usize, orders: *const i32, value: *mut Real, n_values: usize) -> Status;
            fmi3DoStep = do_step(component: Component, from: Real, step: Real, no_set_state_prior: Boolean,
                event_handling_needed: *mut Boolean, terminate_simulation: *mut Boolean, early_return: *mut Boolean,
                last_successful_time: *mut Real) -> Status;
            fmi3ActivateModelPartition = activate_model_partition(component: Component, clock: ValueReference, time:
                Real) -> Status;
        }
    };
}

/// Defines the functions that `export_fmi3!` lists.
#[doc(hidden)]
#[macro_export]
macro_rules! export_fmi3_functions {
    ($model:ty: $($name:ident = $call:ident($($argument:ident: $of:ty),*) $(-> $result:ty)?;)*) => {
        /// The C functions of FMI 3.0. `fmu_export::fmi3::calls` says what they rely on.
        #[allow(non_snake_case, missing_docs)]
        #[allow(clippy::missing_safety_doc, clippy::too_many_arguments)]
        pub mod fmi3_functions {
            // The model. If its crate has a type `Status`, too, the one below counts: it is imported by its name.
            #[allow(unused_imports)]
            use super::*;
            use $crate::fmi3::calls;
            use $crate::fmi3::types::{
                Binary, Boolean, Byte, Component, ComponentEnvironment, FmuState, IntermediateUpdateCallback, LogMessageCallback, Real, Status,
                Text, Unused, ValueReference,
            };

            #[unsafe(no_mangle)]
            pub extern "C" fn fmi3GetVersion() -> Text {
                c"3.0".as_ptr()
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
