//! States of an instance that are kept and restored.

use thiserror::Error;

use crate::{call::Call, floating_point::Mode, instance::Instance, symbols::Saved};

/// A state of one instance. Give it back to that instance with [`Instance::forget`]: a state that
/// is dropped keeps its memory, as only a living instance can free it.
#[derive(Debug)]
pub struct State {
    /// The [`Instance::number`] of its instance.
    owner: u64,
    state: Saved,
    /// How the FMU calculated then.
    mode: Mode,
}

/// Why a state cannot be restored or given back.
#[derive(Clone, Debug, Error)]
pub enum StateError {
    /// Another instance has kept the state. To the FMU it is an address of that instance's memory.
    #[error("the state is one of another instance; give it to the instance that has kept it")]
    OfAnother,
    /// After `fmi2Fatal` or `fmi3Fatal` nothing may be called any more.
    #[error("the instance ended with a fatal status")]
    Dead,
    /// The FMU refused.
    #[error(transparent)]
    Call(#[from] Call),
}

impl Instance {
    /// Keeps the present state of the FMU; `None` where the FMU cannot.
    pub fn save(&mut self) -> Option<State> {
        if self.simulation.base().caller.dead {
            return None;
        }
        Some(State { owner: self.number, state: self.simulation.save()?, mode: self.simulation.base().caller.mode })
    }

    /// Takes the instance back to a state that it has kept.
    ///
    /// # Errors
    /// When the state is not one of this instance, and when the FMU refuses; then a new instance
    /// is needed.
    pub fn restore(&mut self, state: &State) -> Result<(), StateError> {
        self.owns(state)?;
        self.simulation.base().caller.log.clear();
        let restored = self.simulation.restore(state.state);
        self.simulation.base_mut().caller.mode = state.mode;
        Ok(restored?)
    }

    /// Gives back what a state occupies.
    ///
    /// # Errors
    /// When the state is not one of this instance; nothing has been freed then.
    pub fn forget(&mut self, state: State) -> Result<(), StateError> {
        self.owns(&state)?;
        Ok(self.simulation.forget(state.state)?)
    }

    fn owns(&self, state: &State) -> Result<(), StateError> {
        if state.owner != self.number {
            return Err(StateError::OfAnother);
        }
        if self.simulation.base().caller.dead {
            return Err(StateError::Dead);
        }
        Ok(())
    }
}
