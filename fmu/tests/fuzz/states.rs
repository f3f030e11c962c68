//! Saved states: kept, restored, written down, damaged and forged.

use std::ptr::null_mut;

use fmu_export::fmi2::types::{Component, FmuState, Status};

use crate::acts::MOST;
use crate::host::{Host, saving};

/// Bytes in front of the payload: mark, version, fingerprint, length, checksum.
const HEADER: usize = 8 + 2 + 16 + 8 + 4;

/// The names of the functions for saved states.
pub struct Names {
    pub get: &'static str,
    pub set: &'static str,
    pub free: &'static str,
    pub size: &'static str,
    pub deserialize: &'static str,
}

/// Does something with saved states.
pub fn act(host: &mut Host, component: Component) {
    match host.random.below(8) {
        0 | 1 => save(host, component),
        2 | 3 => restore(host, component),
        4 => free(host, component),
        5 => strange(host, component),
        _ if host.instances.contains(&component) => written(host, component),
        _ => {}
    }
}

/// A saved state, or NULL.
fn any(host: &mut Host) -> FmuState {
    match host.states.len() {
        0 => null_mut(),
        n => host.states[host.random.below(n)],
    }
}

fn save(host: &mut Host, component: Component) {
    let old = if host.states.len() < MOST {
        null_mut()
    } else {
        any(host)
    };
    let mut state = old;
    // SAFETY: NULL, or a state that is alive; the place is ours.
    let status = host.call(saving::NAMES.get, component, |c| unsafe {
        saving::get(c, &raw mut state)
    });
    assert!(old.is_null() || state == old, "a state is used again");
    if status == Status::Ok {
        host.copied(component, state);
        if old.is_null() {
            host.states.push(state);
        }
    }
}

fn restore(host: &mut Host, component: Component) {
    let state = any(host);
    // SAFETY: NULL, or a state that is alive.
    let status = host.call(saving::NAMES.set, component, |c| unsafe {
        saving::set(c, state)
    });
    if status == Status::Ok {
        host.copied(state, component);
    }
    if status == Status::Ok && host.random.once_in(8) {
        let saved = host.bytes(component, state);
        assert!(
            saved == host.bytes_of(component),
            "restored, but not the same"
        );
    }
}

fn free(host: &mut Host, component: Component) {
    if host.states.is_empty() || !host.instances.contains(&component) {
        return;
    }
    let index = host.random.below(host.states.len());
    let mut state = host.states.swap_remove(index);
    // SAFETY: alive, freed once.
    let status = host.call(saving::NAMES.free, component, |c| unsafe {
        saving::free(c, &raw mut state)
    });
    assert!(status == Status::Ok && state.is_null());
}

/// Bytes that are no saved state.
fn strange(host: &mut Host, component: Component) {
    static OTHER: [u64; 64] = [0; 64];
    let own = host.instances.first().copied().unwrap_or(null_mut());
    let mut state = host
        .random
        .one(&[null_mut(), own, (&raw const OTHER).cast_mut().cast()]);
    let mut size = 0;
    // SAFETY of all: NULL, or readable memory that is no state.
    match host.random.below(3) {
        0 => host.call(saving::NAMES.set, component, |c| {
            // SAFETY: as said above.
            unsafe { saving::set(c, state) }
        }),
        1 => host.call(saving::NAMES.size, component, |c| {
            // SAFETY: as said above.
            unsafe { saving::size(c, state, &raw mut size) }
        }),
        _ => host.call(saving::NAMES.free, component, |c| {
            // SAFETY: as said above.
            unsafe { saving::free(c, &raw mut state) }
        }),
    };
}

/// Writes a state down and reads it again: as it was, damaged, or forged with a right checksum.
fn written(host: &mut Host, component: Component) {
    let original = host.bytes_of(component);
    let mut bytes = original.clone();
    let way = host.random.below(4);
    match way {
        0 => {}
        1 => {
            let at = host.random.below(bytes.len());
            bytes[at] ^= 1 << host.random.below(8);
        }
        2 => bytes.truncate(host.random.below(original.len())),
        _ => forge(host, &mut bytes),
    }
    let mut state = null_mut();
    let status = host.call(saving::NAMES.deserialize, component, |c| {
        // SAFETY: as many bytes as are there; the place is ours.
        unsafe { saving::deserialize(c, bytes.as_ptr().cast(), bytes.len(), &raw mut state) }
    });
    match way {
        0 => assert_eq!(status, Status::Ok),
        1 | 2 => assert_eq!(status, Status::Error, "damaged bytes are refused"),
        _ => {}
    }
    if way == 0 {
        assert!(
            host.bytes(component, state) == original,
            "read again, but not the same"
        );
    }
    if status != Status::Ok {
        assert!(state.is_null());
        return;
    }
    host.copied(component, state);
    if way == 3 {
        host.forged.insert(state);
    }
    if host.states.len() < MOST {
        host.states.push(state);
    } else {
        // SAFETY: alive, freed once.
        host.call(saving::NAMES.free, component, |c| unsafe {
            saving::free(c, &raw mut state)
        });
    }
}

/// Changes the payload and makes length and checksum right again.
fn forge(host: &mut Host, bytes: &mut Vec<u8>) {
    for _ in 0..=host.random.below(3) {
        let at = HEADER + host.random.below(bytes.len() - HEADER);
        match host.random.below(4) {
            0 => bytes[at] = host.random.bits() as u8,
            1 => bytes[at] ^= 1 << host.random.below(8),
            2 if bytes.len() > at + 8 => {
                let number = host.random.hostile().to_le_bytes();
                bytes[at..at + 8].copy_from_slice(&number);
            }
            _ => bytes.truncate(at.max(HEADER + 1)),
        }
    }
    let length = (bytes.len() - HEADER) as u64;
    let checksum = crc32fast::hash(&bytes[HEADER..]);
    bytes[HEADER - 12..HEADER - 4].copy_from_slice(&length.to_le_bytes());
    bytes[HEADER - 4..HEADER].copy_from_slice(&checksum.to_le_bytes());
}
