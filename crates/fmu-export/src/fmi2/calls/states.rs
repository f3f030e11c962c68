//! Saved states.

use crate::fmi2::guard::enter;
use crate::fmi2::instance::Instance;
use crate::fmi2::phase;
use crate::fmi2::raw::{place, values, values_mut};
use crate::fmi2::refusal::Refusal;
use crate::fmi2::types::{Byte, Component, FmuState, Status};
use crate::model::Model;

/// `fmi2GetFMUstate`.
pub unsafe fn get_fmu_state<M: Model>(component: Component, state: *mut FmuState) -> Status {
    // SAFETY: as the host vouches.
    let body = |instance: &mut Instance<M>| unsafe { instance.save(place(state, "FMUstate")?) };
    // SAFETY: as the host vouches.
    unsafe { enter(component, &phase::GET_STATE, body) }
}

/// `fmi2SetFMUstate`.
pub unsafe fn set_fmu_state<M: Model>(component: Component, state: FmuState) -> Status {
    // SAFETY: as the host vouches.
    let body = |instance: &mut Instance<M>| unsafe { instance.restore(state) };
    // SAFETY: as the host vouches.
    unsafe { enter(component, &phase::SET_STATE, body) }
}

/// `fmi2FreeFMUstate`. NULL, and a pointer to NULL, are left alone.
pub unsafe fn free_fmu_state<M: Model>(component: Component, state: *mut FmuState) -> Status {
    let body = |_: &mut Instance<M>| {
        if state.is_null() {
            return Ok(Status::Ok);
        }
        // SAFETY: as the host vouches.
        unsafe { Instance::<M>::free_state(place(state, "FMUstate")?) }
    };
    // SAFETY: as the host vouches.
    unsafe { enter(component, &phase::FREE_STATE, body) }
}

/// `fmi2SerializedFMUstateSize`.
pub unsafe fn serialized_fmu_state_size<M: Model>(
    component: Component,
    state: FmuState,
    size: *mut usize,
) -> Status {
    let body = |instance: &mut Instance<M>| {
        // SAFETY: as the host vouches.
        let (place, bytes) = unsafe { (place(size, "size")?, instance.serialize(state)?) };
        *place = bytes.len();
        Ok(Status::Ok)
    };
    // SAFETY: as the host vouches.
    unsafe { enter(component, &phase::SERIALIZED_SIZE, body) }
}

/// `fmi2SerializeFMUstate`.
pub unsafe fn serialize_fmu_state<M: Model>(
    component: Component,
    state: FmuState,
    serialized: *mut Byte,
    size: usize,
) -> Status {
    let body = |instance: &mut Instance<M>| {
        // SAFETY: as the host vouches.
        let bytes = unsafe { instance.serialize(state) }?;
        if size < bytes.len() {
            return Err(Refusal::Size {
                given: size,
                needed: bytes.len(),
            });
        }
        // SAFETY: as the host vouches; there is room for that many bytes.
        unsafe { values_mut(serialized.cast::<u8>(), bytes.len(), "serializedState") }?
            .copy_from_slice(&bytes);
        Ok(Status::Ok)
    };
    // SAFETY: as the host vouches.
    unsafe { enter(component, &phase::SERIALIZE, body) }
}

/// `fmi2DeSerializeFMUstate`.
pub unsafe fn deserialize_fmu_state<M: Model>(
    component: Component,
    serialized: *const Byte,
    size: usize,
    state: *mut FmuState,
) -> Status {
    let body = |instance: &mut Instance<M>| {
        // SAFETY: as the host vouches.
        let (bytes, place) = unsafe {
            (
                values(serialized.cast::<u8>(), size, "serializedState")?,
                place(state, "FMUstate")?,
            )
        };
        instance.deserialize(bytes, place)
    };
    // SAFETY: as the host vouches.
    unsafe { enter(component, &phase::DESERIALIZE, body) }
}
