//! The host of the random calls: its instances and saved states, what it counts, and what must hold
//! after every call.

use std::cell::Cell;
use std::collections::{BTreeMap, HashSet};
use std::ffi::{CStr, CString, c_char, c_void};
use std::ptr::null_mut;
use std::time::{Duration, Instant};

use fmu_export::fmi2::description;
use fmu_export::fmi2::types::*;
use plain_bearing_stand::c_functions::*;
use plain_bearing_stand::stand::Stand;

use crate::random::Random;

/// A call that takes so long is told of as it comes, and its instance is reset.
const LONG: Duration = Duration::from_secs(1);

/// How often each function was called and how it ended: OK, warning, discard, error.
type Tally = BTreeMap<&'static str, [u64; 4]>;

/// The data behind the logger's environment pointer.
#[derive(Default)]
struct Log {
    messages: Cell<u64>,
    /// The instance that is at work: the logger calls back into it.
    busy: Cell<Option<Component>>,
}

/// The functions for saved states, under the names that all versions share.
pub mod saving {
    pub use plain_bearing_stand::c_functions::{
        fmi2DeSerializeFMUstate as deserialize, fmi2FreeFMUstate as free, fmi2GetFMUstate as get,
        fmi2SerializedFMUstateSize as size, fmi2SetFMUstate as set,
    };

    /// Their names in the standard.
    pub const NAMES: crate::states::Names = crate::states::Names {
        get: "fmi2GetFMUstate",
        set: "fmi2SetFMUstate",
        free: "fmi2FreeFMUstate",
        size: "fmi2SerializedFMUstateSize",
        deserialize: "fmi2DeSerializeFMUstate",
    };
}

/// The host.
pub struct Host {
    /// Where all choices come from.
    pub random: Random,
    /// Instances that are alive.
    pub instances: Vec<Component>,
    /// Saved states that are alive.
    pub states: Vec<FmuState>,
    /// Instances and states that hold forged numbers: whatever they compute, they must not crash.
    pub forged: HashSet<*mut c_void>,
    /// The number of calls so far, for the report of a failure.
    pub calls: u64,
    tally: Tally,
    slowest: (Duration, &'static str),
    log: Box<Log>,
    guid: CString,
    resources: CString,
    seed: u64,
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
    // SAFETY: the environment is the host's log; the boundary sends C strings.
    let (log, category, format, message) = unsafe {
        (
            &*environment.cast::<Log>(),
            CStr::from_ptr(category),
            CStr::from_ptr(format),
            CStr::from_ptr(message),
        )
    };
    assert_eq!(format, c"%s", "the message is data, never the format");
    assert!(message.to_str().is_ok(), "messages are UTF-8");
    assert!(category.to_str().is_ok_and(|name| name.starts_with("log")));
    assert_ne!(status, Status::Fatal, "{message:?}");
    log.messages.set(log.messages.get() + 1);
    if let Some(component) = log.busy.get() {
        // SAFETY: alive, and busy with the call that logs.
        let status = unsafe { fmi2Reset(component) };
        assert_eq!(
            status,
            Status::Error,
            "a call from within the logger is refused"
        );
    }
}

impl Host {
    /// A host without instances.
    pub fn new(seed: u64) -> Self {
        let resources = concat!(
            "file://",
            env!("CARGO_MANIFEST_DIR"),
            "/../modelDescription/resources"
        );
        Self {
            random: Random(seed),
            instances: Vec::new(),
            states: Vec::new(),
            forged: HashSet::new(),
            calls: 0,
            tally: Tally::new(),
            slowest: (Duration::ZERO, ""),
            log: Box::default(),
            guid: c_text(description::guid(description::fingerprint::<Stand>())),
            resources: c_text(resources),
            seed,
        }
    }

    /// Calls a function of an instance, counts it, and checks what always holds.
    pub fn call(
        &mut self,
        name: &'static str,
        component: Component,
        function: impl FnOnce(Component) -> Status,
    ) -> Status {
        let ours = self.instances.contains(&component).then_some(component);
        self.log.busy.set(ours);
        let started = Instant::now();
        let status = function(component);
        let took = started.elapsed();
        self.log.busy.set(None);
        self.calls += 1;
        let ended = self.tally.entry(name).or_default().get_mut(status as usize);
        let (calls, seed) = (self.calls, self.seed);
        let Some(ended) = ended else {
            panic!("{name} ended with {status:?}, in call {calls} of seed {seed}");
        };
        *ended += 1;
        if took > self.slowest.0 {
            self.slowest = (took, name);
        }
        if took > LONG && ours.is_some() && name != "fmi2FreeInstance" {
            // No host would go on with that either.
            eprintln!("call {calls} of seed {seed}: {name} took {took:?}; {status:?}");
            // SAFETY: alive.
            unsafe { fmi2Reset(component) };
        }
        status
    }

