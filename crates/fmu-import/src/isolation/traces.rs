//! The traces that a simulation leaves in its process: threads and processes that still run, signals that are handled in another way.

use std::fs::{self, File};
use std::io;
use std::os::fd::{FromRawFd, IntoRawFd};
use std::os::unix::fs::MetadataExt;

use rustix::process::{WaitId, WaitIdOptions, waitid};

use super::birth::raised;

/// The signals of the standard and those for real time.
const SIGNALS: usize = 64;

/// The threads and signals of this process at some moment.
#[derive(Debug)]
pub struct Traces {
    /// The folder of the threads; none where the system shows none.
    threads: Option<File>,
    /// How many there are, and how many of them do not end at the moment.
    count: u64,
    running: usize,
    children: bool,
    signals: [Action; SIGNALS],
}

/// The function that handles a signal, and how.
type Action = (usize, i32);

impl Traces {
    /// Those at this moment.
    pub fn now() -> Self {
        // An FMU may close low descriptors that it did not open.
        let raised = |file: File| {
            let low = file.into_raw_fd();
            let high = raised(low);
            if high != low {
                // SAFETY: it is open, and nothing else in this process owns it.
                drop(unsafe { File::from_raw_fd(low) });
            }
            // SAFETY: as above.
            unsafe { File::from_raw_fd(high) }
        };
        let threads = File::open("/proc/self/task").ok().map(raised);
        let count = threads.as_ref().map_or(Ok(0), count);
        Self { count: count.unwrap_or(0), threads, running: running(), children: has_children(), signals: actions() }
    }

    /// Whether a thread runs now that did not run then, or a process that one of them has started.
    pub fn has_further_threads(&self) -> bool {
        if !self.children && has_children() {
            return true;
        }
        let Some(threads) = &self.threads else {
            return false;
        };
        // An FMU that took the descriptor away is not to be trusted either.
        count(threads).map_or(true, |count| count > self.count) && running() > self.running
    }

    /// Whether a signal is handled in another way than then.
    pub fn has_other_signals(&self) -> bool {
        actions() != self.signals
    }
}

/// How many threads there are: each is a link of the folder.
fn count(threads: &File) -> io::Result<u64> {
    threads.metadata().map(|folder| folder.nlink())
}

/// How many threads do not end: one that was joined is still there for a moment, and its flags say that it is ending (proc(5),
/// `stat`).
fn running() -> usize {
    const ENDING: u64 = 4;
    let runs = |thread: &fs::DirEntry| {
        let stat = fs::read_to_string(thread.path().join("stat")).ok()?;
        let (_, fields) = stat.rsplit_once(')')?;
        let flags: u64 = fields.split_ascii_whitespace().nth(6)?.parse().ok()?;
        (flags & ENDING == 0).then_some(())
    };
    let threads = fs::read_dir("/proc/self/task").into_iter().flatten();
    threads.flatten().filter_map(|thread| runs(&thread)).count()
}

/// Whether this process has started another one that it has not asked how it ended.
fn has_children() -> bool {
    let options = WaitIdOptions::EXITED | WaitIdOptions::NOHANG | WaitIdOptions::NOWAIT;
    waitid(WaitId::All, options).is_ok()
}

fn actions() -> [Action; SIGNALS] {
    let mut actions = [(0, 0); SIGNALS];
    for (action, signal) in actions.iter_mut().zip(1..) {
        // SAFETY: zeroes are a valid value of this plain struct, which the call fills where there is such a signal.
        unsafe {
            let mut now: libc::sigaction = std::mem::zeroed();
            libc::sigaction(signal, std::ptr::null(), &raw mut now);
            let flags = match now.sa_sigaction {
                // Without a function to call, most flags say nothing, and `signal` leaves some behind.
                libc::SIG_DFL | libc::SIG_IGN => now.sa_flags & libc::SA_NOCLDWAIT,
                _ => now.sa_flags,
            };
            *action = (now.sa_sigaction, flags);
        }
    }
    actions
}

#[cfg(test)]
mod tests {
    use super::*;

    /// One test, as threads and signals are those of the whole process; other tests start and end threads, but not as many
    /// as this one starts.
    #[test]
    fn what_is_left_is_seen() {
        let before = Traces::now();
        assert!(!before.has_other_signals());
        let end = std::sync::Barrier::new(201);
        std::thread::scope(|scope| {
            for _ in 0..200 {
                scope.spawn(|| end.wait());
            }
            let further = before.threads.is_none() || before.has_further_threads();
            end.wait();
            assert!(further);
        });
        // SAFETY: nothing sends this signal.
        unsafe { libc::signal(libc::SIGUSR2, libc::SIG_IGN) };
        assert!(before.has_other_signals());
        // SAFETY: as above.
        unsafe { libc::signal(libc::SIGUSR2, libc::SIG_DFL) };
        assert!(!before.has_other_signals());
    }
}
