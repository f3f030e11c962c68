//! The functions of FMI 2.0, generic over the model, with the phases in which they may be called (standard 2.0.4, sections
//! 3.2.3 and 4.2.4). [`export!`](crate::export) gives them their C names.
//!
//! # Safety
//! The functions take what a C host passes, and rely on this: a component is NULL or points to at least eight readable
//! bytes, and was not freed; a pointer with a count points to that many values; strings end with NUL; a saved state is
//! NULL or was not freed. NULL in place of a value, foreign handles and calls at the wrong time are refused.
// Said above for all functions.
#![allow(clippy::missing_safety_doc)]

use super::types::{CO_SIMULATION, DO_STEP_STATUS, FALSE, LAST_SUCCESSFUL_TIME, MODEL_EXCHANGE, TERMINATED};
use crate::{
    boundary::{
        calls::{answer, c_functions, nothing},
        description::Interface,
        guard::{Handle, InstanceRequest, enter, instantiate_by},
        instance::Instance,
        logger::{Callback, Logger, c_string},
        phase::{
            ALIVE, DERIVABLE, Function, INTEGRABLE,
            Phase::{Continuous, Error, Event, Initialization, Instantiated, StepComplete, StepFailed, Terminated},
            Phases, READABLE, SETTABLE, of,
        },
        raw::{place, texts, values, values_mut},
        refusal::{Outcome, Refusal},
        values::INTEGER,
        version::Version,
    },
    model::{Model, offered},
};

/// The phases in which the results of steps can be asked for.
const STEPPED: Phases = of(&[StepComplete, StepFailed, Terminated, Error]);

