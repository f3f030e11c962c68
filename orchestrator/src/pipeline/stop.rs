//! Ctrl-C, and SIGTERM.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::sync_channel;
use std::sync::{Arc, OnceLock};
use std::thread;
use std::time::Duration;

use crate::engine::process;

/// The exit code of an interrupted command.
pub const INTERRUPTED: u8 = 130;
/// How long an interrupted command may take to put things in order.
const PATIENCE: Duration = Duration::from_millis(600);
/// How long it may take to end what it has started.
const FAREWELL: Duration = Duration::from_millis(150);

/// Set by Ctrl-C: points under way are given up, no further ones are begun. The process ends within a second,
/// whatever its threads do; the journal is sound at any time.
pub fn flag() -> &'static AtomicBool {
    static STOP: OnceLock<Arc<AtomicBool>> = OnceLock::new();
    STOP.get_or_init(|| {
        let stop = Arc::new(AtomicBool::new(false));
        let handler = Arc::clone(&stop);
        // Without a handler, Ctrl-C ends the process at once; the journal is sound all the same.
        let _ = ctrlc::set_handler(move || {
            if handler.swap(true, Ordering::Relaxed) {
                // The second Ctrl-C does not wait.
                leave();
            }
            thread::spawn(|| {
                thread::sleep(PATIENCE);
                leave();
            });
        });
        stop
    })
}

/// Ends this process at once, and all that it has started.
fn leave() {
    // Nobody can end a process that the kernel holds (a dead network disk). It must not hold us up.
    let (done, wait) = sync_channel(1);
    thread::spawn(move || {
        process::abandon_all();
        let _ = done.send(());
    });
    let _ = wait.recv_timeout(FAREWELL);
    eprintln!("interrupted; --resume goes on");
    // SAFETY: never returns, runs no code of this process: an FMU in it may hang in its own destructors.
    unsafe { libc::_exit(INTERRUPTED.into()) }
}
