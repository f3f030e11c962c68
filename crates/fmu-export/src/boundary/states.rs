//! Saved states, as C hosts ask for them: the same functions in all versions, under different names.
//!
//! # Safety
//! As for the functions of [`fmi2::calls`](crate::fmi2::calls).
#![allow(clippy::missing_safety_doc)] // said above for all functions

use super::guard::enter;
use super::instance::Instance;
use super::phase::Function;
use super::raw::{place, values, values_mut};
use super::refusal::Refusal;
use super::types::{Component, FmuState, Status};
use crate::model::Model;

/// Saves the instance's state.
pub unsafe fn get<M: Model>(
    component: Component,
    state: *mut FmuState,
    function: &Function,
) -> Status {
    let name = function.version.state();
    // SAFETY: as the host vouches.
    let body = |instance: &mut Instance<M>| unsafe { instance.save(place(state, name)?) };
    // SAFETY: as the host vouches.
    unsafe { enter(component, function, body) }
}

/// Goes back to a saved state.
pub unsafe fn set<M: Model>(component: Component, state: FmuState, function: &Function) -> Status {
    // SAFETY: as the host vouches.
    let body = |instance: &mut Instance<M>| unsafe { instance.restore(state) };
    // SAFETY: as the host vouches.
    unsafe { enter(component, function, body) }
}

/// Frees a saved state. NULL, and a pointer to NULL, are left alone.
pub unsafe fn free<M: Model>(
    component: Component,
    state: *mut FmuState,
    function: &Function,
) -> Status {
    let version = function.version;
    let body = |_: &mut Instance<M>| {
        if state.is_null() {
            return Ok(Status::Ok);
        }
        // SAFETY: as the host vouches.
        unsafe { Instance::<M>::free_state(place(state, version.state())?, version) }
    };
    // SAFETY: as the host vouches.
    unsafe { enter(component, function, body) }
}

/// Tells the number of bytes that a saved state takes.
pub unsafe fn size<M: Model>(
    component: Component,
    state: FmuState,
    size: *mut usize,
    function: &Function,
) -> Status {
    let body = |instance: &mut Instance<M>| {
        // SAFETY: as the host vouches.
        let (place, bytes) = unsafe { (place(size, "size")?, instance.serialize(state)?) };
        *place = bytes.len();
        Ok(Status::Ok)
    };
    // SAFETY: as the host vouches.
    unsafe { enter(component, function, body) }
}

/// Writes a saved state as bytes.
pub unsafe fn serialize<M: Model>(
    component: Component,
    state: FmuState,
    serialized: *mut u8,
    size: usize,
    function: &Function,
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
        unsafe { values_mut(serialized, bytes.len(), "serializedState") }?.copy_from_slice(&bytes);
        Ok(Status::Ok)
    };
    // SAFETY: as the host vouches.
    unsafe { enter(component, function, body) }
}

/// Makes a saved state of bytes.
pub unsafe fn deserialize<M: Model>(
    component: Component,
    serialized: *const u8,
    size: usize,
    state: *mut FmuState,
    function: &Function,
) -> Status {
    let name = function.version.state();
    let body = |instance: &mut Instance<M>| {
        // SAFETY: as the host vouches.
        let (bytes, place) = unsafe {
            (
                values(serialized, size, "serializedState")?,
                place(state, name)?,
            )
        };
        instance.deserialize(bytes, place)
    };
    // SAFETY: as the host vouches.
    unsafe { enter(component, function, body) }
}
