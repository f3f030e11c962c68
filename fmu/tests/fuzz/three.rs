//! FMI 3.0.

use std::ffi::CString;
use std::ptr::null;

use fmu_export::description::{self, Version};
use fmu_export::fmi3::types::*;
use fmu_export::model::Kind;
use plain_bearing_stand::fmi3_functions::*;
use plain_bearing_stand::stand::Stand;

use crate::host::{Host, Interface, Log, Plain, hidden, named, reference_of};
use crate::random::Random;
use crate::values::*;
use crate::{absent, exchange, states};

/// The value reference of time.
const TIME: ValueReference = i32::MAX as ValueReference;

pub static INTERFACE: Interface = Interface {
    acts: &[
        (20, step),
        (20, get_float64),
        (4, get_int32),
        (4, get_int64),
        (4, get_boolean),
        (4, get_string),
        (14, set_float64),
        (4, set_int32),
        (4, set_int64),
        (3, set_boolean),
        (3, set_string),
        (4, get_output_rates),
        (2, directional),
        (1, adjoint),
        (8, absent::act),
        (2, logging),
        (20, exchange::act),
    ],
    instantiate,
    instantiates: ["fmi3InstantiateCoSimulation", "fmi3InstantiateModelExchange"],
    enter,
    set_integers: |host, component, references, values| {
        let function = |c, from, n, value| set_int32s(c, from, n, value, n);
        let both = (references, values);
        set(host, component, "fmi3SetInt32", both, function);
    },
    exit: named!(fmi3ExitInitializationMode),
    terminate: named!(fmi3Terminate),
    reset: named!(fmi3Reset),
    free: named!(fmi3FreeInstance),
    states: states::Functions {
        get: named!(fmi3GetFMUState),
        set: named!(fmi3SetFMUState),
        free: named!(fmi3FreeFMUState),
        size: named!(fmi3SerializedFMUStateSize),
        serialize: named!(fmi3SerializeFMUState),
        deserialize: named!(fmi3DeserializeFMUState),
    },
    exchange: exchange::Functions {
        enter_event: named!(fmi3EnterEventMode),
        enter_continuous: named!(fmi3EnterContinuousTimeMode),
        set_time: named!(fmi3SetTime),
        set_states: named!(fmi3SetContinuousStates),
        get_states: named!(fmi3GetContinuousStates),
        get_rates: named!(fmi3GetContinuousStateDerivatives),
        get_nominals: named!(fmi3GetNominalsOfContinuousStates),
        get_indicators: named!(fmi3GetEventIndicators),
        tell,
        count: Some([named!(fmi3GetNumberOfContinuousStates), named!(fmi3GetNumberOfEventIndicators)]),
    },
};

unsafe extern "C" fn logger(environment: ComponentEnvironment, status: Status, category: Text, message: Text) {
    // SAFETY: the boundary sends C strings, and the environment that it was given.
    unsafe { Log::hear(environment, status, category, message) }
}

/// The variables that a host announces when it looks into steps: one input and two outputs.
fn announced() -> [ValueReference; 3] {
    ["drive.speed", "sensor.loadForce", "drive.angle"].map(reference_of)
}

