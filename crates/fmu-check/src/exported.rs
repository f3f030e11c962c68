//! The functions that a binary must export.

use fmu_import::{Description, Interface, Version};

/// The functions of an FMU's version and interface, without their prefix: a binary has them all, even those of
/// capabilities that it has not (FMI 2.0.5, section 2.1.1; FMI 3.0.2, section 2.5.1).
pub fn functions(fmu: &Description) -> Vec<&'static str> {
    let lists: &[&str] = match (fmu.standard, fmu.interface) {
        (Version::Two, Interface::CoSimulation) => &[COMMON, CO_SIMULATION],
        (Version::Two, Interface::ModelExchange) => &[COMMON, MODEL_EXCHANGE],
        // Whatever the interface.
        (Version::Three, _) => &[THREE],
    };
    lists.iter().flat_map(|list| list.split(' ')).collect()
}

/// Of FMI 2.0, for both interfaces.
const COMMON: &str = "GetTypesPlatform GetVersion SetDebugLogging Instantiate FreeInstance SetupExperiment \
    EnterInitializationMode ExitInitializationMode Terminate Reset GetReal GetInteger GetBoolean \
    GetString SetReal SetInteger SetBoolean SetString GetFMUstate SetFMUstate FreeFMUstate \
    SerializedFMUstateSize SerializeFMUstate DeSerializeFMUstate GetDirectionalDerivative";

/// Of FMI 2.0 for Co-Simulation.
const CO_SIMULATION: &str = "SetRealInputDerivatives GetRealOutputDerivatives DoStep CancelStep GetStatus GetRealStatus \
    GetIntegerStatus GetBooleanStatus GetStringStatus";

/// Of FMI 2.0 for Model Exchange.
const MODEL_EXCHANGE: &str = "EnterEventMode NewDiscreteStates EnterContinuousTimeMode CompletedIntegratorStep SetTime \
    SetContinuousStates GetDerivatives GetEventIndicators GetContinuousStates \
    GetNominalsOfContinuousStates";

/// Of FMI 3.0.
const THREE: &str = "ActivateModelPartition CompletedIntegratorStep DeserializeFMUState DoStep \
    EnterConfigurationMode EnterContinuousTimeMode EnterEventMode EnterInitializationMode \
    EnterStepMode EvaluateDiscreteStates ExitConfigurationMode ExitInitializationMode FreeFMUState \
    FreeInstance GetAdjointDerivative GetBinary GetBoolean GetClock GetContinuousStateDerivatives \
    GetContinuousStates GetDirectionalDerivative GetEventIndicators GetFMUState GetFloat32 \
    GetFloat64 GetInt16 GetInt32 GetInt64 GetInt8 GetIntervalDecimal GetIntervalFraction \
    GetNominalsOfContinuousStates GetNumberOfContinuousStates GetNumberOfEventIndicators \
    GetNumberOfVariableDependencies GetOutputDerivatives GetShiftDecimal GetShiftFraction GetString \
    GetUInt16 GetUInt32 GetUInt64 GetUInt8 GetVariableDependencies GetVersion \
    InstantiateCoSimulation InstantiateModelExchange InstantiateScheduledExecution Reset \
    SerializeFMUState SerializedFMUStateSize SetBinary SetBoolean SetClock SetContinuousStates \
    SetDebugLogging SetFMUState SetFloat32 SetFloat64 SetInt16 SetInt32 SetInt64 SetInt8 \
    SetIntervalDecimal SetIntervalFraction SetShiftDecimal SetShiftFraction SetString SetTime \
    SetUInt16 SetUInt32 SetUInt64 SetUInt8 Terminate UpdateDiscreteStates";
