//! FMI 2.0.

use std::ffi::{c_char, c_int};
use std::ptr::null;

use fmu_export::description::{self, Version};
use fmu_export::fmi2::types::*;
use fmu_export::model::Kind;
use plain_bearing_stand::c_functions::*;
use plain_bearing_stand::stand::Stand;

use crate::host::{Host, Interface, Log, hidden, named};
use crate::values::*;
use crate::{exchange, states};

pub static INTERFACE: Interface = Interface {
    acts: &[
        (20, step),
        (20, |host, c| get(host, c, "fmi2GetReal", REALS, get_reals)),
        (4, get_integer),
        (4, get_boolean),
        (4, get_string),
        (14, set_real),
        (4, set_integer),
        (3, set_boolean),
        (3, set_string),
        (6, set_slopes),
        (4, get_output_rates),
        (2, directional),
        (8, status),
        (2, logging),
        (20, exchange::act),
    ],
    instantiate,
    instantiates: ["fmi2Instantiate (Co-Simulation)", "fmi2Instantiate (Model Exchange)"],
    enter,
    set_integers: |host, component, references, values| {
        let both = (references, values);
        set(host, component, "fmi2SetInteger", both, set_integers);
    },
    exit: named!(fmi2ExitInitializationMode),
    terminate: named!(fmi2Terminate),
    reset: named!(fmi2Reset),
    free: named!(fmi2FreeInstance),
    states: states::Functions {
        get: named!(fmi2GetFMUstate),
        set: named!(fmi2SetFMUstate),
        free: named!(fmi2FreeFMUstate),
        size: named!(fmi2SerializedFMUstateSize),
        serialize: ("fmi2SerializeFMUstate", serialize),
        deserialize: ("fmi2DeSerializeFMUstate", deserialize),
    },
    exchange: exchange::Functions {
        enter_event: named!(fmi2EnterEventMode),
        enter_continuous: named!(fmi2EnterContinuousTimeMode),
        set_time: named!(fmi2SetTime),
        set_states: named!(fmi2SetContinuousStates),
        get_states: named!(fmi2GetContinuousStates),
        get_rates: named!(fmi2GetDerivatives),
        get_nominals: named!(fmi2GetNominalsOfContinuousStates),
        get_indicators: named!(fmi2GetEventIndicators),
        tell,
        count: None,
    },
};

unsafe extern "C" fn serialize(c: Component, state: FmuState, to: *mut u8, n: usize) -> Status {
    // SAFETY: the test passes what `fmi2SerializeFMUstate` asks for.
    unsafe { fmi2SerializeFMUstate(c, state, to.cast(), n) }
}

unsafe extern "C" fn deserialize(c: Component, from: *const u8, n: usize, state: *mut FmuState) -> Status {
    // SAFETY: the test passes what `fmi2DeSerializeFMUstate` asks for.
    unsafe { fmi2DeSerializeFMUstate(c, from.cast(), n, state) }
}

/// The logger as Rust can define it: see `crates/fmu-export/tests/boundary/host.rs`.
type Fixed = unsafe extern "C" fn(ComponentEnvironment, Text, Status, Text, Text, *const c_char);

unsafe extern "C" fn logger(
    environment: ComponentEnvironment,
    _: Text,
    status: Status,
    category: Text,
    format: Text,
    message: *const c_char,
) {
    // SAFETY: the boundary sends C strings, and the environment that it was given.
    unsafe {
        let format = std::ffi::CStr::from_ptr(format);
        assert_eq!(format, c"%s", "the message is data, never the format");
        Log::hear(environment, status, category, message);
    }
}

fn instantiate(host: &mut Host, exchange: bool, wrong: bool) -> Component {
    let callbacks = CallbackFunctions {
        // SAFETY: the same calling convention for both on the platforms that run tests.
        logger: (!host.random.once_in(10)).then(|| unsafe { std::mem::transmute::<Fixed, CallbackLogger>(logger) }),
        allocate_memory: None,
        free_memory: None,
        step_finished: None,
        component_environment: host.environment(),
    };
    let way = host.calls as usize % 6;
    let spoil = |at: usize| wrong && at == way;
    // The fifth fault is the GUID of the other kind.
    let fingerprint = if exchange == spoil(5) {
        description::fingerprint::<Stand>(Version::Two, description::Interface::CoSimulation)
    } else {
        description::fingerprint::<Stand>(Version::Two, description::Interface::ModelExchange)
    };
    let kind = match exchange {
        _ if spoil(2) => -7,
        true => MODEL_EXCHANGE,
        false => CO_SIMULATION,
    };
    let guid = host.token(description::token(fingerprint), spoil(0));
    let name = match host.calls % 7 {
        _ if spoil(1) => c" ",
        0 => c"\xff %n",
        _ => c"stand",
    };
    let resources = concat!("file://", env!("CARGO_MANIFEST_DIR"), "/../modelDescription/resources\0");
    let resources =
        [resources.as_ptr().cast(), c"".as_ptr(), c"file:///nowhere%".as_ptr(), c"http://localhost/%ff".as_ptr()]
            [host.random.one(&[0, 0, 0, 0, 1, 2, 3])];
    let callbacks = if spoil(3) { null() } else { &raw const callbacks };
    let guid = if spoil(4) { null() } else { guid.as_ptr() };
    let logging = host.random.integer();
    // SAFETY: NULL or what the standard asks for.
    unsafe { fmi2Instantiate(name.as_ptr(), kind, guid, resources, callbacks, FALSE, logging) }
}

