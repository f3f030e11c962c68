//! The equations of an FMU for Model Exchange: the functions of both versions, which differ in few signatures.

use std::ffi::c_int;

use crate::call::Call;
use crate::caller::Caller;
use crate::description::ExchangeSizes;
use crate::symbols::{Component, Function, LibraryError, Plain, Symbols};
use crate::version::Version;

type Read = unsafe extern "C" fn(Component, *mut f64, usize) -> c_int;
type Write = unsafe extern "C" fn(Component, *const f64, usize) -> c_int;
type Count = unsafe extern "C" fn(Component, *mut usize) -> c_int;

/// The struct `fmi2EventInfo`.
#[repr(C)]
#[derive(Debug, Default)]
struct EventInfo {
    again: c_int,
    ends: c_int,
    nominals: c_int,
    states: c_int,
    next_is_defined: c_int,
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
        completed:
            Function<unsafe extern "C" fn(Component, c_int, *mut c_int, *mut c_int) -> c_int>,
    },
    Three {
        update: Function<UpdateDiscreteStates>,
        completed: Function<unsafe extern "C" fn(Component, bool, *mut u8, *mut u8) -> c_int>,
        count_states: Function<Count>,
        count_indicators: Function<Count>,
    },
}

/// The functions of Model Exchange.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Functions {
    enter_event_mode: Function<Plain>,
    enter_continuous_time_mode: Function<Plain>,
    set_time: Function<unsafe extern "C" fn(Component, f64) -> c_int>,
    set_continuous_states: Function<Write>,
    get_derivatives: Function<Read>,
    get_event_indicators: Function<Read>,
    get_continuous_states: Function<Read>,
    get_nominals: Function<Read>,
    special: Special,
}