    /// `fmi2Instantiate`, with arguments as they should be or not.
    pub fn instantiate(&mut self) {
        let callbacks = CallbackFunctions {
            // SAFETY: the same calling convention for both on the platforms that run tests.
            logger: (!self.random.once_in(10))
                .then(|| unsafe { std::mem::transmute::<Fixed, CallbackLogger>(logger) }),
            allocate_memory: None,
            free_memory: None,
            step_finished: None,
            component_environment: (&raw const *self.log).cast::<c_void>().cast_mut(),
        };
        let wrong = self.random.once_in(10);
        let spoil = |at: usize| wrong && at == self.calls as usize % 5;
        let guid = if spoil(0) { c"{nonsense}" } else { &self.guid };
        let name = match self.calls % 7 {
            _ if spoil(1) => c" ",
            0 => c"\xff %n",
            _ => c"stand",
        };
        let kind = if spoil(2) { -7 } else { CO_SIMULATION };
        let resources = [
            self.resources.as_c_str(),
            c"",
            c"file:///nowhere%",
            c"http://localhost/%ff",
        ][self.random.one(&[0, 0, 0, 0, 1, 2, 3])];
        let callbacks = if spoil(3) {
            std::ptr::null()
        } else {
            &raw const callbacks
        };
        let logging = self.random.integer();
        // SAFETY: NULL or what the standard asks for.
        let component = unsafe {
            fmi2Instantiate(
                name.as_ptr(),
                kind,
                if spoil(4) {
                    std::ptr::null()
                } else {
                    guid.as_ptr()
                },
                resources.as_ptr(),
                callbacks,
                FALSE,
                logging,
            )
        };
        self.calls += 1;
        assert_eq!(component.is_null(), wrong, "call {}", self.calls);
        self.tally.entry("fmi2Instantiate").or_default()[if wrong { 3 } else { 0 }] += 1;
        if !wrong {
            self.forged.remove(&component);
            self.instances.push(component);
        }
    }

    /// `fmi2FreeInstance` of an instance, of NULL, or of something else.
    pub fn free(&mut self) {
        let component = match self.random.below(8) {
            0 => null_mut(),
            1 => self.foreign(),
            _ if self.instances.is_empty() => null_mut(),
            _ => {
                let index = self.random.below(self.instances.len());
                self.instances.swap_remove(index)
            }
        };
        self.release(component);
    }

    fn release(&mut self, component: Component) {
        self.call("fmi2FreeInstance", component, |component| {
            // SAFETY: NULL, readable memory, or an instance that nobody has any more.
            unsafe { fmi2FreeInstance(component) };
            Status::Ok
        });
    }

    /// A pointer that is no instance: to other memory, or to a saved state.
    pub fn foreign(&mut self) -> *mut c_void {
        static OTHER: [u64; 64] = [0x5555_5555_5555_5555; 64];
        match self.states.as_slice() {
            [] => (&raw const OTHER).cast_mut().cast(),
            states => self
                .random
                .one(&[states[0], (&raw const OTHER).cast_mut().cast()]),
        }
    }

    /// Forged numbers travel along when an instance is copied into a state or back.
    pub fn copied(&mut self, from: *mut c_void, to: *mut c_void) {
        if self.forged.contains(&from) {
            self.forged.insert(to);
        } else {
            self.forged.remove(&to);
        }
    }

    /// The bytes of an instance's state.
    pub fn bytes_of(&mut self, component: Component) -> Vec<u8> {
        let mut state = null_mut();
        // SAFETY of all: the instance and the state are alive, the places are ours.
        self.call("fmi2GetFMUstate", component, |c| {
            // SAFETY: as said above.
            unsafe { fmi2GetFMUstate(c, &raw mut state) }
        });
        let bytes = self.bytes(component, state);
        self.call("fmi2FreeFMUstate", component, |c| {
            // SAFETY: as said above.
            unsafe { fmi2FreeFMUstate(c, &raw mut state) }
        });
        assert!(state.is_null());
        bytes
    }

    /// The bytes of a saved state.
    pub fn bytes(&mut self, component: Component, state: FmuState) -> Vec<u8> {
        let mut size = 0;
        // SAFETY of both: the instance and the state are alive, there is room for the bytes.
        self.call("fmi2SerializedFMUstateSize", component, |c| {
            // SAFETY: as said above.
            unsafe { fmi2SerializedFMUstateSize(c, state, &raw mut size) }
        });
        let mut bytes = vec![0_u8; size];
        let into = bytes.as_mut_ptr().cast();
        self.call("fmi2SerializeFMUstate", component, |c| {
            // SAFETY: as said above.
            unsafe { fmi2SerializeFMUstate(c, state, into, size) }
        });
        bytes
    }

    /// Frees everything and prints what was counted.
    pub fn finish(mut self) {
        let component = *self.instances.first().unwrap_or(&null_mut());
        for mut state in std::mem::take(&mut self.states) {
            // SAFETY: alive, freed once.
            self.call("fmi2FreeFMUstate", component, |c| unsafe {
                fmi2FreeFMUstate(c, &raw mut state)
            });
        }
        for component in std::mem::take(&mut self.instances) {
            self.release(component);
        }
        println!(
            "seed {}: {} calls, {} messages",
            self.seed,
            self.calls,
            self.log.messages.get()
        );
        println!(
            "{:30} {:>9} {:>9} {:>9} {:>9}",
            "", "OK", "warning", "discard", "error"
        );
        for (name, [ok, warning, discard, error]) in &self.tally {
            println!("{name:30} {ok:9} {warning:9} {discard:9} {error:9}");
        }
        println!("slowest: {} in {:?}", self.slowest.1, self.slowest.0);
    }
}

fn c_text(text: impl Into<Vec<u8>>) -> CString {
    CString::new(text).unwrap_or_default()
}
