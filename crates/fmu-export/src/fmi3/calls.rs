//! The functions of FMI 3.0, generic over the model, with the phases in which they may be called (standard 3.0.2, sections
//! 2.3.1, 3.2.1 and 4.2.1). [`export!`](crate::export) gives them their C names.
//!
//! A discarded step leaves an instance in step mode. Functions for what this boundary does not offer must be there, as
//! importers look for all of the standard; they can be called at any time, touch no argument, say what is missing, and end
//! with `fmi3Error`.
//!
//! # Safety
//! The functions take what a C host passes, and rely on this: an instance is NULL or points to at least eight readable
//! bytes, and was not freed; a pointer with a count points to that many values; strings end with NUL; a saved state is
//! NULL or was not freed. NULL in place of a value, foreign handles and calls at the wrong time are refused.
// Said above for all functions.
#![allow(clippy::missing_safety_doc)]
// As many as the standard says.
#![allow(clippy::too_many_arguments)]

use std::{borrow::Cow, iter::repeat_n};

use super::types::FALSE;
use crate::{
    boundary::{
        calls::{answer, c_functions, nothing},
        description::Interface,
        guard::{Handle, InstanceRequest, enter, instantiate_by},
        instance::Instance,
        logger::{Callback, Logger},
        lookup::{all_elements, size},
        phase::{
            ALIVE, DERIVABLE, Function, INTEGRABLE,
            Phase::{
                Continuous, Error, Event, Initialization, Instantiated, Intermediate, StepComplete, StepFailed,
                Terminated,
            },
            SETTABLE, VISIBLE, of,
        },
        raw::{place, texts, values, values_mut},
        refusal::{Outcome, Refusal},
        values::{INT32, INT64},
        version::Version,
        watch::Watch,
    },
    model::{Model, events, offered},
};

const NO_CLOCKS: Outcome = Err(Refusal::Absent("this FMU has no input clocks"));
const NO_EVALUATION: Outcome =
    Err(Refusal::Absent("this FMU evaluates no discrete states apart from fmi3UpdateDiscreteStates"));
const NO_STRUCTURE: Outcome = Err(Refusal::Absent("this FMU has no structural parameters"));
const NO_ELEMENTS: Outcome = Err(Refusal::Absent("this FMU provides no dependencies of single elements"));

/// The table, the functions for values of a type, and those for types that no variable of a model is of: they tell so.
macro_rules! with_types {
    (
        {$($read:ident, $write:ident: $of:ty, $by:ident $to:ident($($kind:expr)?);)*}
        {$($get:ident, $set:ident: $type:ty, $name:literal;)*}
        {$($before:tt)*}
        calls {$($calls:tt)*}
    ) => {
        c_functions! { $($before)*
            calls {
                $($calls)*
                $(
                    $read(vr: *const ValueReference, n: usize, value: *mut $of, n_values: usize) in VISIBLE =>
                        |instance| instance
                            .$by($($kind,)? &for_values::<M>(vr, n, n_values)?, values_mut(value, n_values, "values")?);
                    $write(vr: *const ValueReference, n: usize, value: *const $of, n_values: usize) in SETTABLE =>
                        |instance| instance
                            .$to($($kind,)? &for_values::<M>(vr, n, n_values)?, values(value, n_values, "values")?);
                )*
                $(
                    $get(vr: *const ValueReference, n: usize, value: *mut $type, n_values: usize) in VISIBLE =>
                        |instance| instance.refuse_type(references(vr, n)?, $name);
                    $set(vr: *const ValueReference, n: usize, value: *const $type, n_values: usize) in SETTABLE =>
                        |instance| instance.refuse_type(references(vr, n)?, $name);
                )*
            }
        }
    };
}

