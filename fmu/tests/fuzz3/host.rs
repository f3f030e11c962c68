//! The host of the random calls: its instances and saved states, what it counts, and what must hold after every call.

use std::cell::Cell;
use std::collections::{BTreeMap, HashSet};
use std::ffi::{CStr, CString, c_void};
use std::ptr::{null, null_mut};
use std::time::{Duration, Instant};

use fmu_export::fmi3::description;
use fmu_export::fmi3::types::*;
use plain_bearing_stand::fmi3_functions::*;
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
    pub use plain_bearing_stand::fmi3_functions::{
        fmi3DeserializeFMUState as deserialize, fmi3FreeFMUState as free, fmi3GetFMUState as get,
        fmi3SerializedFMUStateSize as size, fmi3SetFMUState as set,
    };

    /// Their names in the standard.
    pub const NAMES: crate::states::Names = crate::states::Names {
        get: "fmi3GetFMUState",
        set: "fmi3SetFMUState",
        free: "fmi3FreeFMUState",
        size: "fmi3SerializedFMUStateSize",
        deserialize: "fmi3DeserializeFMUState",
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
    token: CString,
    seed: u64,
}

unsafe extern "C" fn logger(
    environment: ComponentEnvironment,
    status: Status,
    category: Text,
    message: Text,
) {
    // SAFETY: the environment is the host's log; the boundary sends C strings.
    let (log, category, message) = unsafe {
        (
            &*environment.cast::<Log>(),
            CStr::from_ptr(category),
            CStr::from_ptr(message),
        )
    };
    assert!(message.to_str().is_ok(), "messages are UTF-8");
    assert!(category.to_str().is_ok_and(|name| name.starts_with("log")));
    assert_ne!(status, Status::Fatal, "{message:?}");
    log.messages.set(log.messages.get() + 1);
    if let Some(component) = log.busy.get() {
        // SAFETY: alive, and busy with the call that logs.
        let status = unsafe { fmi3Reset(component) };
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
        let token = description::token(description::fingerprint::<Stand>());
        Self {
            random: Random(seed),
            instances: Vec::new(),
            states: Vec::new(),
            forged: HashSet::new(),
            calls: 0,
            tally: Tally::new(),
            slowest: (Duration::ZERO, ""),
            log: Box::default(),
            token: CString::new(token).unwrap_or_default(),
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
        assert!(
            ours.is_some() || status == Status::Error || name == "fmi3FreeInstance",
            "{name} of a foreign handle, in call {calls} of seed {seed}"
        );
        if took > self.slowest.0 {
            self.slowest = (took, name);
        }
        if took > LONG && ours.is_some() && name != "fmi3FreeInstance" {
            // No host would go on with that either.
            eprintln!("call {calls} of seed {seed}: {name} took {took:?}; {status:?}");
            // SAFETY: alive.
            unsafe { fmi3Reset(component) };
        }
        status
    }

    /// `fmi3InstantiateCoSimulation`, with arguments as they should be or not, or another kind.
    pub fn instantiate(&mut self) {
        let wrong = self.random.once_in(10);
        let spoil = |at: usize| wrong && at == self.calls as usize % 5;
        let token = if spoil(0) { c"{nonsense}" } else { &self.token };
        let name = match self.calls % 7 {
            _ if spoil(1) => c" ",
            0 => c"\xff %n",
            _ => c"stand",
        };
        let folder = concat!(
            env!("CARGO_MANIFEST_DIR"),
            "/../modelDescription/resources/"
        );
        let folder = CString::new(folder).unwrap_or_default();
        let resources = [folder.as_c_str(), c"", c"nowhere", c"/\xff/"]
            [self.random.one(&[0, 0, 0, 0, 1, 2, 3])];
        let environment = (&raw const *self.log).cast::<c_void>().cast_mut();
        let log = (!self.random.once_in(10)).then_some(logger as LogMessageCallback);
        let [logging, visible, early] = [0; 3].map(|_| self.random.bits() as u8);
        let event_mode = if spoil(2) { 7 } else { FALSE };
        let token = if spoil(3) { null() } else { token.as_ptr() };
        let (name, resources) = (name.as_ptr(), resources.as_ptr());
        // SAFETY: NULL or what the standard asks for; nobody looks at the variables.
        let component = unsafe {
            if spoil(4) {
                fmi3InstantiateModelExchange(
                    name,
                    token,
                    resources,
                    visible,
                    logging,
                    environment,
                    log,
                )
            } else {
                fmi3InstantiateCoSimulation(
                    name,
                    token,
                    resources,
                    visible,
                    logging,
                    event_mode,
                    early,
                    null(),
                    9,
                    environment,
                    log,
                    null(),
                )
            }
        };
        self.calls += 1;
        assert_eq!(component.is_null(), wrong, "call {}", self.calls);
        let ended = if wrong { 3 } else { 0 };
        self.tally.entry("fmi3InstantiateCoSimulation").or_default()[ended] += 1;
        if !wrong {
            self.forged.remove(&component);
            self.instances.push(component);
        }
    }

    /// `fmi3FreeInstance` of an instance, of NULL, or of something else.
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
        self.call("fmi3FreeInstance", component, |component| {
            // SAFETY: NULL, readable memory, or an instance that nobody has any more.
            unsafe { fmi3FreeInstance(component) };
            Status::Ok
        });
    }

    /// A pointer that is no instance: to other memory, or to a saved state.
    pub fn foreign(&mut self) -> *mut c_void {
        static OTHER: [u64; 64] = [0x5555_5555_5555_5555; 64];
        let other = (&raw const OTHER).cast_mut().cast();
        match self.states.first() {
            Some(state) if self.random.once_in(2) => *state,
            _ => other,
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
        self.call("fmi3GetFMUState", component, |c| {
            // SAFETY: as said above.
            unsafe { fmi3GetFMUState(c, &raw mut state) }
        });
        let bytes = self.bytes(component, state);
        self.call("fmi3FreeFMUState", component, |c| {
            // SAFETY: as said above.
            unsafe { fmi3FreeFMUState(c, &raw mut state) }
        });
        assert!(state.is_null());
        bytes
    }

    /// The bytes of a saved state.
    pub fn bytes(&mut self, component: Component, state: FmuState) -> Vec<u8> {
        let mut size = 0;
        // SAFETY of both: the instance and the state are alive, there is room for the bytes.
        self.call("fmi3SerializedFMUStateSize", component, |c| {
            // SAFETY: as said above.
            unsafe { fmi3SerializedFMUStateSize(c, state, &raw mut size) }
        });
        let mut bytes = vec![0_u8; size];
        let into = bytes.as_mut_ptr();
        self.call("fmi3SerializeFMUState", component, |c| {
            // SAFETY: as said above.
            unsafe { fmi3SerializeFMUState(c, state, into, size) }
        });
        bytes
    }

    /// Frees everything and prints what was counted.
    pub fn finish(mut self) {
        for mut state in std::mem::take(&mut self.states) {
            if let Some(component) = self.instances.first().copied() {
                // SAFETY: alive, freed once.
                self.call("fmi3FreeFMUState", component, |c| unsafe {
                    fmi3FreeFMUState(c, &raw mut state)
                });
            }
        }
        for component in std::mem::take(&mut self.instances) {
            self.release(component);
        }
        let (seed, calls, messages) = (self.seed, self.calls, self.log.messages.get());
        println!("seed {seed}: {calls} calls, {messages} messages");
        let head = ["OK", "warning", "discard", "error"].map(|word| format!("{word:>9}"));
        println!("{:36} {}", "", head.join(" "));
        for (name, counts) in &self.tally {
            let counts = counts.map(|count| format!("{count:9}"));
            println!("{name:36} {}", counts.join(" "));
        }
        println!("slowest: {} in {:?}", self.slowest.1, self.slowest.0);
    }
}