/// The host looks into a step: it reads and sets what it may and what it may not, calls what it must not, and now and then
/// wants the step to end, allowed or not.
unsafe extern "C" fn update(
    environment: ComponentEnvironment,
    time: f64,
    set: bool,
    get: bool,
    finished: bool,
    early: bool,
    requested: *mut u8,
    at: *mut f64,
) {
    // SAFETY: the environment is the host's log, which lives as long as the host.
    let log = unsafe { &*environment.cast::<Log>() };
    let Some(c) = log.busy.get() else {
        panic!("an update outside of a step");
    };
    assert!(get && finished && time.is_finite() && (set || !early));
    log.updates.set(log.updates.get() + 1);
    let mut random = Random(log.random.get());
    let [input, output, other] = announced();
    let mut value = f64::NAN;
    let speed = random.magnitude(1.0, 300.0);
    // SAFETY: the instance is at work, and alive; the places are ours.
    let (status, expected) = unsafe {
        match random.below(12) {
            0 | 1 => {
                let status = fmi3SetFloat64(c, &input, 1, &speed, 1);
                (status, if set { Status::Ok } else { Status::Error })
            }
            2 => (fmi3SetFloat64(c, &output, 1, &speed, 1), Status::Error),
            3 => (fmi3SetFloat64(c, &3, 1, &speed, 1), Status::Error),
            4 => (fmi3GetFloat64(c, &TIME, 1, &mut value, 1), Status::Error),
            5 => {
                let function = random.one(&[
                    fmi3Reset as Plain,
                    fmi3Terminate,
                    fmi3ExitInitializationMode,
                    fmi3EnterEventMode,
                    fmi3EnterContinuousTimeMode,
                ]);
                (function(c), Status::Error)
            }
            6 => {
                fmi3FreeInstance(c);
                let (mut a, mut b, mut d) = (9, 9, 9);
                let places = (&raw mut a, &raw mut b, &raw mut d);
                let status = fmi3DoStep(c, time, 1e-3, TRUE, places.0, places.1, places.2, &mut value);
                (status, Status::Error)
            }
            7 => {
                let mut state = std::ptr::null_mut();
                (fmi3GetFMUState(c, &mut state), Status::Error)
            }
            8 => {
                let both = [output, other];
                let status = fmi3GetOutputDerivatives(c, both.as_ptr(), 1, &1, &mut value, 1);
                (status, status)
            }
            _ => (fmi3GetFloat64(c, &output, 1, &mut value, 1), Status::Ok),
        }
    };
    assert_eq!(status, expected, "in an update at {time} s");
    if random.once_in(4) {
        let when = [time, time + 1e-3, random.hostile()];
        // SAFETY: the FMU's places for the answer.
        unsafe { (*requested, *at) = (random.bits() as u8, random.one(&when)) };
    }
    log.random.set(random.0);
}

fn instantiate(host: &mut Host, exchange: bool, wrong: bool) -> Component {
    let way = host.calls as usize % 5;
    let spoil = |at: usize| wrong && at == way;
    let fingerprint = if exchange == spoil(4) {
        description::fingerprint::<Stand>(Version::Three, description::Interface::CoSimulation)
    } else {
        description::fingerprint::<Stand>(Version::Three, description::Interface::ModelExchange)
    };
    // Model Exchange has no event mode that could be refused.
    let spoilt = spoil(0) || exchange && spoil(2);
    let token = host.token(description::token(fingerprint), spoilt);
    let name = match host.calls % 7 {
        _ if spoil(1) => c" ",
        0 => c"\xff %n",
        _ => c"stand",
    };
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../modelDescription/resources/");
    let folder = CString::new(folder).unwrap_or_default();
    let resources = [folder.as_c_str(), c"", c"nowhere", c"/\xff/"][host.random.one(&[0, 0, 0, 0, 1, 2, 3])];
    let (name, resources) = (name.as_ptr(), resources.as_ptr());
    let environment = host.environment();
    let log = (!host.random.once_in(10)).then_some(logger as LogMessageCallback);
    let [logging, visible, early] = [0; 3].map(|_| host.random.bits() as u8);
    let event_mode = if spoil(2) { 7 } else { FALSE };
    let token = if spoil(3) { null() } else { token.as_ptr() };
    let watches = host.random.once_in(2);
    let announced = announced();
    // Without a callback nobody looks at the variables.
    let (variables, n, update) =
        if watches { (announced.as_ptr(), announced.len(), Some(update as _)) } else { (null(), 9, None) };
    // SAFETY: NULL or what the standard asks for.
    unsafe {
        if exchange {
            return fmi3InstantiateModelExchange(name, token, resources, visible, logging, environment, log);
        }
        fmi3InstantiateCoSimulation(
            name,
            token,
            resources,
            visible,
            logging,
            event_mode,
            early,
            variables,
            n,
            environment,
            log,
            update,
        )
    }
}

/// Enters the initialization mode.
fn enter(host: &mut Host, component: Component) {
    let random = &mut host.random;
    let (with_tolerance, with_stop) = (random.below(3) as u8, u8::from(random.once_in(10)));
    let [tolerance, start, stop] = experiment(host);
    // SAFETY: an instance that is alive, NULL, or readable memory.
    host.call("fmi3EnterInitializationMode", component, |c| unsafe {
        fmi3EnterInitializationMode(c, with_tolerance, tolerance, start, with_stop, stop)
    });
}