with_types! {
    {
        fmi3GetFloat64, fmi3SetFloat64: Real, get_real set_real();
        fmi3GetInt32, fmi3SetInt32: i32, get_whole set_whole(INT32);
        fmi3GetInt64, fmi3SetInt64: i64, get_whole set_whole(INT64);
        fmi3GetBoolean, fmi3SetBoolean: Boolean, get_boolean set_boolean();
    }
    {
        fmi3GetFloat32, fmi3SetFloat32: f32, "Float32";
        fmi3GetInt8, fmi3SetInt8: i8, "Int8";
        fmi3GetUInt8, fmi3SetUInt8: u8, "UInt8";
        fmi3GetInt16, fmi3SetInt16: i16, "Int16";
        fmi3GetUInt16, fmi3SetUInt16: u16, "UInt16";
        fmi3GetUInt32, fmi3SetUInt32: u32, "UInt32";
        fmi3GetUInt64, fmi3SetUInt64: u64, "UInt64";
    }
    { ($) fmi3 Three, export_fmi3 makes fmi3_functions;
    types Binary Boolean Byte Component ComponentEnvironment FmuState IntermediateUpdateCallback LogMessageCallback Real Status Text
        Unused ValueReference;
    texts { fmi3GetVersion = c"3.0"; }
    whole {
        fmi3InstantiateModelExchange(name: Text, token: Text, resources: Text, visible: Boolean,
            logging: Boolean, environment: ComponentEnvironment, log: Option<LogMessageCallback>) -> Component => {
                let check = || match offered::<M>() {
                    Some(_) => Ok(InstanceRequest::of(Version::Three, Interface::ModelExchange)),
                    None => Err(Refusal::Absent("this FMU supports Co-Simulation only")),
                };
                let logger = Logger::new(log.map(Callback::Three), environment, logging != FALSE);
                let form = (Version::Three, true);
                instantiate_by::<M>("fmi3InstantiateModelExchange", form, [name, token, resources], |_| Some(logger), check)
            };
        /// Without a callback for intermediate updates, or for a model without inner steps, it does not matter which variables
        /// the host would want then, nor whether it allows early returns.
        fmi3InstantiateCoSimulation(name: Text, token: Text, resources: Text, visible: Boolean,
            logging: Boolean, event_mode: Boolean, early_return: Boolean, intermediate: *const ValueReference,
            n_intermediate: usize, environment: ComponentEnvironment, log: Option<LogMessageCallback>,
            update: Option<IntermediateUpdateCallback>) -> Component => {
                let check = || {
                    let mut known = InstanceRequest::of(Version::Three, Interface::CoSimulation);
                    if event_mode != FALSE {
                        known.event_mode = events::<M>().map(|_| early_return != FALSE);
                        return known.event_mode.map(|_| known).ok_or(Refusal::Argument {
                            name: "eventModeUsed",
                            value: "fmi3True".to_owned(),
                            why: "this FMU has no event mode",
                        });
                    }
                    if let (Some(update), Some(inner_step)) = (update, M::INNER_STEP) {
                        let variables = values(intermediate, n_intermediate, "requiredIntermediateVariables")?;
                        known.watch = Some(Watch::new(update, environment, early_return != FALSE, variables, inner_step)?);
                    }
                    Ok(known)
                };
                let logger = Logger::new(log.map(Callback::Three), environment, logging != FALSE);
                let form = (Version::Three, false);
                instantiate_by::<M>("fmi3InstantiateCoSimulation", form, [name, token, resources], |_| Some(logger), check)
            };
        /// Refused.
        fmi3InstantiateScheduledExecution(name: Text, token: Text, resources: Text,
            visible: Boolean, logging: Boolean, environment: ComponentEnvironment, log: Option<LogMessageCallback>,
            update: Unused, lock: Unused, unlock: Unused) -> Component => {
                let logger = Logger::new(log.map(Callback::Three), environment, logging != FALSE);
                let check = || Err(Refusal::Absent("this FMU has no input clocks: it supports no Scheduled Execution"));
                let form = (Version::Three, false);
                instantiate_by::<M>("fmi3InstantiateScheduledExecution", form, [name, token, resources], |_| Some(logger), check)
            };
        fmi3FreeInstance(component: Component) => Handle::<M>::end(component, Version::Three);
        /// After a discarded step the instance is where it was, in step mode: the host may try a shorter one. A host that
        /// looks into the step is called while the instance is free for it.
        fmi3DoStep(component: Component, from: Real, step: Real, no_set_state_prior: Boolean,
            event_handling_needed: *mut Boolean, terminate_simulation: *mut Boolean, early_return: *mut Boolean,
            last_successful_time: *mut Real) -> Status =>
            take_step::<M>(component, from, step, [event_handling_needed, terminate_simulation, early_return], last_successful_time);
    }
    }
    calls {
        fmi3SetDebugLogging(on: Boolean, n: usize, categories: *const Text) in ALIVE =>
            |instance| instance.set_logging(on != FALSE, &texts(categories, n, "categories")?);
        fmi3EnterInitializationMode(tolerance_defined: Boolean, tolerance: Real, start: Real,
            stop_defined: Boolean, stop: Real) in of(&[Instantiated]) => |instance| {
                let tolerance = (tolerance_defined != FALSE).then_some(tolerance);
                instance.setup(tolerance, start, (stop_defined != FALSE).then_some(stop))?;
                instance.enter_initialization()
            };
        fmi3ExitInitializationMode() in of(&[Initialization]) => |instance| instance.exit_initialization();
        fmi3EnterEventMode() in of(&[StepComplete, Continuous]) => |instance| instance.enter_event();
        fmi3Terminate() in of(&[StepComplete, Event, Continuous]) => |instance| instance.terminate();
        fmi3Reset() in ALIVE => |instance| instance.reset();

        fmi3GetString(vr: *const ValueReference, n: usize, value: *mut Text, n_values: usize) in VISIBLE =>
            |instance| instance.get_string(&for_values::<M>(vr, n, n_values)?, values_mut(value, n_values, "values")?);
        fmi3GetBinary(vr: *const ValueReference, n: usize, sizes: *mut usize, value: *mut Binary, n_values: usize)
            in VISIBLE => |instance| instance.refuse_type(references(vr, n)?, "Binary");
        fmi3GetClock(vr: *const ValueReference, n: usize, value: *mut Boolean) in VISIBLE =>
            |instance| instance.get_clock(references(vr, n)?, values_mut(value, n, "values")?);

        fmi3SetString(vr: *const ValueReference, n: usize, value: *const Text, n_values: usize) in SETTABLE =>
            |instance| instance.set_string(&for_values::<M>(vr, n, n_values)?, &texts(value, n_values, "values")?);
        fmi3SetBinary(vr: *const ValueReference, n: usize, sizes: *const usize, value: *const Binary, n_values: usize)
            in SETTABLE => |instance| instance.refuse_type(references(vr, n)?, "Binary");
        fmi3SetClock(vr: *const ValueReference, n: usize, value: *const Boolean) in SETTABLE =>
            |instance| instance.set_clock(references(vr, n)?, values(value, n, "values")?);

        fmi3GetNumberOfVariableDependencies(vr: ValueReference, n: *mut usize) in ALIVE =>
            |_| NO_ELEMENTS;
        fmi3GetVariableDependencies(dependent: ValueReference, elements: *mut usize,
            independents: *mut ValueReference, independent_elements: *mut usize, kinds: *mut i32, n: usize) in ALIVE =>
            |_| NO_ELEMENTS;

        fmi3GetFMUState(state: *mut FmuState) in ALIVE => |instance| instance.save(place(state, "FMUState")?);
        fmi3SetFMUState(state: FmuState) in ALIVE => |instance| instance.restore(state);
        /// NULL, and a pointer to NULL, are left alone.
        fmi3FreeFMUState(state: *mut FmuState) in ALIVE => |instance| instance.free_state(state);
        fmi3SerializedFMUStateSize(state: FmuState, size: *mut usize) in ALIVE =>
            |instance| answer(place(size, "size")?, instance.serialize(state)?.len());
        fmi3SerializeFMUState(state: FmuState, bytes: *mut Byte, size: usize) in ALIVE =>
            |instance| instance.serialize_to(state, bytes, size);
        fmi3DeserializeFMUState(bytes: *const Byte, size: usize, state: *mut FmuState) in ALIVE =>
            |instance| instance.deserialize(values(bytes, size, "serializedState")?, place(state, "FMUState")?);

        fmi3GetDirectionalDerivative(unknowns: *const ValueReference, n_unknowns: usize,
            knowns: *const ValueReference, n_knowns: usize, seed: *const Real, n_seed: usize, sensitivity: *mut Real,
            n_sensitivity: usize) in DERIVABLE => |instance| {
                let knowns = elements::<M>(knowns, n_knowns, "knowns", ("nSeed", n_seed))?;
                let unknowns = elements::<M>(unknowns, n_unknowns, "unknowns", ("nSensitivity", n_sensitivity))?;
                let (seed, sensitivity) = (values(seed, n_seed, "seed")?, values_mut(sensitivity, n_sensitivity, "sensitivity")?);
                instance.get_directional_derivative(&unknowns, &knowns, seed, sensitivity)
            };
        fmi3GetAdjointDerivative(unknowns: *const ValueReference, n_unknowns: usize,
            knowns: *const ValueReference, n_knowns: usize, seed: *const Real, n_seed: usize, sensitivity: *mut Real,
            n_sensitivity: usize) in DERIVABLE => |instance| {
                let unknowns = elements::<M>(unknowns, n_unknowns, "unknowns", ("nSeed", n_seed))?;
                let knowns = elements::<M>(knowns, n_knowns, "knowns", ("nSensitivity", n_sensitivity))?;
                let (seed, sensitivity) = (values(seed, n_seed, "seed")?, values_mut(sensitivity, n_sensitivity, "sensitivity")?);
                instance.get_adjoint_derivative(&unknowns, &knowns, seed, sensitivity)
            };
        fmi3GetOutputDerivatives(vr: *const ValueReference, n: usize, orders: *const i32, value: *mut Real,
            n_values: usize) in of(&[StepComplete, StepFailed, Terminated, Error, Intermediate]) => |instance| {
                let all = for_values::<M>(vr, n, n_values)?;
                let given = references(vr, n)?.iter().zip(values(orders, n, "orders")?);
                let orders: Vec<i32> = given.flat_map(|(first, order)| repeat_n(*order, size::<M>(*first))).collect();
                instance.get_output_derivatives(&all, &orders, values_mut(value, n_values, "values")?)
            };

        fmi3EnterConfigurationMode() in ALIVE => |_| NO_STRUCTURE;
        fmi3ExitConfigurationMode() in ALIVE => |_| NO_STRUCTURE;
        fmi3GetIntervalDecimal(vr: *const ValueReference, n: usize, intervals: *mut Real,
            qualifiers: *mut i32) in ALIVE => |_| NO_CLOCKS;
        fmi3GetIntervalFraction(vr: *const ValueReference, n: usize, counters: *mut u64,
            resolutions: *mut u64, qualifiers: *mut i32) in ALIVE => |_| NO_CLOCKS;
        fmi3GetShiftDecimal(vr: *const ValueReference, n: usize, shifts: *mut Real) in ALIVE => |_| NO_CLOCKS;
        fmi3GetShiftFraction(vr: *const ValueReference, n: usize, counters: *mut u64, resolutions: *mut u64)
            in ALIVE => |_| NO_CLOCKS;
        fmi3SetIntervalDecimal(vr: *const ValueReference, n: usize, intervals: *const Real) in ALIVE =>
            |_| NO_CLOCKS;
        fmi3SetIntervalFraction(vr: *const ValueReference, n: usize, counters: *const u64,
            resolutions: *const u64) in ALIVE => |_| NO_CLOCKS;
        fmi3SetShiftDecimal(vr: *const ValueReference, n: usize, shifts: *const Real) in ALIVE => |_| NO_CLOCKS;
        fmi3SetShiftFraction(vr: *const ValueReference, n: usize, counters: *const u64,
            resolutions: *const u64) in ALIVE => |_| NO_CLOCKS;
        fmi3ActivateModelPartition(clock: ValueReference, time: Real) in ALIVE => |_| NO_CLOCKS;
        fmi3EnterStepMode() in ALIVE => |instance| instance.enter_step();
        fmi3EvaluateDiscreteStates() in ALIVE => |_| NO_EVALUATION;

        fmi3UpdateDiscreteStates(again: *mut Boolean, terminate: *mut Boolean, nominals: *mut Boolean,
            states: *mut Boolean, defined: *mut Boolean, time: *mut Real) in of(&[Event]) => |instance| {
                let (again, states) =
                    (place(again, "discreteStatesNeedUpdate")?, place(states, "valuesOfContinuousStatesChanged")?);
                let never = [place(terminate, "terminateSimulation")?, place(nominals, "nominalsOfContinuousStatesChanged")?];
                let (defined, time) = (place(defined, "nextEventTimeDefined")?, place(time, "nextEventTime")?);
                let (any, next) = instance.handle_events()?;
                (*again, *states) = (any.into(), any.into());
                (*defined, *time) = (next.is_some().into(), next.unwrap_or_default());
                nothing(never)
            };
        fmi3EnterContinuousTimeMode() in of(&[Event]) => |instance| instance.enter_continuous();
        fmi3CompletedIntegratorStep(no_set_state_prior: Boolean, enter_event_mode: *mut Boolean,
            terminate: *mut Boolean) in of(&[Continuous]) =>
            |instance| {
                let (event, terminate) = (place(enter_event_mode, "enterEventMode")?, place(terminate, "terminateSimulation")?);
                *event = instance.complete_step()?.into();
                nothing([terminate])
            };
        fmi3SetTime(time: Real) in of(&[Event, Continuous]) => |instance| instance.set_time(time);
        fmi3SetContinuousStates(states: *const Real, n: usize) in of(&[Continuous]) =>
            |instance| instance.set_states(values(states, n, "values")?);
        fmi3GetContinuousStateDerivatives(rates: *mut Real, n: usize) in INTEGRABLE =>
            |instance| instance.get_rates(values_mut(rates, n, "values")?);
        fmi3GetEventIndicators(indicators: *mut Real, n: usize) in INTEGRABLE =>
            |instance| instance.get_indicators(values_mut(indicators, n, "values")?);
        fmi3GetContinuousStates(states: *mut Real, n: usize) in INTEGRABLE =>
            |instance| instance.get_states(values_mut(states, n, "values")?);
        fmi3GetNominalsOfContinuousStates(nominals: *mut Real, n: usize) in ALIVE =>
            |instance| instance.get_nominals(values_mut(nominals, n, "values")?);
        fmi3GetNumberOfEventIndicators(n: *mut usize) in ALIVE => |instance| {
            let indicators = instance.indicators()?;
            answer(place(n, "nEventIndicators")?, indicators)
        };
        fmi3GetNumberOfContinuousStates(n: *mut usize) in ALIVE => |instance| {
            let states = instance.states()?;
            answer(place(n, "nContinuousStates")?, states)
        };
    }
}

