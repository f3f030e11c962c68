//! The equations of an FMU for Model Exchange: the functions of both versions, which differ in few signatures; of
//! Co-Simulation with event mode those of its events.

use std::ffi::c_int;

use crate::{
    call::{Call, Called, Status},
    description::{ExchangeSizes, Interface},
    simulation::Simulation,
    symbols::{Component, Function, LibraryError, Plain, Symbols},
    value::Value,
    version::Version,
};

type Read = unsafe extern "C" fn(Component, *mut f64, usize) -> c_int;
type Write = unsafe extern "C" fn(Component, *const f64, usize) -> c_int;
type SetTime = unsafe extern "C" fn(Component, f64) -> c_int;
type Count = unsafe extern "C" fn(Component, *mut usize) -> c_int;

/// The struct `fmi2EventInfo`.
#[repr(C)]
#[derive(Debug, Default)]
struct EventInfo {
    /// In the order of [`Update`], the last one whether the next event is known.
    flags: [c_int; 5],
    next: f64,
}

/// `fmi3UpdateDiscreteStates`. The flags of FMI 3.0 are bytes rather than `bool`, as an FMU may write any.
type UpdateDiscreteStates =
    unsafe extern "C" fn(Component, *mut u8, *mut u8, *mut u8, *mut u8, *mut u8, *mut f64) -> c_int;

/// The functions of which each version has its own.
#[derive(Clone, Copy, Debug)]
enum Special {
    Two {
        update: Function<unsafe extern "C" fn(Component, *mut EventInfo) -> c_int>,
        completed: Function<unsafe extern "C" fn(Component, c_int, *mut c_int, *mut c_int) -> c_int>,
    },
    Three {
        update: Function<UpdateDiscreteStates>,
        completed: Function<unsafe extern "C" fn(Component, bool, *mut u8, *mut u8) -> c_int>,
        count_states: Function<Count>,
        count_indicators: Function<Count>,
    },
    /// Co-Simulation of FMI 3.0.
    Steps(Function<UpdateDiscreteStates>),
}

/// The functions of Model Exchange.
#[derive(Clone, Copy, Debug)]
pub struct Functions {
    enter_event_mode: Function<Plain>,
    /// Into continuous-time mode, or step mode.
    leave_event_mode: Function<Plain>,
    set_time: Function<SetTime>,
    set_continuous_states: Function<Write>,
    get_derivatives: Function<Read>,
    get_event_indicators: Function<Read>,
    get_continuous_states: Function<Read>,
    get_nominals: Function<Read>,
    special: Special,
}

impl Functions {
    /// Finds them in a loaded binary.
    pub fn find(symbols: &Symbols, interface: Interface) -> Result<Self, LibraryError> {
        let (steps, is_three) = (interface == Interface::CoSimulation, symbols.version == Version::Three);
        // Some FMUs of FMI 2.0 leave out what they do not need.
        let read = |name| symbols.need_if(is_three && !steps, name);
        Ok(Self {
            enter_event_mode: symbols.need("EnterEventMode")?,
            leave_event_mode: symbols.need(if steps { "EnterStepMode" } else { "EnterContinuousTimeMode" })?,
            set_time: symbols.need_if(!steps, "SetTime")?,
            set_continuous_states: symbols.need_if(!steps, "SetContinuousStates")?,
            get_derivatives: symbols
                .need_if(!steps, if is_three { "GetContinuousStateDerivatives" } else { "GetDerivatives" })?,
            get_event_indicators: read("GetEventIndicators")?,
            get_continuous_states: symbols.need_if(!steps, "GetContinuousStates")?,
            get_nominals: read("GetNominalsOfContinuousStates")?,
            special: match symbols.version {
                _ if steps => Special::Steps(symbols.need("UpdateDiscreteStates")?),
                Version::Two => Special::Two {
                    update: symbols.need("NewDiscreteStates")?,
                    completed: symbols.find("CompletedIntegratorStep"),
                },
                Version::Three => Special::Three {
                    update: symbols.need("UpdateDiscreteStates")?,
                    completed: symbols.need("CompletedIntegratorStep")?,
                    count_states: symbols.need("GetNumberOfContinuousStates")?,
                    count_indicators: symbols.need("GetNumberOfEventIndicators")?,
                },
            },
        })
    }
}

/// The answer of an FMU after its events.
#[derive(Debug)]
pub struct Update {
    /// Another round is needed.
    pub again: bool,
    /// The FMU ends the simulation.
    pub ends: bool,
    /// The nominal values have changed.
    pub nominals: bool,
    /// The states have changed.
    pub states: bool,
    /// The time of the next event that is known beforehand, s.
    pub next: Option<f64>,
}

/// The FMU as the integrator sees it.
#[derive(Debug)]
pub struct Plant {
    /// The component, by which variables are read and written.
    pub model: Box<dyn Simulation>,
    pub functions: Functions,
    /// The declarations of the description.
    pub declared: ExchangeSizes,
    pub ramps: Vec<Ramp>,
}

/// An input that varies linearly.
#[derive(Clone, Copy, Debug)]
pub struct Ramp {
    pub reference: u32,
    /// Its value at a time, s, and its rate.
    pub value: f64,
    pub from: f64,
    pub slope: f64,
}