/// Enters the initialization mode, with an experiment.
fn enter(host: &mut Host, component: Component) {
    let (with_tolerance, with_stop) = (host.random.below(2) as i32, i32::from(host.random.once_in(10)));
    let [tolerance, start, stop] = experiment(host);
    // SAFETY: an instance that is alive, NULL, or readable memory.
    host.call("fmi2SetupExperiment", component, |c| unsafe {
        fmi2SetupExperiment(c, with_tolerance, tolerance, start, with_stop, stop)
    });
    host.plainly(named!(fmi2EnterInitializationMode), component);
}

fn step(host: &mut Host, component: Component) {
    if host.random.once_in(50) {
        host.plainly(named!(fmi2CancelStep), component);
    }
    let mut time = 0.0;
    // SAFETY of both: as for `enter`; the place is ours.
    host.call("fmi2GetRealStatus", component, |c| {
        // SAFETY: as said above.
        unsafe { fmi2GetRealStatus(c, LAST_SUCCESSFUL_TIME, &raw mut time) }
    });
    let [from, step] = crate::values::step(host, time);
    let prior = host.random.integer();
    host.call("fmi2DoStep", component, |c| {
        // SAFETY: as said above.
        unsafe { fmi2DoStep(c, from, step, prior) }
    });
}

fn tell(host: &mut Host, component: Component, discrete: bool, missing: usize) -> exchange::Told {
    if discrete {
        let mut info = EventInfo::default();
        let place = hidden(&mut info, missing == 0);
        let status = host.call("fmi2NewDiscreteStates", component, |c| {
            // SAFETY: as for `enter`; the place is ours, or NULL.
            unsafe { fmi2NewDiscreteStates(c, place) }
        });
        let flags = [
            info.new_discrete_states_needed,
            info.terminate_simulation,
            info.nominals_changed,
            info.states_changed,
            info.next_event_time_defined,
        ];
        return (status, flags.map(|flag| flag != FALSE).into());
    }
    let (mut event, mut end) = (9, 9);
    let places = (hidden(&mut event, missing == 0), hidden(&mut end, missing == 1));
    let prior = host.random.integer();
    let status = host.call("fmi2CompletedIntegratorStep", component, |c| {
        // SAFETY: as for `enter`; the places are ours, or NULL.
        unsafe { fmi2CompletedIntegratorStep(c, prior, places.0, places.1) }
    });
    (status, vec![event != FALSE, end != FALSE])
}

fn status(host: &mut Host, component: Component) {
    let kind: c_int = host.random.one(&[0, 1, 2, 3, 4, -1]);
    let missing = host.random.once_in(10);
    let (mut ended, mut real, mut integer, mut text) = (Status::Ok, 0.0, 0, null());
    // SAFETY of all: as for `enter`; the places are ours, or NULL.
    match host.random.below(5) {
        0 => host.call("fmi2GetStatus", component, |c| {
            // SAFETY: as said above.
            unsafe { fmi2GetStatus(c, kind, hidden(&mut ended, missing)) }
        }),
        1 => host.call("fmi2GetRealStatus", component, |c| {
            // SAFETY: as said above.
            unsafe { fmi2GetRealStatus(c, kind, hidden(&mut real, missing)) }
        }),
        2 => host.call("fmi2GetIntegerStatus", component, |c| {
            // SAFETY: as said above.
            unsafe { fmi2GetIntegerStatus(c, kind, hidden(&mut integer, missing)) }
        }),
        3 => host.call("fmi2GetBooleanStatus", component, |c| {
            // SAFETY: as said above.
            unsafe { fmi2GetBooleanStatus(c, kind, hidden(&mut integer, missing)) }
        }),
        _ => host.call("fmi2GetStringStatus", component, |c| {
            // SAFETY: as said above.
            unsafe { fmi2GetStringStatus(c, kind, hidden(&mut text, missing)) }
        }),
    };
    assert!(real.is_finite());
}

