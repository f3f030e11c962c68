//! Ctrl-C, SIGTERM and SIGHUP.

use std::{
    sync::{
        Once, OnceLock,
        atomic::{AtomicBool, Ordering},
        mpsc::sync_channel,
    },
    thread,
    time::Duration,
};

use crate::{
    process,
    scratch::{self, Scratch, ScratchError},
    system,
};

/// The exit code of an interrupted command.
pub const INTERRUPTED: u8 = 130;
/// How long an interrupted run may take to put things in order.
const PATIENCE: Duration = Duration::from_millis(600);
/// How long it may take after that to end what it has started, and to remove what it has unpacked.
const FAREWELL: Duration = Duration::from_millis(300);
/// The same for a command without a run: it has nothing to put in order. Either way it ends within a second.
const FAREWELL_AT_ONCE: Duration = Duration::from_millis(900);

/// Whether a run is to end.
static STOP: AtomicBool = AtomicBool::new(false);
/// Whether there is a run that looks at that, and can go on later.
static RUNS: AtomicBool = AtomicBool::new(false);

/// How an interrupted run goes on, in the words of the program behind "interrupted".
pub static WAY_ON: OnceLock<&'static str> = OnceLock::new();

/// Set by Ctrl-C: points under way are given up, no further ones are begun. The process ends within a second,
/// whatever its threads do; the journal is sound at any time.
pub fn flag() -> &'static AtomicBool {
    RUNS.store(true, Ordering::Relaxed);
    heed();
    &STOP
}

/// Lets signals end this process with all that it has started and all that it has unpacked. Where no run looks at the
/// [`flag`], they do so at once.
fn heed() {
    static HEEDED: Once = Once::new();
    HEEDED.call_once(|| {
        let handler = || {
            let again = STOP.swap(true, Ordering::Relaxed);
            if !RUNS.load(Ordering::Relaxed) {
                leave(FAREWELL_AT_ONCE);
            }
            if again {
                // The second Ctrl-C does not wait.
                leave(FAREWELL);
            }
            thread::spawn(|| {
                thread::sleep(PATIENCE);
                leave(FAREWELL);
            });
        };
        // Without a handler, Ctrl-C ends the process at once; the journal is sound all the same.
        system::without_hangup(|| {
            let _ = ctrlc::set_handler(handler);
        });
    });
}

/// A folder for what is needed while a command runs; a signal removes it, too.
///
/// # Errors
/// When the system says no.
pub fn scratch() -> Result<Scratch, ScratchError> {
    heed();
    Scratch::new()
}

/// Does not return while a signal is ending this process: what became of the processes that it ends is no finding.
pub fn give_way() {
    while STOP.load(Ordering::Relaxed) && !RUNS.load(Ordering::Relaxed) {
        thread::park();
    }
}

/// Ends this process, and all that it has started.
fn leave(farewell: Duration) {
    // Nobody can end a process that the kernel holds (a dead network disk). It holds us up no longer than this.
    let (done, wait) = sync_channel(1);
    thread::spawn(move || {
        process::abandon_all();
        scratch::remove_all();
        let _ = done.send(());
    });
    let _ = wait.recv_timeout(farewell);
    let way = WAY_ON.get().filter(|_| RUNS.load(Ordering::Relaxed)).copied().unwrap_or_default();
    crate::tell::line!("interrupted{way}");
    // An FMU in this process may hang in its own destructors.
    system::leave(INTERRUPTED.into())
}
