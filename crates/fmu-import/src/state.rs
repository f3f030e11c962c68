//! States of an instance that are kept and restored.

use std::ffi::{c_int, c_void};
use std::ptr;

use thiserror::Error;

use crate::call::Call;
use crate::floating_point::{Mode, within};
use crate::instance::Instance;
use crate::library::Component;

/// A state of one instance. Give it back to that instance with [`Instance::forget`]: a state that
/// is dropped keeps its memory, as only a living instance can free it.
#[derive(Debug)]
pub struct State {
    /// The [`Instance::number`] of its instance.
    owner: u64,
    state: *mut c_void,
    /// How the FMU calculated then.
    mode: Mode,
    free: unsafe extern "C" fn(Component, *mut *mut c_void) -> c_int,
}

// SAFETY: as for the instance to which it belongs.
unsafe impl Send for State {}

/// Why a state cannot be restored or given back.
#[derive(Clone, Debug, Error)]
pub enum StateError {
    /// Another instance has kept the state. To the FMU it is an address of that instance's memory.
    #[error("the state is one of another instance; give it to the instance that has kept it")]
    OfAnother,
    /// After `fmi2Fatal` nothing may be called any more.
    #[error("the instance ended with fmi2Fatal")]
    Dead,
    /// The FMU refused.
    #[error(transparent)]
    Call(#[from] Call),
}

impl Instance {
    /// Keeps the present state of the FMU; `None` where the FMU cannot.
    pub fn save(&mut self) -> Option<State> {
        let functions = self.functions;
        let (get, _, free) = functions.states.filter(|_| !self.dead)?;
        let mut state = ptr::null_mut();
        // SAFETY: the component is alive, and the state is a valid place to write to.
        let status = within(&mut self.mode, || unsafe {
            get(self.component, &raw mut state)
        });
        self.check("fmi2GetFMUstate", status).ok()?;
        Some(State {
            owner: self.number,
            state,
            mode: self.mode,
            free,
        })
    }

    /// Takes the instance back to a state that it has kept.
    ///
    /// # Errors
    /// When the state is not one of this instance, and when the FMU refuses; then a new instance
    /// is needed.
    pub fn restore(&mut self, state: &State) -> Result<(), StateError> {
        self.owns(state)?;
        let states = self.functions.states;
        let (_, set, _) = states.ok_or_else(|| Self::missing("fmi2SetFMUstate"))?;
        self.forget_messages();
        // SAFETY: the component is alive, and the state is one of its own.
        let status = within(&mut self.mode, || unsafe {
            set(self.component, state.state)
        });
        self.mode = state.mode;
        Ok(self.check("fmi2SetFMUstate", status)?)
    }

    /// Gives back what a state occupies.
    ///
    /// # Errors
    /// When the state is not one of this instance; nothing has been freed then.
    pub fn forget(&mut self, mut state: State) -> Result<(), StateError> {
        self.owns(&state)?;
        // SAFETY: the component is alive, and the state is one of its own, used no more.
        let status = within(&mut self.mode, || unsafe {
            (state.free)(self.component, &raw mut state.state)
        });
        Ok(self.check("fmi2FreeFMUstate", status)?)
    }

    fn owns(&self, state: &State) -> Result<(), StateError> {
        if state.owner != self.number {
            return Err(StateError::OfAnother);
        }
        if self.dead {
            return Err(StateError::Dead);
        }
        Ok(())
    }
}
