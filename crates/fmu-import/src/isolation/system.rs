//! Calls of the operating system that keepers and their children share.

use std::{io, os::fd::OwnedFd};

/// Signals that a keeper ignores, and those whose handlers are Rust's.
const CHANGED: [i32; 12] = [
    libc::SIGTERM,
    libc::SIGINT,
    libc::SIGHUP,
    libc::SIGQUIT,
    libc::SIGALRM,
    libc::SIGUSR1,
    libc::SIGUSR2,
    libc::SIGVTALRM,
    libc::SIGPROF,
    libc::SIGXFSZ,
    libc::SIGSEGV,
    libc::SIGBUS,
];

/// Lets this process survive the signals that its children may send it.
pub fn ignore_signals() {
    for signal in CHANGED.into_iter().filter(|signal| ![libc::SIGSEGV, libc::SIGBUS].contains(signal)) {
        // SAFETY: these signals then have no effect; no handler is involved.
        unsafe { libc::signal(signal, libc::SIG_IGN) };
    }
}

/// The FMU finds the signals as in any new process; writing to a closed pipe is an error there, and no signal,
/// as in most hosts.
pub fn usual_signals() {
    // SAFETY: sets default actions and an empty mask in this process.
    unsafe {
        for signal in CHANGED {
            libc::signal(signal, libc::SIG_DFL);
        }
        let mut none: libc::sigset_t = std::mem::zeroed();
        libc::sigemptyset(&raw mut none);
        libc::sigprocmask(libc::SIG_SETMASK, &raw const none, std::ptr::null_mut());
    }
}

/// A pipe: the end to read from, the end to write to.
pub fn pipe() -> io::Result<(OwnedFd, OwnedFd)> {
    let (reader, writer) = io::pipe()?;
    Ok((reader.into(), writer.into()))
}
