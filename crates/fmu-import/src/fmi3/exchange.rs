//! A component of FMI 3.0 for Model Exchange.

use std::ffi::c_int;

use libloading::Library as Loaded;

use super::simulation::Model;
use crate::call::Call;
use crate::caller::Caller;
use crate::exchange::{Equations, Update};
use crate::simulation::{Component, Simulation};
use crate::symbols::{LibraryError, symbol};

type Plain = unsafe extern "C" fn(Component) -> c_int;
type Read = unsafe extern "C" fn(Component, *mut f64, usize) -> c_int;
type Count = unsafe extern "C" fn(Component, *mut usize) -> c_int;
/// `fmi3UpdateDiscreteStates`. The flags are bytes rather than `bool`, as an FMU may write any.
type UpdateDiscreteStates =
    unsafe extern "C" fn(Component, *mut u8, *mut u8, *mut u8, *mut u8, *mut u8, *mut f64) -> c_int;

/// The functions of Model Exchange.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ExchangeFunctions {
    enter_event_mode: Plain,
    update_discrete_states: UpdateDiscreteStates,
    enter_continuous_time_mode: Plain,
    completed_integrator_step: unsafe extern "C" fn(Component, bool, *mut u8, *mut u8) -> c_int,
    set_time: unsafe extern "C" fn(Component, f64) -> c_int,
    set_continuous_states: unsafe extern "C" fn(Component, *const f64, usize) -> c_int,
    get_derivatives: Read,
    get_event_indicators: Read,
    get_continuous_states: Read,
    get_nominals: Read,
    count_states: Count,
    count_indicators: Count,
}

impl ExchangeFunctions {
    /// Finds them in a loaded binary.
    pub(crate) fn find(library: &Loaded) -> Result<Self, LibraryError> {
        Ok(Self {
            enter_event_mode: symbol(library, "fmi3EnterEventMode")?,
            update_discrete_states: symbol(library, "fmi3UpdateDiscreteStates")?,
            enter_continuous_time_mode: symbol(library, "fmi3EnterContinuousTimeMode")?,
            completed_integrator_step: symbol(library, "fmi3CompletedIntegratorStep")?,
            set_time: symbol(library, "fmi3SetTime")?,
            set_continuous_states: symbol(library, "fmi3SetContinuousStates")?,
            get_derivatives: symbol(library, "fmi3GetContinuousStateDerivatives")?,
            get_event_indicators: symbol(library, "fmi3GetEventIndicators")?,
            get_continuous_states: symbol(library, "fmi3GetContinuousStates")?,
            get_nominals: symbol(library, "fmi3GetNominalsOfContinuousStates")?,
            count_states: symbol(library, "fmi3GetNumberOfContinuousStates")?,
            count_indicators: symbol(library, "fmi3GetNumberOfEventIndicators")?,
        })
    }
}

/// A component for Model Exchange.
#[derive(Debug)]
pub(crate) struct ExchangeModel {
    model: Model,
    functions: ExchangeFunctions,
}

impl ExchangeModel {
    /// The equations of a component.
    pub(crate) fn new(model: Model, functions: ExchangeFunctions) -> Self {
        Self { model, functions }
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

    fn count(
        &mut self,
        caller: &mut Caller,
        function: Count,
        name: &'static str,
    ) -> Result<usize, Call> {
        let mut count = 0;
        // SAFETY: the component is alive, and the count is a valid place to write to.
        let status = caller.call(|| unsafe { function(self.model.component, &raw mut count) });
        caller.check(name, status)?;
        Ok(count)
    }
}

impl Equations for ExchangeModel {
    const STEP: &'static str = "fmi3CompletedIntegratorStep";

    fn component(&mut self) -> &mut dyn Simulation {
        &mut self.model
    }

    fn sizes(&mut self, caller: &mut Caller) -> Result<[usize; 2], Call> {
        let functions = self.functions;
        let states = functions.count_states;
        let indicators = functions.count_indicators;
        Ok([
            self.count(caller, states, "fmi3GetNumberOfContinuousStates")?,
            self.count(caller, indicators, "fmi3GetNumberOfEventIndicators")?,
        ])
    }

    fn set_time(&mut self, caller: &mut Caller, time: f64) -> Result<(), Call> {
        let set = self.functions.set_time;
        // SAFETY: the component is alive.
        let status = caller.call(|| unsafe { set(self.model.component, time) });
        caller.check("fmi3SetTime", status)
    }

    fn set_states(&mut self, caller: &mut Caller, states: &[f64]) -> Result<(), Call> {
        let set = self.functions.set_continuous_states;
        let (place, count) = (states.as_ptr(), states.len());
        // SAFETY: the component is alive, and there are as many states as stated.
        let status = caller.call(|| unsafe { set(self.model.component, place, count) });
        caller.check("fmi3SetContinuousStates", status)
    }

    fn states(&mut self, caller: &mut Caller, into: &mut [f64]) -> Result<(), Call> {
        let get = self.functions.get_continuous_states;
        self.read(caller, get, "fmi3GetContinuousStates", into)
    }

    fn nominals(&mut self, caller: &mut Caller, into: &mut [f64]) -> Result<(), Call> {
        let get = self.functions.get_nominals;
        self.read(caller, get, "fmi3GetNominalsOfContinuousStates", into)
    }

    #[inline(never)]
    fn rates(&mut self, caller: &mut Caller, into: &mut [f64]) -> Result<(), Call> {
        let get = self.functions.get_derivatives;
        self.read(caller, get, "fmi3GetContinuousStateDerivatives", into)
    }

    #[inline(never)]
    fn indicators(&mut self, caller: &mut Caller, into: &mut [f64]) -> Result<(), Call> {
        let get = self.functions.get_event_indicators;
        self.read(caller, get, "fmi3GetEventIndicators", into)
    }

    fn completed(&mut self, caller: &mut Caller) -> Result<[bool; 2], Call> {
        let completed = self.functions.completed_integrator_step;
        let (mut event, mut ends) = (0_u8, 0_u8);
        // SAFETY: the component is alive, and both places are valid.
        let status = caller.call(|| unsafe {
            completed(self.model.component, true, &raw mut event, &raw mut ends)
        });
        caller.check(Self::STEP, status)?;
        Ok([event != 0, ends != 0])
    }

    fn enter_events(&mut self, caller: &mut Caller) -> Result<(), Call> {
        let enter = self.functions.enter_event_mode;
        self.plain(caller, enter, "fmi3EnterEventMode")
    }

    fn update(&mut self, caller: &mut Caller) -> Result<Update, Call> {
        let (mut again, mut ends, mut nominals, mut states, mut known) =
            (0_u8, 0_u8, 0_u8, 0_u8, 0_u8);
        let mut next = 0.0;
        let update = self.functions.update_discrete_states;
        // SAFETY: the component is alive, and the six places are valid.
        let status = caller.call(|| unsafe {
            update(
                self.model.component,
                &raw mut again,
                &raw mut ends,
                &raw mut nominals,
                &raw mut states,
                &raw mut known,
                &raw mut next,
            )
        });
        caller.check("fmi3UpdateDiscreteStates", status)?;
        Ok(Update {
            again: again != 0,
            ends: ends != 0,
            nominals: nominals != 0,
            states: states != 0,
            next: (known != 0).then_some(next),
        })
    }

    fn leave_events(&mut self, caller: &mut Caller) -> Result<(), Call> {
        let enter = self.functions.enter_continuous_time_mode;
        self.plain(caller, enter, "fmi3EnterContinuousTimeMode")
    }
}
