//! What threads share.

use std::sync::{Mutex, MutexGuard, PoisonError};

/// The content, whatever interrupted its last user: here, every change leaves it sound.
pub fn locked<T>(what: &Mutex<T>) -> MutexGuard<'_, T> {
    what.lock().unwrap_or_else(PoisonError::into_inner)
}
