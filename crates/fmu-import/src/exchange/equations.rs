//! The equations of an FMU for Model Exchange.

use std::fmt::Debug;

use crate::call::Call;
use crate::caller::Caller;
use crate::simulation::Simulation;

/// What an FMU says after its events.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Update {
    /// Another round is needed.
    pub(crate) again: bool,
    /// The FMU ends the simulation.
    pub(crate) ends: bool,
    /// The nominal values have changed.
    pub(crate) nominals: bool,
    /// The states have changed.
    pub(crate) states: bool,
    /// The time of the next event that is known beforehand, s.
    pub(crate) next: Option<f64>,
}

/// The equations of an FMU, as every version of FMI gives them.
pub(crate) trait Equations: Debug + Send {
    /// The function under which the integrator's own failures are told, by which a user finds them in the standard.
    const STEP: &'static str;

    /// The component, by which variables are read and written.
    fn component(&mut self) -> &mut dyn Simulation;
    /// How many states and event indicators there are.
    fn sizes(&mut self, caller: &mut Caller) -> Result<[usize; 2], Call>;
    /// Sets the time, s.
    fn set_time(&mut self, caller: &mut Caller, time: f64) -> Result<(), Call>;
    /// Sets the states.
    fn set_states(&mut self, caller: &mut Caller, states: &[f64]) -> Result<(), Call>;
    /// Reads the states.
    fn states(&mut self, caller: &mut Caller, into: &mut [f64]) -> Result<(), Call>;
    /// Reads the typical magnitudes of the states.
    fn nominals(&mut self, caller: &mut Caller, into: &mut [f64]) -> Result<(), Call>;
    /// Computes the rates of the states.
    fn rates(&mut self, caller: &mut Caller, into: &mut [f64]) -> Result<(), Call>;
    /// Computes the event indicators.
    fn indicators(&mut self, caller: &mut Caller, into: &mut [f64]) -> Result<(), Call>;
    /// Says that a step is done. Whether the FMU wants an event, and whether it ends the simulation.
    fn completed(&mut self, caller: &mut Caller) -> Result<[bool; 2], Call>;
    /// Enters event mode.
    fn enter_events(&mut self, caller: &mut Caller) -> Result<(), Call>;
    /// Makes a round of events.
    fn update(&mut self, caller: &mut Caller) -> Result<Update, Call>;
    /// Leaves event mode.
    fn leave_events(&mut self, caller: &mut Caller) -> Result<(), Call>;
}
