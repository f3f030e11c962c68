//! Saved states.

use crate::boundary::states;
use crate::fmi2::functions;
use crate::fmi2::types::{Byte, Component, FmuState, Status};
use crate::model::Model;

/// `fmi2GetFMUstate`.
pub unsafe fn get_fmu_state<M: Model>(component: Component, state: *mut FmuState) -> Status {
    // SAFETY: as the host vouches.
    unsafe { states::get::<M>(component, state, &functions::GET_STATE) }
}

/// `fmi2SetFMUstate`.
pub unsafe fn set_fmu_state<M: Model>(component: Component, state: FmuState) -> Status {
    // SAFETY: as the host vouches.
    unsafe { states::set::<M>(component, state, &functions::SET_STATE) }
}

/// `fmi2FreeFMUstate`. NULL, and a pointer to NULL, are left alone.
pub unsafe fn free_fmu_state<M: Model>(component: Component, state: *mut FmuState) -> Status {
    // SAFETY: as the host vouches.
    unsafe { states::free::<M>(component, state, &functions::FREE_STATE) }
}

/// `fmi2SerializedFMUstateSize`.
pub unsafe fn serialized_fmu_state_size<M: Model>(
    component: Component,
    state: FmuState,
    size: *mut usize,
) -> Status {
    // SAFETY: as the host vouches.
    unsafe { states::size::<M>(component, state, size, &functions::SERIALIZED_SIZE) }
}

/// `fmi2SerializeFMUstate`.
pub unsafe fn serialize_fmu_state<M: Model>(
    component: Component,
    state: FmuState,
    serialized: *mut Byte,
    size: usize,
) -> Status {
    let function = &functions::SERIALIZE;
    // SAFETY: as the host vouches.
    unsafe { states::serialize::<M>(component, state, serialized.cast(), size, function) }
}

/// `fmi2DeSerializeFMUstate`.
pub unsafe fn deserialize_fmu_state<M: Model>(
    component: Component,
    serialized: *const Byte,
    size: usize,
    state: *mut FmuState,
) -> Status {
    let function = &functions::DESERIALIZE;
    // SAFETY: as the host vouches.
    unsafe { states::deserialize::<M>(component, serialized.cast(), size, state, function) }
}
