//! Functions for what this boundary does not offer. They must be there, as importers look for all functions of the
//! standard; each says what is missing and ends with `fmi3Error`.

use crate::boundary::guard::enter;
use crate::boundary::instance::Instance;
use crate::boundary::refusal::Refusal;
use crate::fmi3::functions;
use crate::fmi3::types::{Component, Real, Status, ValueReference};
use crate::model::Model;

pub(super) const NO_CLOCKS: &str = "this FMU has no clocks";
const NO_EVENTS: &str = "this FMU has no event mode in Co-Simulation, and no discrete states";
const NO_STRUCTURE: &str = "this FMU has no structural parameters";
const NO_ELEMENTS: &str = "this FMU provides no dependencies of single elements";

/// Defines functions that are refused. No argument is touched.
macro_rules! absent {
    ($($(#[$doc:meta])* $name:ident = $function:ident, $why:ident($($argument:ident: $type:ty),*);)*) => {$(
        $(#[$doc])*
        pub unsafe fn $name<M: Model>(component: Component, $($argument: $type),*) -> Status {
            $(let _ = $argument;)*
            let body = |_: &mut Instance<M>| Err(Refusal::Absent($why));
            // SAFETY: as the host vouches.
            unsafe { enter(component, &functions::$function, body) }
        }
    )*};
}

absent! {
    /// `fmi3EnterStepMode`.
    enter_step_mode = ENTER_STEP_MODE, NO_EVENTS();
    /// `fmi3EvaluateDiscreteStates`.
    evaluate_discrete_states = EVALUATE_DISCRETE_STATES, NO_EVENTS();
    /// `fmi3EnterConfigurationMode`.
    enter_configuration_mode = ENTER_CONFIGURATION, NO_STRUCTURE();
    /// `fmi3ExitConfigurationMode`.
    exit_configuration_mode = EXIT_CONFIGURATION, NO_STRUCTURE();
    /// `fmi3GetNumberOfVariableDependencies`.
    get_number_of_variable_dependencies = GET_NUMBER_OF_DEPENDENCIES, NO_ELEMENTS(
        reference: ValueReference, n: *mut usize
    );
    /// `fmi3GetVariableDependencies`.
    get_variable_dependencies = GET_DEPENDENCIES, NO_ELEMENTS(
        dependent: ValueReference, elements: *mut usize, independents: *mut ValueReference,
        independent_elements: *mut usize, kinds: *mut i32, n: usize
    );
    /// `fmi3GetIntervalDecimal`.
    get_interval_decimal = GET_INTERVAL_DECIMAL, NO_CLOCKS(
        references: *const ValueReference, n: usize, intervals: *mut Real, qualifiers: *mut i32
    );
    /// `fmi3GetIntervalFraction`.
    get_interval_fraction = GET_INTERVAL_FRACTION, NO_CLOCKS(
        references: *const ValueReference, n: usize, counters: *mut u64, resolutions: *mut u64, qualifiers: *mut i32
    );
    /// `fmi3GetShiftDecimal`.
    get_shift_decimal = GET_SHIFT_DECIMAL, NO_CLOCKS(references: *const ValueReference, n: usize, shifts: *mut Real);
    /// `fmi3GetShiftFraction`.
    get_shift_fraction = GET_SHIFT_FRACTION, NO_CLOCKS(
        references: *const ValueReference, n: usize, counters: *mut u64, resolutions: *mut u64
    );
    /// `fmi3SetIntervalDecimal`.
    set_interval_decimal = SET_INTERVAL_DECIMAL, NO_CLOCKS(
        references: *const ValueReference, n: usize, intervals: *const Real
    );
    /// `fmi3SetIntervalFraction`.
    set_interval_fraction = SET_INTERVAL_FRACTION, NO_CLOCKS(
        references: *const ValueReference, n: usize, counters: *const u64, resolutions: *const u64
    );
    /// `fmi3SetShiftDecimal`.
    set_shift_decimal = SET_SHIFT_DECIMAL, NO_CLOCKS(references: *const ValueReference, n: usize, shifts: *const Real);
    /// `fmi3SetShiftFraction`.
    set_shift_fraction = SET_SHIFT_FRACTION, NO_CLOCKS(
        references: *const ValueReference, n: usize, counters: *const u64, resolutions: *const u64
    );
    /// `fmi3ActivateModelPartition`.
    activate_model_partition = ACTIVATE_PARTITION, NO_CLOCKS(clock: ValueReference, time: Real);
}