/// The value references for `n` values.
///
/// # Safety
/// As for all functions.
unsafe fn references<'a>(vr: *const ValueReference, n: usize) -> Outcome<&'a [ValueReference]> {
    // SAFETY: as the host vouches.
    unsafe { values(vr, n, "valueReferences") }
}

/// The value references of all elements, for as many values.
///
/// # Safety
/// As for all functions.
unsafe fn for_values<'a, M: Model>(
    vr: *const ValueReference,
    n: usize,
    n_values: usize,
) -> Outcome<Cow<'a, [ValueReference]>> {
    // SAFETY: as the host vouches.
    unsafe { elements::<M>(vr, n, "valueReferences", ("nValues", n_values)) }
}

/// The value references of all elements, and a check that there is one value for each.
///
/// # Safety
/// As for all functions.
unsafe fn elements<'a, M: Model>(
    vr: *const ValueReference,
    n: usize,
    name: &'static str,
    (counted, given): (&'static str, usize),
) -> Outcome<Cow<'a, [ValueReference]>> {
    // SAFETY: as the host vouches.
    let elements = all_elements::<M>(unsafe { values(vr, n, name) }?);
    if given == elements.len() {
        return Ok(elements);
    }
    Err(Refusal::Argument {
        name: counted,
        value: given.to_string(),
        why: "there must be a value for each scalar, and for each element of an array",
    })
}

