//! The host of the random calls: its instances and saved states, what it counts, and what must hold after every call.

use std::cell::Cell;
use std::collections::{BTreeMap, HashSet};
use std::ffi::{CStr, CString, c_void};
use std::ptr::null_mut;
use std::time::{Duration, Instant};

use fmu_export::fmi3::types::{Component, FmuState, Status, Text, ValueReference};
use fmu_export::model::Model;
use plain_bearing_stand::stand::Stand;

use crate::random::Random;
use crate::{exchange, states};

/// The most instances and saved states at once.
pub const MOST: usize = 4;

/// How often each function was called and how it ended: OK, warning, discard, error.
type Tally = BTreeMap<&'static str, [u64; 4]>;

/// A C function with its name in the standard.
pub type Named<F> = (&'static str, F);

/// A function that takes nothing but the instance.
pub type Plain = unsafe extern "C" fn(Component) -> Status;

/// A function with its name: `named!(fmi2Reset)`.
macro_rules! named {
    ($function:ident) => {
        (stringify!($function), $function)
    };
}
pub(crate) use named;

/// An action of a host with one of its instances.
pub type Act = fn(&mut Host, Component);

/// A version of the standard: the functions that both have, under the names of this one, and what else a host may do.
pub struct Interface {
    /// The acts of this version, each with how often it comes.
    pub acts: &'static [(usize, Act)],
    /// Makes an instance, for Model Exchange or not, with arguments as they should be or, if `wrong`, not.
    pub instantiate: fn(host: &mut Host, exchange: bool, wrong: bool) -> Component,
    /// The name of the function that makes instances, for Co-Simulation and for Model Exchange.
    pub instantiates: [&'static str; 2],
    /// Enters the initialization mode.
    pub enter: Act,
    /// Sets integers.
    pub set_integers: fn(&mut Host, Component, &[ValueReference], &[i32]),
    pub exit: Named<Plain>,
    pub terminate: Named<Plain>,
    pub reset: Named<Plain>,
    pub free: Named<unsafe extern "C" fn(Component)>,
    pub states: states::Functions,
    pub exchange: exchange::Functions,
}

/// The kinds of instances that a host makes.
#[derive(Clone, Copy, PartialEq)]
pub enum Kinds {
    CoSimulation,
    ModelExchange,
    Both,
}

/// The data behind the environment pointer of the host's callbacks.
pub struct Log {
    messages: Cell<u64>,
    /// The instance that is at work: the callbacks call back into it.
    pub busy: Cell<Option<Component>>,
    /// The number of intermediate updates.
    pub updates: Cell<u64>,
    /// Where the choices of callbacks come from.
    pub random: Cell<u64>,
    reset: Plain,
}

impl Log {
    /// Takes a message, and tries a call from within the logger.
    ///
    /// # Safety
    /// The pointers are what the boundary has passed to a logger of the host.
    pub unsafe fn hear(environment: *mut c_void, status: Status, category: Text, message: Text) {
        // SAFETY: the environment is the host's log; the boundary sends C strings.
        let (log, category, message) =
            unsafe { (&*environment.cast::<Self>(), CStr::from_ptr(category), CStr::from_ptr(message)) };
        assert!(message.to_str().is_ok(), "messages are UTF-8");
        let named = |name: &str| name.starts_with("log") || name == "validity";
        assert!(category.to_str().is_ok_and(named));
        assert_ne!(status, Status::Fatal, "{message:?}");
        log.messages.set(log.messages.get() + 1);
        if let Some(component) = log.busy.get() {
            // SAFETY: alive, and busy with the call that logs.
            let status = unsafe { (log.reset)(component) };
            let refused = "a call from within the logger is refused";
            assert_eq!(status, Status::Error, "{refused}");
        }
    }
}

/// The host.
pub struct Host {
    /// Where all choices come from.
    pub random: Random,
    /// Instances that are alive.
    pub instances: Vec<Component>,
    /// Those of them that are for Model Exchange.
    pub exchange: HashSet<Component>,
    /// Saved states that are alive.
    pub states: Vec<FmuState>,
    /// Instances and states that hold forged numbers: whatever they compute, they must not crash.
    pub forged: HashSet<*mut c_void>,
    /// The number of calls so far, for the report of a failure.
    pub calls: u64,
    /// The functions that it calls.
    pub interface: &'static Interface,
    kinds: Kinds,
    tally: Tally,
    slowest: (Duration, &'static str),
    /// A call that takes longer is told of as it comes, and its instance is reset.
    patience: Duration,
    log: Box<Log>,
    seed: u64,
}

impl Host {
    /// A host without instances, which gives up an instance that takes longer over a call.
    pub fn new(interface: &'static Interface, kinds: Kinds, seed: u64, patience: Duration) -> Self {
        Self {
            random: Random(seed),
            instances: Vec::new(),
            exchange: HashSet::new(),
            states: Vec::new(),
            forged: HashSet::new(),
            calls: 0,
            interface,
            kinds,
            tally: Tally::new(),
            slowest: (Duration::ZERO, ""),
            patience,
            log: Box::new(Log {
                messages: Cell::default(),
                busy: Cell::default(),
                updates: Cell::default(),
                random: Cell::new(seed),
                reset: interface.reset.1,
            }),
            seed,
        }
    }

    /// The acts of both versions, each with how often it comes.
    const ACTS: &[(usize, Act)] = &[
        (2, |host, _| {
            if host.instances.len() < MOST {
                host.instantiate();
            }
        }),
        (1, |host, _| {
            if host.instances.len() == MOST {
                host.free();
            }
        }),
        (12, states::act),
        (2, Self::live),
    ];

    /// Performs one random action.
    pub fn act(&mut self) {
        let acts = || Self::ACTS.iter().chain(self.interface.acts);
        let sum: usize = acts().map(|(weight, _)| weight).sum();
        let left = self.random.below(sum);
        let mut reached = 0;
        let chosen = acts().find(|(weight, _)| {
            reached += weight;
            left < reached
        });
        let component = self.component();
        if let Some((_, act)) = chosen {
            act(self, component);
        }
    }

    /// An instance; now and then NULL or something else.
    fn component(&mut self) -> Component {
        if self.instances.is_empty() || self.random.once_in(100) {
            return if self.random.once_in(2) { null_mut() } else { self.foreign() };
        }
        self.random.one(&self.instances)
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
        let frees = name == self.interface.free.0;
        assert!(
            ours.is_some() || status == Status::Error || frees,
            "{name} of a foreign handle, in call {calls} of seed {seed}"
        );
        if took > self.slowest.0 {
            self.slowest = (took, name);
        }
        if took > self.patience && ours.is_some() {
            // No host would go on with that either.
            eprintln!("call {calls} of seed {seed}: {name} took {took:?}; {status:?}");
            // SAFETY: alive.
            unsafe { (self.interface.reset.1)(component) };
        }
        status
    }

    /// Calls a function that takes nothing but the instance.
    pub fn plainly(&mut self, (name, function): Named<Plain>, component: Component) -> Status {
        // SAFETY: an instance that is alive, NULL, or readable memory.
        self.call(name, component, |c| unsafe { function(c) })
    }

    /// Makes an instance, with arguments as they should be or not, and mostly starts it.
    fn instantiate(&mut self) {
        let exchange = match self.kinds {
            Kinds::CoSimulation => false,
            Kinds::ModelExchange => true,
            Kinds::Both => self.random.once_in(2),
        };
        let wrong = self.random.once_in(10);
        let component = (self.interface.instantiate)(self, exchange, wrong);
        self.calls += 1;
        assert_eq!(component.is_null(), wrong, "call {}", self.calls);
        let name = self.interface.instantiates[usize::from(exchange)];
        self.tally.entry(name).or_default()[if wrong { 3 } else { 0 }] += 1;
        if wrong {
            return;
        }
        self.forged.remove(&component);
        self.instances.push(component);
        if exchange {
            self.exchange.insert(component);
        }
        if !self.random.once_in(5) {
            self.start(component);
        }
    }

    /// Brings an instance to its first communication point, or to continuous time.
    fn start(&mut self, component: Component) {
        self.small_film(component);
        (self.interface.enter)(self, component);
        if self.random.once_in(5) {
            return; // where it may still be configured
        }
        self.plainly(self.interface.exit, component);
        if self.exchange.contains(&component) {
            exchange::go_on(self, component);
        }
    }

    /// A Reynolds film of few cells, so that ten million calls end some day.
    fn small_film(&mut self, component: Component) {
        let references = ["bearing.filmColumns", "bearing.filmRows"].map(reference_of);
        (self.interface.set_integers)(self, component, &references, &[16, 2]);
    }

    /// Brings an instance from one phase to another, in turn or not.
    fn live(&mut self, component: Component) {
        match self.random.below(8) {
            0 => (self.interface.enter)(self, component),
            1 | 2 => {
                self.plainly(self.interface.exit, component);
            }
            3 => {
                self.plainly(self.interface.terminate, component);
            }
            4 => self.start(component),
            _ => {
                self.plainly(self.interface.reset, component);
                self.forged.remove(&component);
                self.start(component);
            }
        }
    }

    /// The token or GUID, or another: `spoiled`.
    pub fn token(&self, good: String, spoiled: bool) -> CString {
        let text = if spoiled { "{nonsense}".into() } else { good };
        CString::new(text).unwrap_or_default()
    }

    /// The pointer that goes with the host's callbacks.
    pub fn environment(&self) -> *mut c_void {
        (&raw const *self.log).cast::<c_void>().cast_mut()
    }

    /// Frees an instance, NULL, or something else.
    fn free(&mut self) {
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
        self.exchange.remove(&component);
        let (name, function) = self.interface.free;
        self.call(name, component, |component| {
            // SAFETY: NULL, readable memory, or an instance that nobody has any more.
            unsafe { function(component) };
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

    /// Frees everything and prints what was counted.
    pub fn finish(mut self) {
        if let Some(component) = self.instances.first().copied() {
            for state in std::mem::take(&mut self.states) {
                states::free(&mut self, component, state);
            }
        }
        for component in std::mem::take(&mut self.instances) {
            self.release(component);
        }
        let (seed, calls, messages) = (self.seed, self.calls, self.log.messages.get());
        let updates = self.log.updates.get();
        println!("seed {seed}: {calls} calls, {messages} messages, {updates} intermediate updates");
        let head = ["OK", "warning", "discard", "error"].map(|word| format!("{word:>9}"));
        println!("{:36} {}", "", head.join(" "));
        for (name, counts) in &self.tally {
            let counts = counts.map(|count| format!("{count:9}"));
            println!("{name:36} {}", counts.join(" "));
        }
        println!("slowest: {} in {:?}", self.slowest.1, self.slowest.0);
    }
}

/// The value reference of a variable.
pub fn reference_of(name: &str) -> ValueReference {
    let index = Stand::variables().iter().position(|v| v.name == name);
    index.and_then(|index| index.try_into().ok()).unwrap_or(ValueReference::MAX)
}

/// A place, or NULL.
pub fn hidden<T>(place: &mut T, missing: bool) -> *mut T {
    if missing { null_mut() } else { place }
}
