//! Ctrl-C.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, OnceLock};

/// The exit code of an interrupted command.
pub const INTERRUPTED: u8 = 130;

/// Set by Ctrl-C: points that have begun are finished, no further ones are begun.
pub fn flag() -> &'static AtomicBool {
    static STOP: OnceLock<Arc<AtomicBool>> = OnceLock::new();
    STOP.get_or_init(|| {
        let stop = Arc::new(AtomicBool::new(false));
        let handler = Arc::clone(&stop);
        // Without a handler, Ctrl-C ends the process at once; the journal is sound all the same.
        let _ = ctrlc::set_handler(move || {
            if handler.swap(true, Ordering::Relaxed) {
                // The second Ctrl-C does not wait.
                std::process::exit(INTERRUPTED.into());
            }
        });
        stop
    })
}
