//! FMI 3.0.

use std::ffi::CString;
use std::ptr::null;

use fmu_export::description::{self, Version};
use fmu_export::fmi3::types::*;
use fmu_export::model::Kind;
use plain_bearing_stand::fmi3_functions::*;
use plain_bearing_stand::stand::Stand;

use crate::host::{Host, Interface, Log, hidden, named};
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
            null(),
            // Nobody looks at the variables.
            9,
            environment,
            log,
            null(),
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
        let expected = if status == Status::Ok { from + step } else { time };
        let as_expected = early == FALSE && reached == expected;
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