c_functions! { ($) fmi2 Two, export_fmi2 makes c_functions;
    types Boolean Byte Choice CallbackFunctions Component EventInfo FmuState Integer Real Status Text ValueReference;
    texts {
        fmi2GetTypesPlatform = c"default";
        fmi2GetVersion = c"2.0";
    }
    whole {
        fmi2Instantiate(name: Text, kind: Choice, guid: Text, resources: Text, callbacks: *const CallbackFunctions,
            visible: Boolean, logging: Boolean) -> Component => make::<M>(kind, [name, guid, resources], callbacks, logging != FALSE);
        fmi2FreeInstance(component: Component) => Handle::<M>::end(component, Version::Two);
    }
    calls {
        fmi2SetDebugLogging(on: Boolean, n: usize, categories: *const Text) in ALIVE =>
            |instance| instance.set_logging(on != FALSE, &texts(categories, n, "categories")?);
        fmi2SetupExperiment(tolerance_defined: Boolean, tolerance: Real, start: Real, stop_defined: Boolean,
            stop: Real) in of(&[Instantiated]) => |instance| {
                let tolerance = (tolerance_defined != FALSE).then_some(tolerance);
                instance.setup(tolerance, start, (stop_defined != FALSE).then_some(stop))
            };
        fmi2EnterInitializationMode() in of(&[Instantiated]) => |instance| instance.enter_initialization();
        fmi2ExitInitializationMode() in of(&[Initialization]) => |instance| instance.exit_initialization();
        fmi2Terminate() in of(&[StepComplete, StepFailed, Event, Continuous]) => |instance| instance.terminate();
        fmi2Reset() in ALIVE => |instance| instance.reset();

        fmi2GetReal(vr: *const ValueReference, n: usize, value: *mut Real) in READABLE =>
            |instance| instance.get_real(values(vr, n, "vr")?, values_mut(value, n, "value")?);
        fmi2GetInteger(vr: *const ValueReference, n: usize, value: *mut Integer) in READABLE =>
            |instance| instance.get_whole(INTEGER, values(vr, n, "vr")?, values_mut(value, n, "value")?);
        fmi2GetBoolean(vr: *const ValueReference, n: usize, value: *mut Boolean) in READABLE =>
            |instance| instance.get_boolean(values(vr, n, "vr")?, values_mut(value, n, "value")?);
        fmi2GetString(vr: *const ValueReference, n: usize, value: *mut Text) in READABLE =>
            |instance| instance.get_string(values(vr, n, "vr")?, values_mut(value, n, "value")?);
        fmi2SetReal(vr: *const ValueReference, n: usize, value: *const Real) in SETTABLE =>
            |instance| instance.set_real(values(vr, n, "vr")?, values(value, n, "value")?);
        fmi2SetInteger(vr: *const ValueReference, n: usize, value: *const Integer) in SETTABLE =>
            |instance| instance.set_whole(INTEGER, values(vr, n, "vr")?, values(value, n, "value")?);
        fmi2SetBoolean(vr: *const ValueReference, n: usize, value: *const Boolean) in SETTABLE =>
            |instance| instance.set_boolean(values(vr, n, "vr")?, values(value, n, "value")?);
        fmi2SetString(vr: *const ValueReference, n: usize, value: *const Text) in SETTABLE =>
            |instance| instance.set_string(values(vr, n, "vr")?, &texts(value, n, "value")?);

        fmi2GetFMUstate(state: *mut FmuState) in ALIVE => |instance| instance.save(place(state, "FMUstate")?);
        fmi2SetFMUstate(state: FmuState) in ALIVE => |instance| instance.restore(state);
        /// NULL, and a pointer to NULL, are left alone.
        fmi2FreeFMUstate(state: *mut FmuState) in ALIVE => |instance| instance.free_state(state);
        fmi2SerializedFMUstateSize(state: FmuState, size: *mut usize) in ALIVE =>
            |instance| answer(place(size, "size")?, instance.serialize(state)?.len());
        fmi2SerializeFMUstate(state: FmuState, bytes: *mut Byte, size: usize) in ALIVE =>
            |instance| instance.serialize_to(state, bytes.cast(), size);
        fmi2DeSerializeFMUstate(bytes: *const Byte, size: usize, state: *mut FmuState) in ALIVE =>
            |instance| instance.deserialize(values(bytes.cast(), size, "serializedState")?, place(state, "FMUstate")?);

        fmi2GetDirectionalDerivative(unknowns: *const ValueReference, n_unknowns: usize,
            knowns: *const ValueReference, n_knowns: usize, direction: *const Real, derivative: *mut Real) in DERIVABLE =>
            |instance| instance.get_directional_derivative(
                values(unknowns, n_unknowns, "vUnknown_ref")?,
                values(knowns, n_knowns, "vKnown_ref")?,
                values(direction, n_knowns, "dvKnown")?,
                values_mut(derivative, n_unknowns, "dvUnknown")?,
            );
        fmi2SetRealInputDerivatives(vr: *const ValueReference, n: usize, order: *const Integer,
            value: *const Real) in SETTABLE => |instance| instance.set_input_derivatives(
                values(vr, n, "vr")?, values(order, n, "order")?, values(value, n, "value")?,
            );
        fmi2GetRealOutputDerivatives(vr: *const ValueReference, n: usize, order: *const Integer,
            value: *mut Real) in STEPPED => |instance| instance.get_output_derivatives(
                values(vr, n, "vr")?, values(order, n, "order")?, values_mut(value, n, "value")?,
            );

        /// Saved states are copies, so that it does not matter whether the host goes back to an earlier one.
        fmi2DoStep(from: Real, step: Real, no_set_state_prior: Boolean) in of(&[StepComplete]) =>
            |instance| instance.step(from, step);
        /// Steps are synchronous, so there is none to cancel: it is refused in every phase.
        fmi2CancelStep() in of(&[]) => |_| Ok(());
        /// How the last step ended.
        fmi2GetStatus(kind: Choice, value: *mut Status) in STEPPED =>
            |instance| tell(value, (kind == DO_STEP_STATUS).then_some(instance.run.last_step));
        /// The time that the last successful step has reached.
        fmi2GetRealStatus(kind: Choice, value: *mut Real) in STEPPED =>
            |instance| tell(value, (kind == LAST_SUCCESSFUL_TIME).then_some(instance.run.time));
        /// The standard defines no such status.
        fmi2GetIntegerStatus(kind: Choice, value: *mut Integer) in STEPPED => |_| tell(value, None);
        /// Whether the model wants to terminate. It never does.
        fmi2GetBooleanStatus(kind: Choice, value: *mut Boolean) in STEPPED =>
            |_| tell(value, (kind == TERMINATED).then_some(FALSE));
        /// The state of a pending step. Steps are never pending.
        fmi2GetStringStatus(kind: Choice, value: *mut Text) in STEPPED => |_| tell(value, None);

        fmi2EnterEventMode() in of(&[Continuous]) => |instance| instance.enter_event();
        fmi2NewDiscreteStates(info: *mut EventInfo) in of(&[Event]) => |instance| {
            let info = place(info, "eventInfo")?;
            let (any, next) = instance.handle_events()?;
            answer(info, EventInfo {
                new_discrete_states_needed: any.into(),
                states_changed: any.into(),
                next_event_time_defined: next.is_some().into(),
                next_event_time: next.unwrap_or_default(),
                ..EventInfo::default()
            })
        };
        fmi2EnterContinuousTimeMode() in of(&[Event]) => |instance| instance.enter_continuous();
        fmi2CompletedIntegratorStep(no_set_state_prior: Boolean, enter_event_mode: *mut Boolean,
            terminate: *mut Boolean) in of(&[Continuous]) =>
            |instance| {
                let (event, terminate) = (place(enter_event_mode, "enterEventMode")?, place(terminate, "terminateSimulation")?);
                *event = instance.complete_step()?.into();
                nothing([terminate])
            };
        fmi2SetTime(time: Real) in of(&[Event, Continuous]) => |instance| instance.set_time(time);
        fmi2SetContinuousStates(x: *const Real, n: usize) in of(&[Continuous]) =>
            |instance| instance.set_states(values(x, n, "values")?);
        fmi2GetDerivatives(rates: *mut Real, n: usize) in INTEGRABLE =>
            |instance| instance.get_rates(values_mut(rates, n, "values")?);
        fmi2GetEventIndicators(indicators: *mut Real, n: usize) in INTEGRABLE =>
            |instance| instance.get_indicators(values_mut(indicators, n, "values")?);
        fmi2GetContinuousStates(x: *mut Real, n: usize) in INTEGRABLE =>
            |instance| instance.get_states(values_mut(x, n, "values")?);
        fmi2GetNominalsOfContinuousStates(nominals: *mut Real, n: usize)
            in of(&[Instantiated, Initialization, Event, Continuous, Terminated, Error]) =>
            |instance| instance.get_nominals(values_mut(nominals, n, "values")?);
    }
}