impl Functions {
    /// Finds them in a loaded binary.
    pub(crate) fn find(symbols: &Symbols<'_>) -> Result<Self, LibraryError> {
        let rates = match symbols.version {
            Version::Two => "GetDerivatives",
            Version::Three => "GetContinuousStateDerivatives",
        };
        // Some FMUs of FMI 2.0 leave out what they do not need.
        let read = |name| match symbols.version {
            Version::Two => Ok(symbols.find(name)),
            Version::Three => symbols.need(name),
        };
        Ok(Self {
            enter_event_mode: symbols.need("EnterEventMode")?,
            enter_continuous_time_mode: symbols.need("EnterContinuousTimeMode")?,
            set_time: symbols.need("SetTime")?,
            set_continuous_states: symbols.need("SetContinuousStates")?,
            get_derivatives: symbols.need(rates)?,
            get_event_indicators: read("GetEventIndicators")?,
            get_continuous_states: symbols.need("GetContinuousStates")?,
            get_nominals: read("GetNominalsOfContinuousStates")?,
            special: match symbols.version {
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
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Update {
    /// Another round is needed.
    pub(super) again: bool,
    /// The FMU ends the simulation.
    pub(super) ends: bool,
    /// The nominal values have changed.
    pub(super) nominals: bool,
    /// The states have changed.
    pub(super) states: bool,
    /// The time of the next event that is known beforehand, s.
    pub(super) next: Option<f64>,
}

/// The equations of a component.
#[derive(Debug)]
pub(super) struct Equations {
    pub(super) component: Component,
    pub(super) functions: Functions,
    /// The declarations in a description of FMI 2.0.
    pub(super) declared: ExchangeSizes,
}

impl Equations {
    /// The function under which the integrator's own failures are told, by which a user finds them in the standard.
    pub(super) fn step(&self) -> &'static str {
        match self.functions.special {
            Special::Two { completed, .. } => completed.name,
            Special::Three { completed, .. } => completed.name,
        }
    }

    #[inline(never)]
    fn read(
        &self,
        caller: &mut Caller,
        function: Function<Read>,
        into: &mut [f64],
    ) -> Result<(), Call> {
        let (code, place, count) = (function.get()?, into.as_mut_ptr(), into.len());
        // SAFETY: the component is alive, and there is room for as many numbers as stated.
        let status = caller.call(|| unsafe { code(self.component, place, count) });
        caller.check(function.name, status)
    }

    fn count(&self, caller: &mut Caller, function: Function<Count>) -> Result<usize, Call> {
        let (code, mut count) = (function.get()?, 0);
        // SAFETY: the component is alive, and the count is a valid place to write to.
        let status = caller.call(|| unsafe { code(self.component, &raw mut count) });
        caller.check(function.name, status)?;
        Ok(count)
    }

    /// How many states and event indicators there are.
    pub(super) fn sizes(&self, caller: &mut Caller) -> Result<[usize; 2], Call> {
        match self.functions.special {
            Special::Two { .. } => Ok([self.declared.states, self.declared.indicators]),
            Special::Three {
                count_states,
                count_indicators,
                ..
            } => Ok([
                self.count(caller, count_states)?,
                self.count(caller, count_indicators)?,
            ]),
        }
    }

    /// Sets the time, s.
    #[inline(never)]
    pub(super) fn set_time(&self, caller: &mut Caller, time: f64) -> Result<(), Call> {
        let (function, set) = (self.functions.set_time, self.functions.set_time.get()?);
        // SAFETY: the component is alive.
        let status = caller.call(|| unsafe { set(self.component, time) });
        caller.check(function.name, status)
    }

    /// Sets the states.
    #[inline(never)]
    pub(super) fn set_states(&self, caller: &mut Caller, states: &[f64]) -> Result<(), Call> {
        let function = self.functions.set_continuous_states;
        let (set, place, count) = (function.get()?, states.as_ptr(), states.len());
        // SAFETY: the component is alive, and there are as many states as stated.
        let status = caller.call(|| unsafe { set(self.component, place, count) });
        caller.check(function.name, status)
    }

    /// Reads the states.
    pub(super) fn states(&self, caller: &mut Caller, into: &mut [f64]) -> Result<(), Call> {
        self.read(caller, self.functions.get_continuous_states, into)
    }

    /// Reads the typical magnitudes of the states: 1 where the FMU does not tell them.
    pub(super) fn nominals(&self, caller: &mut Caller, into: &mut [f64]) -> Result<(), Call> {
        let get = self.functions.get_nominals;
        if get.is_there() {
            return self.read(caller, get, into);
        }
        into.fill(1.0);
        Ok(())
    }

    /// Computes the rates of the states.
    pub(super) fn rates(&self, caller: &mut Caller, into: &mut [f64]) -> Result<(), Call> {
        self.read(caller, self.functions.get_derivatives, into)
    }

    /// Computes the event indicators.
    pub(super) fn indicators(&self, caller: &mut Caller, into: &mut [f64]) -> Result<(), Call> {
        self.read(caller, self.functions.get_event_indicators, into)
    }

    /// Says that a step is done. Whether the FMU wants an event, and whether it ends the simulation.
    pub(super) fn completed(&self, caller: &mut Caller) -> Result<[bool; 2], Call> {
        let (status, told) = match self.functions.special {
            Special::Two { completed, .. } => {
                let wanted = completed.get().ok();
                let Some(code) = wanted.filter(|_| !self.declared.completed_not_needed) else {
                    return Ok([false; 2]);
                };
                let (mut event, mut ends): (c_int, c_int) = (0, 0);
                // SAFETY: the component is alive, and both places are valid.
                let status = caller
                    .call(|| unsafe { code(self.component, 1, &raw mut event, &raw mut ends) });
                (status, [event != 0, ends != 0])
            }
            Special::Three { completed, .. } => {
                let (code, mut event, mut ends) = (completed.get()?, 0, 0);
                // SAFETY: the component is alive, and both places are valid.
                let status = caller
                    .call(|| unsafe { code(self.component, true, &raw mut event, &raw mut ends) });
                (status, [event != 0, ends != 0])
            }
        };
        caller.check(self.step(), status)?;
        Ok(told)
    }

    /// Enters event mode.
    pub(super) fn enter_events(&self, caller: &mut Caller) -> Result<(), Call> {
        self.component
            .plain(caller, self.functions.enter_event_mode)
    }

    /// Leaves event mode.
    pub(super) fn leave_events(&self, caller: &mut Caller) -> Result<(), Call> {
        self.component
            .plain(caller, self.functions.enter_continuous_time_mode)
    }

    /// Makes a round of events.
    pub(super) fn update(&self, caller: &mut Caller) -> Result<Update, Call> {
        match self.functions.special {
            Special::Two { update, .. } => {
                let (code, mut info) = (update.get()?, EventInfo::default());
                // SAFETY: the component is alive, and the struct is a valid place to write to.
                let status = caller.call(|| unsafe { code(self.component, &raw mut info) });
                caller.check(update.name, status)?;
                Ok(Update {
                    again: info.again != 0,
                    ends: info.ends != 0,
                    nominals: info.nominals != 0,
                    states: info.states != 0,
                    next: (info.next_is_defined != 0).then_some(info.next),
                })
            }
            Special::Three { update, .. } => {
                let (code, mut flags, mut next) = (update.get()?, [0; 5], 0.0);
                let [again, ends, nominals, states, known] = &mut flags;
                // SAFETY: the component is alive, and the six places are valid.
                let status = caller.call(|| unsafe {
                    let component = self.component;
                    code(
                        component,
                        again,
                        ends,
                        nominals,
                        states,
                        known,
                        &raw mut next,
                    )
                });
                caller.check(update.name, status)?;
                let [again, ends, nominals, states, known] = flags.map(|flag| flag != 0);
                Ok(Update {
                    again,
                    ends,
                    nominals,
                    states,
                    next: known.then_some(next),
                })
            }
        }
    }
}
