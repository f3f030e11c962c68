//! A number in memory that a process shares with its children.

use std::io;
use std::ptr::NonNull;
use std::sync::atomic::{AtomicU64, Ordering};

/// A number that this process and its children see. An FMU may overwrite it: nothing but a guess may rest on it.
#[derive(Debug)]
pub(super) struct Shared(NonNull<AtomicU64>);

impl Shared {
    pub(super) fn new() -> io::Result<Self> {
        let size = size_of::<AtomicU64>();
        let access = libc::PROT_READ | libc::PROT_WRITE;
        let kind = libc::MAP_SHARED | libc::MAP_ANONYMOUS;
        // SAFETY: asks for fresh memory; no existing mapping is touched.
        let place = unsafe { libc::mmap(std::ptr::null_mut(), size, access, kind, -1, 0) };
        if place == libc::MAP_FAILED {
            return Err(io::Error::last_os_error());
        }
        let place = NonNull::new(place.cast()).ok_or_else(io::Error::last_os_error)?;
        // It lives as long as this process.
        Ok(Self(place))
    }

    pub(super) fn get(&self) -> u64 {
        // SAFETY: the mapping is page-aligned, holds zeroes at first, and is never unmapped.
        unsafe { self.0.as_ref() }.load(Ordering::Relaxed)
    }

    pub(super) fn set(&self, value: u64) {
        // SAFETY: as above.
        unsafe { self.0.as_ref() }.store(value, Ordering::Relaxed);
    }
}
