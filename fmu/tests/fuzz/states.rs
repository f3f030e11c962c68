//! Saved states: kept, restored, written down, damaged and forged.

use std::ptr::null_mut;

use fmu_export::fmi3::types::{Component, FmuState, Status};

use crate::host::{Host, MOST, Named};

/// Bytes in front of the payload: mark, version, fingerprint, length, checksum.
const HEADER: usize = 8 + 2 + 16 + 8 + 4;

/// The functions for saved states, with their names in a version of the standard.
pub struct Functions {
    pub get: Named<unsafe extern "C" fn(Component, *mut FmuState) -> Status>,
    pub set: Named<unsafe extern "C" fn(Component, FmuState) -> Status>,
    pub free: Named<unsafe extern "C" fn(Component, *mut FmuState) -> Status>,
    pub size: Named<unsafe extern "C" fn(Component, FmuState, *mut usize) -> Status>,
    pub serialize: Named<unsafe extern "C" fn(Component, FmuState, *mut u8, usize) -> Status>,
    pub deserialize: Named<unsafe extern "C" fn(Component, *const u8, usize, *mut FmuState) -> Status>,
}

/// Does something with saved states.
pub fn act(host: &mut Host, component: Component) {
    match host.random.below(8) {
        0 | 1 => save(host, component),
        2 | 3 => restore(host, component),
        4 => free_any(host, component),
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
    let old = if host.states.len() < MOST { null_mut() } else { any(host) };
    let mut state = old;
    let status = get(host, component, &mut state);
    assert!(old.is_null() || state == old, "a state is used again");
    if status == Status::Ok {
        host.copied(component, state);
        if old.is_null() {
            host.states.push(state);
        }
    }
}

/// Asks for the state of an instance, in place of an earlier one or NULL.
fn get(host: &mut Host, component: Component, state: &mut FmuState) -> Status {
    let (name, function) = host.interface.states.get;
    // SAFETY: NULL, or a state that is alive; the place is ours.
    host.call(name, component, |c| unsafe { function(c, state) })
}

fn restore(host: &mut Host, component: Component) {
    let state = any(host);
    let status = set(host, component, state);
    if status == Status::Ok {
        host.copied(state, component);
    }
    if status == Status::Ok && host.random.once_in(8) {
        let saved = bytes(host, component, state);
        let same = saved == bytes_of(host, component);
        assert!(same, "restored, but not the same");
    }
}

fn set(host: &mut Host, component: Component, state: FmuState) -> Status {
    let (name, function) = host.interface.states.set;
    // SAFETY: NULL, a state that is alive, or readable memory.
    host.call(name, component, |c| unsafe { function(c, state) })
}

/// Frees one of the host's states.
fn free_any(host: &mut Host, component: Component) {
    if host.states.is_empty() || !host.instances.contains(&component) {
        return;
    }
    let index = host.random.below(host.states.len());
    let state = host.states.swap_remove(index);
    free(host, component, state);
}

/// Frees a state that nobody uses any more.
pub fn free(host: &mut Host, component: Component, mut state: FmuState) {
    let (name, function) = host.interface.states.free;
    // SAFETY: alive, freed once.
    let status = host.call(name, component, |c| unsafe { function(c, &raw mut state) });
    assert!(status == Status::Ok && state.is_null());
}

/// The bytes of an instance's state.
pub fn bytes_of(host: &mut Host, component: Component) -> Vec<u8> {
    let mut state = null_mut();
    get(host, component, &mut state);
    let bytes = bytes(host, component, state);
    free(host, component, state);
    bytes
}

/// The bytes of a saved state.
fn bytes(host: &mut Host, component: Component, state: FmuState) -> Vec<u8> {
    let ((name, function), mut n) = (host.interface.states.size, 0);
    // SAFETY: the instance and the state are alive.
    host.call(name, component, |c| unsafe { function(c, state, &raw mut n) });
    let ((name, function), mut bytes) = (host.interface.states.serialize, vec![0; n]);
    let into = bytes.as_mut_ptr();
    // SAFETY: there is room for the bytes.
    host.call(name, component, |c| unsafe { function(c, state, into, n) });
    bytes
}

/// Bytes that are no saved state.
fn strange(host: &mut Host, component: Component) {
    static OTHER: [u64; 64] = [0; 64];
    let instance = host.instances.first().copied().unwrap_or(null_mut());
    let mut state = host.random.one(&[null_mut(), instance, (&raw const OTHER).cast_mut().cast()]);
    let functions = &host.interface.states;
    let ((frees, free), (sizes, size), mut n) = (functions.free, functions.size, 0);
    // SAFETY of all: NULL, or readable memory that is no state.
    match host.random.below(3) {
        0 => set(host, component, state),
        1 => host.call(sizes, component, |c| {
            // SAFETY: as said above.
            unsafe { size(c, state, &raw mut n) }
        }),
        _ => host.call(frees, component, |c| {
            // SAFETY: as said above.
            unsafe { free(c, &raw mut state) }
        }),
    };
}

/// Writes a state down and reads it again: as it was, damaged, or forged with a right checksum.
fn written(host: &mut Host, component: Component) {
    let original = bytes_of(host, component);
    let mut copy = original.clone();
    let way = host.random.below(4);
    match way {
        0 => {}
        1 => {
            let at = host.random.below(copy.len());
            copy[at] ^= 1 << host.random.below(8);
        }
        2 => copy.truncate(host.random.below(original.len())),
        _ => forge(host, &mut copy),
    }
    let ((name, function), mut state) = (host.interface.states.deserialize, null_mut());
    let status = host.call(name, component, |c| {
        // SAFETY: as many bytes as are there; the place is ours.
        unsafe { function(c, copy.as_ptr(), copy.len(), &raw mut state) }
    });
    match way {
        0 => assert_eq!(status, Status::Ok),
        1 | 2 => assert_eq!(status, Status::Error, "damaged bytes are refused"),
        _ => {}
    }
    if way == 0 {
        let same = bytes(host, component, state) == original;
        assert!(same, "read again, but not the same");
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
        free(host, component, state);
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
