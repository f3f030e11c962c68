//! The functions of FMI 2.0 with the phases in which they may be called (standard 2.0.4, sections 3.2.3 and 4.2.4).

use crate::boundary::phase::Phase::{
    Continuous, Error, Event, Initialization, Instantiated, StepComplete, StepFailed, Terminated,
};
use crate::boundary::phase::{ALIVE, DERIVABLE, INTEGRABLE, READABLE, SETTABLE, functions};

functions! {
    Two:
    SET_DEBUG_LOGGING fmi2SetDebugLogging ALIVE;
    SETUP_EXPERIMENT fmi2SetupExperiment &[Instantiated];
    ENTER_INITIALIZATION fmi2EnterInitializationMode &[Instantiated];
    EXIT_INITIALIZATION fmi2ExitInitializationMode &[Initialization];
    TERMINATE fmi2Terminate &[StepComplete, StepFailed, Event, Continuous];
    RESET fmi2Reset ALIVE;
    GET_REAL fmi2GetReal READABLE;
    GET_INTEGER fmi2GetInteger READABLE;
    GET_BOOLEAN fmi2GetBoolean READABLE;
    GET_STRING fmi2GetString READABLE;
    SET_REAL fmi2SetReal SETTABLE;
    SET_INTEGER fmi2SetInteger SETTABLE;
    SET_BOOLEAN fmi2SetBoolean SETTABLE;
    SET_STRING fmi2SetString SETTABLE;
    GET_STATE fmi2GetFMUstate ALIVE;
    SET_STATE fmi2SetFMUstate ALIVE;
    FREE_STATE fmi2FreeFMUstate ALIVE;
    SERIALIZED_SIZE fmi2SerializedFMUstateSize ALIVE;
    SERIALIZE fmi2SerializeFMUstate ALIVE;
    DESERIALIZE fmi2DeSerializeFMUstate ALIVE;
    DIRECTIONAL_DERIVATIVE fmi2GetDirectionalDerivative DERIVABLE;
    SET_INPUT_DERIVATIVES fmi2SetRealInputDerivatives SETTABLE;
    GET_OUTPUT_DERIVATIVES fmi2GetRealOutputDerivatives &[StepComplete, StepFailed, Terminated, Error];
    DO_STEP fmi2DoStep &[StepComplete];
    CANCEL_STEP fmi2CancelStep &[];
    ENTER_EVENT_MODE fmi2EnterEventMode &[Continuous];
    NEW_DISCRETE_STATES fmi2NewDiscreteStates &[Event];
    ENTER_CONTINUOUS_TIME fmi2EnterContinuousTimeMode &[Event];
    COMPLETED_STEP fmi2CompletedIntegratorStep &[Continuous];
    SET_TIME fmi2SetTime &[Event, Continuous];
    SET_STATES fmi2SetContinuousStates &[Continuous];
    GET_RATES fmi2GetDerivatives INTEGRABLE;
    GET_INDICATORS fmi2GetEventIndicators INTEGRABLE;
    GET_STATES fmi2GetContinuousStates INTEGRABLE;
    GET_NOMINALS fmi2GetNominalsOfContinuousStates &[Instantiated, Initialization, Event, Continuous, Terminated, Error];
    GET_STATUS fmi2GetStatus &[StepComplete, StepFailed, Terminated, Error];
    GET_REAL_STATUS fmi2GetRealStatus &[StepComplete, StepFailed, Terminated, Error];
    GET_INTEGER_STATUS fmi2GetIntegerStatus &[StepComplete, StepFailed, Terminated, Error];
    GET_BOOLEAN_STATUS fmi2GetBooleanStatus &[StepComplete, StepFailed, Terminated, Error];
    GET_STRING_STATUS fmi2GetStringStatus &[StepComplete, StepFailed, Terminated, Error];
}