impl Plant {
    /// The function under which the integrator's own failures are told, by which a user finds them in the standard.
    pub fn step(&self) -> &'static str {
        match self.functions.special {
            Special::Two { completed, .. } => completed.name,
            Special::Three { completed, .. } => completed.name,
            Special::Steps(_) => "fmi3DoStep",
        }
    }

    /// Whether it takes steps by itself.
    pub fn steps(&self) -> bool {
        matches!(self.functions.special, Special::Steps(_))
    }

    /// A failure of the integration itself.
    pub fn failed(&self, why: String) -> Call {
        Call::impossible(self.step(), why)
    }

    #[inline(never)]
    fn read(&mut self, function: Function<Read>, into: &mut [f64]) -> Called {
        let (place, count) = (into.as_mut_ptr(), into.len());
        // SAFETY: the component is alive, and there is room for as many numbers as stated.
        self.model.base_mut().call(function, |read, of| unsafe { read(of, place, count) })
    }

    fn count(&mut self, function: Function<Count>) -> Called<usize> {
        let mut count = 0;
        // SAFETY: the component is alive, and the count is a valid place to write to.
        self.model.base_mut().call(function, |get, of| unsafe { get(of, &raw mut count) })?;
        Ok(count)
    }

    /// How many states and event indicators there are.
    pub fn sizes(&mut self) -> Called<[usize; 2]> {
        match self.functions.special {
            Special::Two { .. } => Ok([self.declared.states, self.declared.indicators]),
            Special::Steps(_) => Ok([0; 2]),
            Special::Three { count_states, count_indicators, .. } => {
                Ok([self.count(count_states)?, self.count(count_indicators)?])
            }
        }
    }

    /// Takes the FMU to a time and states, with the inputs that vary linearly.
    pub fn place(&mut self, time: f64, states: &[f64]) -> Called {
        if self.steps() {
            return Ok(());
        }
        self.set_time(time)?;
        if !states.is_empty() {
            self.set_states(states)?;
        }
        for ramp in &self.ramps {
            let value = Value::Real(ramp.value + ramp.slope * (time - ramp.from));
            self.model.set(ramp.reference, &value)?;
        }
        Ok(())
    }

    #[inline(never)]
    fn set_time(&mut self, time: f64) -> Called {
        let function = self.functions.set_time;
        // SAFETY: the component is alive.
        self.model.base_mut().call(function, |set, of| unsafe { set(of, time) })
    }

    #[inline(never)]
    fn set_states(&mut self, states: &[f64]) -> Called {
        let (place, count) = (states.as_ptr(), states.len());
        let function = self.functions.set_continuous_states;
        // SAFETY: the component is alive, and there are as many states as stated.
        self.model.base_mut().call(function, |set, of| unsafe { set(of, place, count) })
    }

    /// Reads the states.
    pub fn states(&mut self, into: &mut [f64]) -> Called {
        self.read(self.functions.get_continuous_states, into)
    }

    /// Reads the typical magnitudes of the states: 1 where the FMU does not tell them.
    pub fn nominals(&mut self, into: &mut [f64]) -> Called {
        let get = self.functions.get_nominals;
        if get.is_there() {
            return self.read(get, into);
        }
        into.fill(1.0);
        Ok(())
    }

    /// The rates at a time and states; whether the FMU computes them there.
    pub fn rates_at(&mut self, time: f64, states: &[f64], into: &mut [f64]) -> Called<bool> {
        match self.place(time, states).and_then(|()| self.read(self.functions.get_derivatives, into)) {
            Err(call) if call.status == Status::Discard => Ok(false),
            done => done.map(|()| true),
        }
    }

    /// Computes the event indicators, where there are any.
    pub fn indicators(&mut self, into: &mut [f64]) -> Called {
        match into {
            [] => Ok(()),
            into => self.read(self.functions.get_event_indicators, into),
        }
    }

    /// Says that a step is done. Whether the FMU wants an event, and whether it ends the simulation.
    pub fn completed(&mut self) -> Called<[bool; 2]> {
        let base = self.model.base_mut();
        match self.functions.special {
            Special::Steps(_) => Ok([false; 2]),
            Special::Two { completed, .. } if !completed.is_there() || self.declared.completed_not_needed => {
                Ok([false; 2])
            }
            Special::Two { completed, .. } => {
                let (mut event, mut ends) = (0, 0);
                // SAFETY: the component is alive, and both places are valid.
                base.call(completed, |completed, of| unsafe { completed(of, 1, &raw mut event, &raw mut ends) })?;
                Ok([event != 0, ends != 0])
            }
            Special::Three { completed, .. } => {
                let (mut event, mut ends) = (0, 0);
                // SAFETY: the component is alive, and both places are valid.
                base.call(completed, |completed, of| unsafe { completed(of, true, &raw mut event, &raw mut ends) })?;
                Ok([event != 0, ends != 0])
            }
        }
    }

    /// Enters event mode.
    pub fn enter_events(&mut self) -> Called {
        self.model.base_mut().plain(self.functions.enter_event_mode)
    }

    /// Leaves event mode.
    pub fn leave_events(&mut self) -> Called {
        self.model.base_mut().plain(self.functions.leave_event_mode)
    }

    /// Makes a round of events.
    pub fn update(&mut self) -> Called<Update> {
        let base = self.model.base_mut();
        let (flags, next) = match self.functions.special {
            Special::Two { update, .. } => {
                let mut info = EventInfo::default();
                // SAFETY: the component is alive, and the struct is a valid place to write to.
                base.call(update, |update, of| unsafe { update(of, &raw mut info) })?;
                let EventInfo { flags, next } = info;
                (flags.map(|flag| flag != 0), next)
            }
            Special::Three { update, .. } | Special::Steps(update) => {
                let (mut flags, mut next) = ([0; 5], 0.0);
                let [again, ends, nominals, states, known] = &mut flags;
                // SAFETY: the component is alive, and the six places are valid.
                base.call(update, |update, of| unsafe {
                    update(of, again, ends, nominals, states, known, &raw mut next)
                })?;
                (flags.map(|flag| flag != 0), next)
            }
        };
        let [again, ends, nominals, states, known] = flags;
        Ok(Update { again, ends, nominals, states, next: known.then_some(next) })
    }
}
