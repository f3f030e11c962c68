//! Receives the messages of an FMU.

use std::collections::VecDeque;
use std::ffi::{CStr, c_char, c_int, c_void};
use std::panic::catch_unwind;
use std::sync::{Mutex, PoisonError};

/// Messages kept; the oldest go first, so that a chatty FMU costs no memory.
const KEPT: usize = 32;

/// The last messages of one instance.
#[derive(Debug, Default)]
pub(crate) struct Log {
    messages: Mutex<VecDeque<(i32, String)>>,
}

impl Log {
    fn push(&self, status: i32, message: String) {
        let mut messages = self.messages.lock().unwrap_or_else(PoisonError::into_inner);
        if messages.len() == KEPT {
            messages.pop_front();
        }
        messages.push_back((status, message));
    }

    /// Forgets all messages.
    pub(crate) fn clear(&self) {
        let mut messages = self.messages.lock().unwrap_or_else(PoisonError::into_inner);
        messages.clear();
    }

    /// The last message of an error, or else the last message at all.
    pub(crate) fn last(&self) -> Option<String> {
        let messages = self.messages.lock().unwrap_or_else(PoisonError::into_inner);
        let error = messages.iter().rev().find(|(status, _)| *status >= 3);
        error
            .or_else(|| messages.back())
            .map(|(_, message)| message.clone())
    }
}

unsafe extern "C" {
    /// The C-variadic callback of `logger.c`; only its address is used here.
    pub(crate) fn fmu_import_logger();
}

/// Takes a formatted message from `logger.c`.
#[unsafe(no_mangle)]
extern "C" fn fmu_import_log(
    environment: *const c_void,
    _instance: *const c_char,
    status: c_int,
    category: *const c_char,
    message: *const c_char,
) {
    if environment.is_null() || message.is_null() {
        return;
    }
    // A panic must not cross the C frames of the FMU.
    let _ = catch_unwind(|| {
        // SAFETY: the environment is the `Log` that the instance passed to `fmi2Instantiate`; it
        // is shared and lives as long as the component.
        let log = unsafe { &*environment.cast::<Log>() };
        // SAFETY: `logger.c` passes its own zero-terminated buffer.
        let message = unsafe { CStr::from_ptr(message) }.to_string_lossy();
        // Some FMUs pass every message as "OK"; then the category tells errors apart.
        let severe = !category.is_null() && {
            // SAFETY: FMI 2.0 passes the category as a zero-terminated string.
            let category = unsafe { CStr::from_ptr(category) }.to_string_lossy();
            category.contains("Error") || category.contains("Fatal")
        };
        let status = if severe { status.max(3) } else { status };
        log.push(
            status,
            message.split_whitespace().collect::<Vec<_>>().join(" "),
        );
    });
}