fn step(host: &mut Host, component: Component) {
    let mut time = 0.0;
    host.call("fmi3GetFloat64", component, |c| {
        // SAFETY: as for `enter`; the place is ours.
        unsafe { fmi3GetFloat64(c, &TIME, 1, &raw mut time, 1) }
    });
    let [from, step] = crate::values::step(host, time);
    let missing = if host.random.once_in(100) { host.random.below(4) } else { 9 };
    let (mut event, mut end, mut early, mut reached) = (9, 9, 9, f64::NAN);
    let status = host.call("fmi3DoStep", component, |c| {
        // SAFETY: as for `enter`; the places are ours, or NULL.
        unsafe {
            fmi3DoStep(
                c,
                from,
                step,
                TRUE,
                hidden(&mut event, missing == 0),
                hidden(&mut end, missing == 1),
                hidden(&mut early, missing == 2),
                hidden(&mut reached, missing == 3),
            )
        }
    });
    if status == Status::Ok || status == Status::Discard {
        assert_eq!([event, end], [FALSE; 2]);
        let as_expected = match (status, early) {
            (Status::Ok, FALSE) => reached == from + step,
            (Status::Ok, _) => (from..from + step).contains(&reached),
            _ => early == FALSE && reached == time,
        };
        assert!(as_expected || host.forged.contains(&component));
    }
}

fn tell(host: &mut Host, component: Component, discrete: bool, missing: usize) -> exchange::Told {
    let mut flags = [9; 5];
    let mut next = 0.0;
    let place = |at: usize, flag| hidden(flag, missing == at);
    let [a, b, c, d, e] = &mut flags;
    let [a, b, c, d, e] = [(0, a), (1, b), (2, c), (3, d), (4, e)].map(|(at, flag)| place(at, flag));
    let next = hidden(&mut next, missing == 5);
    let prior = host.random.bits() as u8;
    // SAFETY of both: as for `enter`; the places are ours, or NULL.
    if discrete {
        let status = host.call("fmi3UpdateDiscreteStates", component, |i| {
            // SAFETY: as said above.
            unsafe { fmi3UpdateDiscreteStates(i, a, b, c, d, e, next) }
        });
        return (status, flags.map(|flag| flag != FALSE).into());
    }
    let status = host.call("fmi3CompletedIntegratorStep", component, |i| {
        // SAFETY: as said above.
        unsafe { fmi3CompletedIntegratorStep(i, prior, a, b) }
    });
    (status, vec![flags[0] != FALSE, flags[1] != FALSE])
}

fn logging(host: &mut Host, component: Component) {
    let (chosen, n) = categories(host);
    let on = host.random.bits() as u8;
    // SAFETY: up to two texts that end with NUL.
    host.call("fmi3SetDebugLogging", component, |c| unsafe { fmi3SetDebugLogging(c, on, n, chosen.as_ptr()) });
}

/// Defines accesses without their `unsafe`.
macro_rules! plain {
    ($($name:ident = $function:ident($pointer:ty);)*) => {$(
        fn $name(
            c: Component,
            references: *const ValueReference,
            n: usize,
            values: $pointer,
            n_values: usize,
        ) -> Status {
            // SAFETY: right, NULL, a count that no memory has, or counts that contradict each other.
            unsafe { $function(c, references, n, values, n_values) }
        }
    )*};
}

plain! {
    get_float64s = fmi3GetFloat64(*mut f64);
    get_int32s = fmi3GetInt32(*mut i32);
    get_int64s = fmi3GetInt64(*mut i64);
    get_booleans = fmi3GetBoolean(*mut u8);
    get_strings = fmi3GetString(*mut Text);
    set_float64s = fmi3SetFloat64(*const f64);
    set_int32s = fmi3SetInt32(*const i32);
    set_int64s = fmi3SetInt64(*const i64);
    set_booleans = fmi3SetBoolean(*const u8);
    set_strings = fmi3SetString(*const Text);
}

/// The number of values beside a number of references: the same, or now and then another, which must be refused.
fn n_values(host: &mut Host) -> impl Fn(usize, &dyn Fn(usize) -> Status) -> Status + use<> {
    let wrong = host.random.once_in(100);
    move |n, call| {
        let status = call(if wrong { n ^ 1 } else { n });
        assert!(!wrong || status == Status::Error);
        status
    }
}

/// Defines acts that read variables.
macro_rules! getters {
    ($($name:ident = $function:ident, $called:ident, $expected:expr;)*) => {$(
        fn $name(host: &mut Host, component: Component) {
            let counted = n_values(host);
            get(host, component, stringify!($function), $expected, |c, from, n, into| {
                counted(n, &|m| $called(c, from, n, into, m))
            });
        }
    )*};
}

