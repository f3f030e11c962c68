//! How a process in which an FMU runs can be lost, and its limits.

use std::time::Duration;

use super::frame::Broken;

/// Why no answer comes from a child.
#[derive(Clone, Debug, PartialEq)]
pub enum Loss {
    /// A signal ended it; on Windows an exception, by its code.
    Signal(i32),
    /// It ended by itself with this exit code.
    Exit(i32),
    /// It stopped itself, and would have waited for ever.
    Stopped,
    /// It took longer than it may.
    Timeout,
    /// It took more memory than it may.
    Memory,
    /// It closed its pipe, or lost it.
    Mute,
    /// It sent something other than an answer.
    Garbled(Broken),
    /// The keeper's own superior has gone: nobody waits for the answer.
    Orphaned,
}

/// The state of a child.
pub enum State {
    Running,
    #[cfg_attr(windows, allow(dead_code))]
    Stopped,
    Ended(Loss),
}

/// Limits of a child until its next answer.
#[derive(Clone, Copy, Debug)]
pub struct Bounds {
    /// The longest time.
    pub time: Duration,
    /// The most memory that it may occupy, bytes.
    pub memory: u64,
}

/// How a child ended that had answered.
#[derive(Debug)]
pub struct Parting {
    /// The last thing that it said.
    pub words: Option<Vec<u8>>,
    /// Why it did not end as it should, as far as that is known.
    pub loss: Option<Loss>,
}

/// The exit code of a child that could not send its answer.
pub const MUTE: i32 = 121;
/// The exit code of a child whose work is done: unlike those with which an FMU may end its process.
pub const DONE: i32 = 122;
