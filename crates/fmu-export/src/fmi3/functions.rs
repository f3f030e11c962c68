//! The functions of FMI 3.0 with the phases in which they may be called (standard 3.0.2, sections 2.3.1, 3.2.1 and 4.2.1).
//!
//! A discarded step leaves an instance in step mode. Functions for what this boundary does not offer can be called at any
//! time, and say so.

use crate::boundary::phase::Phase::{
    Continuous, Error, Event, Initialization, Instantiated, Intermediate, StepComplete, StepFailed,
    Terminated,
};
use crate::boundary::phase::{ALIVE, DERIVABLE, INTEGRABLE, SETTABLE, VISIBLE, functions};

functions! {
    Three:
    SET_DEBUG_LOGGING fmi3SetDebugLogging ALIVE;
    ENTER_INITIALIZATION fmi3EnterInitializationMode &[Instantiated];
    EXIT_INITIALIZATION fmi3ExitInitializationMode &[Initialization];
    ENTER_EVENT_MODE fmi3EnterEventMode &[Continuous];
    TERMINATE fmi3Terminate &[StepComplete, Event, Continuous];
    RESET fmi3Reset ALIVE;
    GET_FLOAT32 fmi3GetFloat32 VISIBLE;
    GET_FLOAT64 fmi3GetFloat64 VISIBLE;
    GET_INT8 fmi3GetInt8 VISIBLE;
    GET_UINT8 fmi3GetUInt8 VISIBLE;
    GET_INT16 fmi3GetInt16 VISIBLE;
    GET_UINT16 fmi3GetUInt16 VISIBLE;
    GET_INT32 fmi3GetInt32 VISIBLE;
    GET_UINT32 fmi3GetUInt32 VISIBLE;
    GET_INT64 fmi3GetInt64 VISIBLE;
    GET_UINT64 fmi3GetUInt64 VISIBLE;
    GET_BOOLEAN fmi3GetBoolean VISIBLE;
    GET_STRING fmi3GetString VISIBLE;
    GET_BINARY fmi3GetBinary VISIBLE;
    GET_CLOCK fmi3GetClock VISIBLE;
    SET_FLOAT32 fmi3SetFloat32 SETTABLE;
    SET_FLOAT64 fmi3SetFloat64 SETTABLE;
    SET_INT8 fmi3SetInt8 SETTABLE;
    SET_UINT8 fmi3SetUInt8 SETTABLE;
    SET_INT16 fmi3SetInt16 SETTABLE;
    SET_UINT16 fmi3SetUInt16 SETTABLE;
    SET_INT32 fmi3SetInt32 SETTABLE;
    SET_UINT32 fmi3SetUInt32 SETTABLE;
    SET_INT64 fmi3SetInt64 SETTABLE;
    SET_UINT64 fmi3SetUInt64 SETTABLE;
    SET_BOOLEAN fmi3SetBoolean SETTABLE;
    SET_STRING fmi3SetString SETTABLE;
    SET_BINARY fmi3SetBinary SETTABLE;
    SET_CLOCK fmi3SetClock SETTABLE;
    GET_NUMBER_OF_DEPENDENCIES fmi3GetNumberOfVariableDependencies ALIVE;
    GET_DEPENDENCIES fmi3GetVariableDependencies ALIVE;
    GET_STATE fmi3GetFMUState ALIVE;
    SET_STATE fmi3SetFMUState ALIVE;
    FREE_STATE fmi3FreeFMUState ALIVE;
    SERIALIZED_SIZE fmi3SerializedFMUStateSize ALIVE;
    SERIALIZE fmi3SerializeFMUState ALIVE;
    DESERIALIZE fmi3DeserializeFMUState ALIVE;
    DIRECTIONAL_DERIVATIVE fmi3GetDirectionalDerivative DERIVABLE;
    ADJOINT_DERIVATIVE fmi3GetAdjointDerivative DERIVABLE;
    ENTER_CONFIGURATION fmi3EnterConfigurationMode ALIVE;
    EXIT_CONFIGURATION fmi3ExitConfigurationMode ALIVE;
    GET_INTERVAL_DECIMAL fmi3GetIntervalDecimal ALIVE;
    GET_INTERVAL_FRACTION fmi3GetIntervalFraction ALIVE;
    GET_SHIFT_DECIMAL fmi3GetShiftDecimal ALIVE;
    GET_SHIFT_FRACTION fmi3GetShiftFraction ALIVE;
    SET_INTERVAL_DECIMAL fmi3SetIntervalDecimal ALIVE;
    SET_INTERVAL_FRACTION fmi3SetIntervalFraction ALIVE;
    SET_SHIFT_DECIMAL fmi3SetShiftDecimal ALIVE;
    SET_SHIFT_FRACTION fmi3SetShiftFraction ALIVE;
    EVALUATE_DISCRETE_STATES fmi3EvaluateDiscreteStates ALIVE;
    UPDATE_DISCRETE_STATES fmi3UpdateDiscreteStates &[Event];
    ENTER_CONTINUOUS_TIME fmi3EnterContinuousTimeMode &[Event];
    COMPLETED_STEP fmi3CompletedIntegratorStep &[Continuous];
    SET_TIME fmi3SetTime &[Event, Continuous];
    SET_STATES fmi3SetContinuousStates &[Continuous];
    GET_RATES fmi3GetContinuousStateDerivatives INTEGRABLE;
    GET_INDICATORS fmi3GetEventIndicators INTEGRABLE;
    GET_STATES fmi3GetContinuousStates INTEGRABLE;
    GET_NOMINALS fmi3GetNominalsOfContinuousStates ALIVE;
    COUNT_INDICATORS fmi3GetNumberOfEventIndicators ALIVE;
    COUNT_STATES fmi3GetNumberOfContinuousStates ALIVE;
    ENTER_STEP_MODE fmi3EnterStepMode ALIVE;
    GET_OUTPUT_DERIVATIVES fmi3GetOutputDerivatives &[StepComplete, StepFailed, Terminated, Error, Intermediate];
    DO_STEP fmi3DoStep &[StepComplete];
    GO_ON fmi3DoStep &[Intermediate];
    ACTIVATE_PARTITION fmi3ActivateModelPartition ALIVE;
}
