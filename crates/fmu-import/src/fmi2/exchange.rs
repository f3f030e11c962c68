//! A component of FMI 2.0 for Model Exchange.

use std::ffi::c_int;

use libloading::Library as Loaded;

use super::simulation::Model;
use crate::call::Call;
use crate::caller::Caller;
use crate::description::ExchangeSizes;
use crate::exchange::{Equations, Update};
use crate::simulation::{Component, Simulation};
use crate::symbols::{LibraryError, symbol};

type Plain = unsafe extern "C" fn(Component) -> c_int;
type Read = unsafe extern "C" fn(Component, *mut f64, usize) -> c_int;

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

/// The functions of Model Exchange.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ExchangeFunctions {
    enter_event_mode: Plain,
    new_discrete_states: unsafe extern "C" fn(Component, *mut EventInfo) -> c_int,
    enter_continuous_time_mode: Plain,
    completed_integrator_step:
        Option<unsafe extern "C" fn(Component, c_int, *mut c_int, *mut c_int) -> c_int>,
    set_time: unsafe extern "C" fn(Component, f64) -> c_int,
    set_continuous_states: unsafe extern "C" fn(Component, *const f64, usize) -> c_int,
    get_derivatives: Read,
    get_event_indicators: Option<Read>,
    get_continuous_states: Read,
    get_nominals: Option<Read>,
}

impl ExchangeFunctions {
    /// Finds them in a loaded binary.
    pub(crate) fn find(library: &Loaded) -> Result<Self, LibraryError> {
        Ok(Self {
            enter_event_mode: symbol(library, "fmi2EnterEventMode")?,
            new_discrete_states: symbol(library, "fmi2NewDiscreteStates")?,
            enter_continuous_time_mode: symbol(library, "fmi2EnterContinuousTimeMode")?,
            completed_integrator_step: symbol(library, "fmi2CompletedIntegratorStep").ok(),
            set_time: symbol(library, "fmi2SetTime")?,
            set_continuous_states: symbol(library, "fmi2SetContinuousStates")?,
            get_derivatives: symbol(library, "fmi2GetDerivatives")?,
            get_event_indicators: symbol(library, "fmi2GetEventIndicators").ok(),
            get_continuous_states: symbol(library, "fmi2GetContinuousStates")?,
            get_nominals: symbol(library, "fmi2GetNominalsOfContinuousStates").ok(),
        })
    }
}

/// A component for Model Exchange.
#[derive(Debug)]
pub(crate) struct ExchangeModel {
    model: Model,
    functions: ExchangeFunctions,
    sizes: ExchangeSizes,
}

impl ExchangeModel {
    /// The equations of a component.
    pub(crate) fn new(model: Model, functions: ExchangeFunctions, sizes: ExchangeSizes) -> Self {
        Self {
            model,
            functions,
            sizes,
        }
    }

    fn plain(
        &mut self,
        caller: &mut Caller,
        function: Plain,
        name: &'static str,
    ) -> Result<(), Call> {
        // SAFETY: the component is alive.
        let status = caller.call(|| unsafe { function(self.model.component) });
        caller.check(name, status)
    }

    fn read(
        &mut self,
        caller: &mut Caller,
        function: Read,
        name: &'static str,
        into: &mut [f64],
    ) -> Result<(), Call> {
        let (place, count) = (into.as_mut_ptr(), into.len());
        // SAFETY: the component is alive, and there is room for as many numbers as stated.
        let status = caller.call(|| unsafe { function(self.model.component, place, count) });
        caller.check(name, status)
    }
}

impl Equations for ExchangeModel {
    const STEP: &'static str = "fmi2CompletedIntegratorStep";

    fn component(&mut self) -> &mut dyn Simulation {
        &mut self.model
    }

    fn sizes(&mut self, _: &mut Caller) -> Result<[usize; 2], Call> {
        Ok([self.sizes.states, self.sizes.indicators])
    }

    fn set_time(&mut self, caller: &mut Caller, time: f64) -> Result<(), Call> {
        let set = self.functions.set_time;
        // SAFETY: the component is alive.
        let status = caller.call(|| unsafe { set(self.model.component, time) });
        caller.check("fmi2SetTime", status)
    }

    fn set_states(&mut self, caller: &mut Caller, states: &[f64]) -> Result<(), Call> {
        let set = self.functions.set_continuous_states;
        let (place, count) = (states.as_ptr(), states.len());
        // SAFETY: the component is alive, and there are as many states as stated.
        let status = caller.call(|| unsafe { set(self.model.component, place, count) });
        caller.check("fmi2SetContinuousStates", status)
    }

    fn states(&mut self, caller: &mut Caller, into: &mut [f64]) -> Result<(), Call> {
        let get = self.functions.get_continuous_states;
        self.read(caller, get, "fmi2GetContinuousStates", into)
    }

    fn nominals(&mut self, caller: &mut Caller, into: &mut [f64]) -> Result<(), Call> {
        match self.functions.get_nominals {
            Some(get) => self.read(caller, get, "fmi2GetNominalsOfContinuousStates", into),
            None => {
                into.fill(1.0);
                Ok(())
            }
        }
    }

    #[inline(never)]
    fn rates(&mut self, caller: &mut Caller, into: &mut [f64]) -> Result<(), Call> {
        let get = self.functions.get_derivatives;
        self.read(caller, get, "fmi2GetDerivatives", into)
    }

    #[inline(never)]
    fn indicators(&mut self, caller: &mut Caller, into: &mut [f64]) -> Result<(), Call> {
        const NAME: &str = "fmi2GetEventIndicators";
        let get = self.functions.get_event_indicators;
        let get = get.ok_or_else(|| Call::missing(NAME))?;
        self.read(caller, get, NAME, into)
    }

    fn completed(&mut self, caller: &mut Caller) -> Result<[bool; 2], Call> {
        let Some(completed) = self
            .functions
            .completed_integrator_step
            .filter(|_| !self.sizes.completed_not_needed)
        else {
            return Ok([false; 2]);
        };
        let (mut event, mut ends): (c_int, c_int) = (0, 0);
        // SAFETY: the component is alive, and both places are valid.
        let status = caller
            .call(|| unsafe { completed(self.model.component, 1, &raw mut event, &raw mut ends) });
        caller.check(Self::STEP, status)?;
        Ok([event != 0, ends != 0])
    }

    fn enter_events(&mut self, caller: &mut Caller) -> Result<(), Call> {
        let enter = self.functions.enter_event_mode;
        self.plain(caller, enter, "fmi2EnterEventMode")
    }

    fn update(&mut self, caller: &mut Caller) -> Result<Update, Call> {
        let mut info = EventInfo::default();
        let update = self.functions.new_discrete_states;
        // SAFETY: the component is alive, and the struct is a valid place to write to.
        let status = caller.call(|| unsafe { update(self.model.component, &raw mut info) });
        caller.check("fmi2NewDiscreteStates", status)?;
        Ok(Update {
            again: info.again != 0,
            ends: info.ends != 0,
            nominals: info.nominals != 0,
            states: info.states != 0,
            next: (info.next_is_defined != 0).then_some(info.next),
        })
    }

    fn leave_events(&mut self, caller: &mut Caller) -> Result<(), Call> {
        let enter = self.functions.enter_continuous_time_mode;
        self.plain(caller, enter, "fmi2EnterContinuousTimeMode")
    }
}