/// Takes a communication step, and asks the host within it if it wants to be asked.
///
/// # Safety
/// As for all functions.
unsafe fn take_step<M: Model>(
    component: Component,
    from: Real,
    step: Real,
    [event_handling_needed, terminate_simulation, early_return]: [*mut Boolean; 3],
    last_successful_time: *mut Real,
) -> Status {
    let function = |phase| Function { name: "fmi3DoStep", version: Version::Three, phases: of(&[phase]) };
    let (mut answer, mut pause) = (None, None);
    loop {
        let body = |instance: &mut Instance<M>| {
            // SAFETY: as the host vouches.
            let (flags, early, reached) = unsafe {
                (
                    [
                        place(event_handling_needed, "eventHandlingNeeded")?,
                        place(terminate_simulation, "terminateSimulation")?,
                    ],
                    place(early_return, "earlyReturn")?,
                    place(last_successful_time, "lastSuccessfulTime")?,
                )
            };
            let outcome = match answer {
                None => instance.begin_step(from, step),
                Some(answer) => instance.go_on(answer),
            };
            let [event, terminate] = flags;
            *event = (outcome.is_ok() && instance.event_due).into();
            *terminate = FALSE;
            *early = (outcome.is_ok() && instance.run.time < from + step).into();
            *reached = instance.run.time;
            if instance.run.phase == StepFailed {
                instance.run.phase = StepComplete;
            }
            pause = outcome?;
            Ok(())
        };
        let begins = answer.is_none();
        let function = function(if begins { StepComplete } else { Intermediate });
        // SAFETY: as the host vouches; it cannot free the instance in its callback.
        let status = unsafe { enter(component, &function, body) };
        match pause.take() {
            None => return status,
            Some(update) => answer = Some(update.ask()),
        }
    }
}