/// Makes an instance from its name, the GUID that the host knows, and the folder of the resources.
///
/// # Safety
/// As for all functions.
unsafe fn make<M: Model>(
    kind: Choice,
    texts: [Text; 3],
    callbacks: *const CallbackFunctions,
    logging: bool,
) -> Component {
    let logger = |name: &str| {
        // SAFETY: as the host vouches. The struct is copied, as hosts may keep it on their stack.
        let callbacks = unsafe { values(callbacks, 1, "functions") }.ok()?[0];
        let callback = (callbacks.logger).map(|logger| Callback::Two(logger, c_string(name)));
        Some(Logger::new(callback, callbacks.component_environment, logging))
    };
    let check = || match (kind, offered::<M>()) {
        (CO_SIMULATION, _) => Ok(InstanceRequest::of(Version::Two, Interface::CoSimulation)),
        (MODEL_EXCHANGE, Some(_)) => Ok(InstanceRequest::of(Version::Two, Interface::ModelExchange)),
        (_, offered) => Err(Refusal::Argument {
            name: "fmuType",
            value: kind.to_string(),
            why: match offered {
                Some(_) => "it must be Model Exchange (0) or Co-Simulation (1)",
                None => "this FMU supports Co-Simulation (1) only",
            },
        }),
    };
    let kind = (Version::Two, kind == MODEL_EXCHANGE);
    // SAFETY: as the host vouches.
    unsafe { instantiate_by::<M>("fmi2Instantiate", kind, texts, logger, check) }
}

/// Answers one of the `fmi2GetXxxStatus` functions.
///
/// # Safety
/// As for all functions.
unsafe fn tell<T>(value: *mut T, known: Option<T>) -> Outcome {
    // SAFETY: as the host vouches.
    let place = unsafe { place(value, "value") }?;
    answer(place, known.ok_or(Refusal::Unsupported("this kind of status is not provided"))?)
}
