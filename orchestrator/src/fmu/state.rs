//! States of an instance that are kept and restored.

use std::ffi::{c_int, c_void};
use std::ptr;

use super::call::Call;
use super::instance::Instance;
use super::library::Component;

/// A state of one instance. It must be given back to that instance with [`Instance::forget`].
#[derive(Debug)]
pub struct State {
    state: *mut c_void,
    free: unsafe extern "C" fn(Component, *mut *mut c_void) -> c_int,
}

// SAFETY: as for the instance to which it belongs.
unsafe impl Send for State {}

impl Instance {
    /// Keeps the present state of the FMU; `None` where the FMU cannot.
    pub fn save(&mut self) -> Option<State> {
        let functions = self.functions;
        let (get, _, free) = functions.states?;
        let mut state = ptr::null_mut();
        // SAFETY: the component is alive, and the state is a valid place to write to.
        let status = unsafe { get(self.component, &raw mut state) };
        self.check("fmi2GetFMUstate", status).ok()?;
        Some(State { state, free })
    }

    /// Takes the instance back to a state that it has kept.
    ///
    /// # Errors
    /// When the FMU cannot; then a new instance is needed.
    pub fn restore(&mut self, state: &State) -> Result<(), Call> {
        let states = self.functions.states;
        let (_, set, _) = states.ok_or_else(|| Self::missing("fmi2SetFMUstate"))?;
        self.log.clear();
        // SAFETY: the component is alive, and the state is one of its own.
        let status = unsafe { set(self.component, state.state) };
        self.check("fmi2SetFMUstate", status)
    }

    /// Gives back what a state occupies.
    pub fn forget(&mut self, mut state: State) {
        if !self.dead {
            // SAFETY: the component is alive, and the state is one of its own, used no more.
            unsafe { (state.free)(self.component, &raw mut state.state) };
        }
    }
}