fn logging(host: &mut Host, component: Component) {
    let (chosen, n) = categories(host);
    let on = host.random.integer();
    // SAFETY: up to two texts that end with NUL.
    host.call("fmi2SetDebugLogging", component, |c| unsafe { fmi2SetDebugLogging(c, on, n, chosen.as_ptr()) });
}

/// Defines accesses that may be called as they are.
macro_rules! plain {
    ($($name:ident = $function:ident($pointer:ty);)*) => {$(
        fn $name(c: Component, references: *const ValueReference, n: usize, values: $pointer) -> Status {
            // SAFETY: right, NULL, or a count that no memory has.
            unsafe { $function(c, references, n, values) }
        }
    )*};
}

plain! {
    get_reals = fmi2GetReal(*mut f64);
    get_integers = fmi2GetInteger(*mut i32);
    get_booleans = fmi2GetBoolean(*mut i32);
    get_strings = fmi2GetString(*mut Text);
    set_reals_ = fmi2SetReal(*const f64);
    set_integers = fmi2SetInteger(*const i32);
    set_booleans = fmi2SetBoolean(*const i32);
    set_strings = fmi2SetString(*const Text);
}

const INTEGERS: Fits = |v| matches!(v.kind, Kind::Integer { .. } | Kind::Enumeration { .. });

fn get_integer(host: &mut Host, component: Component) {
    let expected: (Fits, _, fn(&i32) -> bool) = (INTEGERS, i32::MIN, |value| *value != i32::MIN);
    get(host, component, "fmi2GetInteger", expected, get_integers);
}

fn get_boolean(host: &mut Host, component: Component) {
    let expected: (Fits, _, fn(&i32) -> bool) = (boolean, 9, |value| [0, 1].contains(value));
    get(host, component, "fmi2GetBoolean", expected, get_booleans);
}

fn get_string(host: &mut Host, component: Component) {
    get(host, component, "fmi2GetString", TEXTS, get_strings);
}

fn set_real(host: &mut Host, component: Component) {
    set_reals(host, component, "fmi2SetReal", set_reals_);
}

fn set_integer(host: &mut Host, component: Component) {
    let references = references(host, |v| settable(v) && INTEGERS(v));
    let value = |host: &mut Host, reference: &_| integer_for(host, *reference);
    let values: Vec<_> = references.iter().map(|r| value(host, r)).collect();
    let both = (&*references, &*values);
    set(host, component, "fmi2SetInteger", both, set_integers);
}

fn set_boolean(host: &mut Host, component: Component) {
    let references = references(host, |v| settable(v) && boolean(v));
    let values: Vec<_> = references.iter().map(|_| host.random.integer()).collect();
    let both = (&*references, &*values);
    set(host, component, "fmi2SetBoolean", both, set_booleans);
}

fn set_string(host: &mut Host, component: Component) {
    set_texts(host, component, "fmi2SetString", set_strings);
}

fn set_slopes(host: &mut Host, component: Component) {
    let references = references(host, input);
    let orders: Vec<_> = (references.iter()).map(|_| host.random.one(&[1, 1, 1, 1, 1, 0, 2])).collect();
    let values = direction(host, &references);
    let both = (&*references, &*values);
    let name = "fmi2SetRealInputDerivatives";
    set(host, component, name, both, |c, from, n, value| {
        // SAFETY: right, NULL, or a count that no memory has.
        unsafe { fmi2SetRealInputDerivatives(c, from, n, orders.as_ptr(), value) }
    });
}

fn get_output_rates(host: &mut Host, component: Component) {
    let name = "fmi2GetRealOutputDerivatives";
    get_rates(host, component, name, |c, from, n, orders, into| {
        // SAFETY: right, NULL, or a count that no memory has.
        unsafe { fmi2GetRealOutputDerivatives(c, from, n, orders, into) }
    });
}

fn directional(host: &mut Host, component: Component) {
    let (name, kinds): (_, (Fits, Fits)) = ("fmi2GetDirectionalDerivative", (input, real_output));
    derivative(host, component, name, kinds, |c, (known, seed), (unknown, n, into)| {
        let (known, m) = (known.as_ptr(), known.len());
        // SAFETY: right, NULL, or a count that no memory has.
        unsafe { fmi2GetDirectionalDerivative(c, unknown, n, known, m, seed.as_ptr(), into) }
    });
}