getters! {
    get_float64 = fmi3GetFloat64, get_float64s, REALS;
    get_int32 = fmi3GetInt32, get_int32s, INT32S;
    get_int64 = fmi3GetInt64, get_int64s, INT64S;
    get_boolean = fmi3GetBoolean, get_booleans, BOOLEANS;
    get_string = fmi3GetString, get_strings, TEXTS;
}

type Expected<T> = (Fits, T, fn(&T) -> bool);

const INT32S: Expected<i32> = (|v| matches!(v.kind, Kind::Integer { .. }), i32::MIN, |value| *value != i32::MIN);
const INT64S: Expected<i64> = (|v| matches!(v.kind, Kind::Enumeration { .. }), i64::MIN, |value| *value != i64::MIN);
const BOOLEANS: Expected<u8> = (boolean, 9, |value| [0, 1].contains(value));

fn set_float64(host: &mut Host, component: Component) {
    let counted = n_values(host);
    let name = "fmi3SetFloat64";
    set_reals(host, component, name, |c, from, n, value| counted(n, &|m| set_float64s(c, from, n, value, m)));
}

fn set_int32(host: &mut Host, component: Component) {
    let references = references(host, |v| settable(v) && INT32S.0(v));
    let value = |host: &mut Host, reference: &_| integer_for(host, *reference);
    let values: Vec<_> = references.iter().map(|r| value(host, r)).collect();
    let (both, counted) = ((&*references, &*values), n_values(host));
    set(host, component, "fmi3SetInt32", both, |c, from, n, value| counted(n, &|m| set_int32s(c, from, n, value, m)));
}

fn set_int64(host: &mut Host, component: Component) {
    let references = references(host, |v| settable(v) && INT64S.0(v));
    let value = |host: &mut Host| {
        let far = [i64::MIN, i64::MAX, 1 << 32, (1 << 32) + 1];
        if host.random.once_in(10) { host.random.one(&far) } else { host.random.integer().into() }
    };
    let values: Vec<_> = references.iter().map(|_| value(host)).collect();
    let (both, counted) = ((&*references, &*values), n_values(host));
    set(host, component, "fmi3SetInt64", both, |c, from, n, value| counted(n, &|m| set_int64s(c, from, n, value, m)));
}

fn set_boolean(host: &mut Host, component: Component) {
    let references = references(host, |v| settable(v) && boolean(v));
    let value = |host: &mut Host| host.random.bits() as u8 % 3;
    let values: Vec<_> = references.iter().map(|_| value(host)).collect();
    let (both, counted) = ((&*references, &*values), n_values(host));
    set(host, component, "fmi3SetBoolean", both, |c, from, n, value| {
        counted(n, &|m| set_booleans(c, from, n, value, m))
    });
}

fn set_string(host: &mut Host, component: Component) {
    let counted = n_values(host);
    set_texts(host, component, "fmi3SetString", |c, from, n, value| counted(n, &|m| set_strings(c, from, n, value, m)));
}

fn get_output_rates(host: &mut Host, component: Component) {
    let counted = n_values(host);
    let name = "fmi3GetOutputDerivatives";
    get_rates(host, component, name, |c, from, n, orders, into| {
        // SAFETY: right, NULL, a count that no memory has, or counts that contradict each other.
        counted(n, &|m| unsafe { fmi3GetOutputDerivatives(c, from, n, orders, into, m) })
    });
}

fn directional(host: &mut Host, component: Component) {
    let (name, kinds): (_, (Fits, Fits)) = ("fmi3GetDirectionalDerivative", (input, real_output));
    let counted = n_values(host);
    derivative(host, component, name, kinds, |c, (known, seed), (unknown, n, into)| {
        let (known, k, seed) = (known.as_ptr(), known.len(), seed.as_ptr());
        // SAFETY: right, NULL, a count that no memory has, or counts that contradict each other.
        counted(n, &|m| unsafe { fmi3GetDirectionalDerivative(c, unknown, n, known, k, seed, k, into, m) })
    });
}

fn adjoint(host: &mut Host, component: Component) {
    let (name, kinds): (_, (Fits, Fits)) = ("fmi3GetAdjointDerivative", (real_output, input));
    let counted = n_values(host);
    derivative(host, component, name, kinds, |c, (unknown, seed), (known, n, into)| {
        let (unknown, u, seed) = (unknown.as_ptr(), unknown.len(), seed.as_ptr());
        // SAFETY: right, NULL, a count that no memory has, or counts that contradict each other.
        counted(n, &|m| unsafe { fmi3GetAdjointDerivative(c, unknown, u, known, n, seed, u, into, m) })
    });
}
