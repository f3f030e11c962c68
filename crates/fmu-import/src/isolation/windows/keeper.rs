//! A process that keeps children, watches them and outlives whatever they do.
//!
//! A child lies in a job, so that it ends with all that it has started; the keeper's own job ends it when the keeper is
//! gone.

use std::{fs::File, process::ChildStdin, time::Duration};

use super::{
    job::ControlGroup,
    pipe::Arrivals,
    process::{self, loss},
    words::Words,
};
use crate::isolation::{
    frame::Inbox,
    loss::{DONE, Loss, State},
};

/// A process that keeps children.
#[derive(Debug)]
pub struct Keeper {
    pub(in crate::isolation) words: Words,
    pub(super) tickets: u64,
}

impl Keeper {
    /// A keeper; `seed` makes its frames unlike those of other keepers. With `echo`, what children print is repeated
    /// there.
    pub fn new(echo: Option<File>, seed: u64) -> Self {
        process::end_without_words();
        Self { words: Words::new(echo), tickets: seed }
    }

    /// Does what may take long without a look at the superior: a job object ends this process with that.
    pub fn blindly<T>(&self, work: impl FnOnce() -> T) -> T {
        work()
    }

    /// Repeats what has been printed so far where that is wanted: here a thread has done so already.
    pub fn hear(&mut self) {}

    /// Waits for the last words of a child that has ended.
    pub(in crate::isolation) fn hear_the_last(&mut self) {
        self.words.settle();
    }

    /// Whether the superior has gone: a job object ends this process with that.
    pub(in crate::isolation) fn is_orphaned(&self) -> bool {
        false
    }

    /// Waits a short time until there is something to read, or the end of it.
    pub(in crate::isolation) fn is_ready(&mut self, answers: &mut Inbox<Arrivals>) -> Result<bool, Loss> {
        Ok(answers.source_mut().wait(LOOK))
    }
}

/// The child's side of a keeper: what it answers, and where it is told what to do.
pub(in crate::isolation) type Answers = Arrivals;
pub(in crate::isolation) type Orders = ChildStdin;
/// How often a silent child is looked at.
const LOOK: Duration = Duration::from_millis(10);

/// The process of a child, and the job in which it lies.
#[derive(Debug)]
pub(in crate::isolation) struct Process {
    pub process: std::process::Child,
    pub group: Option<ControlGroup>,
}

impl Process {
    pub fn resident(&self) -> u64 {
        process::resident(self.process.id())
    }

    pub fn state(&mut self) -> State {
        match self.process.try_wait() {
            Ok(Some(status)) => State::Ended(loss(status)),
            _ => State::Running,
        }
    }

    /// Waits a short time for the child's end.
    pub fn await_end(&self) {
        std::thread::sleep(Duration::from_millis(1));
    }

    /// Ends the child with its job at once. The loss that its status tells.
    pub fn finish(&mut self) -> Option<Loss> {
        match &self.group {
            Some(group) => group.end(),
            None => drop(self.process.kill()),
        }
        let status = self.process.wait().ok()?;
        let usual = status.code() == Some(DONE);
        Some(loss(status)).filter(|loss| !usual && *loss != Loss::Mute)
    }
}

/// Ends this process: its work is done.
pub fn leave() -> ! {
    // SAFETY: writes what the FMU has printed so far, of all streams.
    unsafe { libc::fflush(std::ptr::null_mut()) };
    process::end(DONE)
}

/// The name of an exception that ends processes.
pub fn signal_name(code: i32) -> String {
    let code = code.cast_unsigned();
    let name = match code {
        0xc000_0005 => "access violation",
        0xc000_0006 => "page error",
        0xc000_001d => "illegal instruction",
        0xc000_0025 => "exception that cannot be continued",
        0xc000_008c => "array bounds exceeded",
        0xc000_008e => "floating-point division by zero",
        0xc000_0094 => "integer division by zero",
        0xc000_00fd => "stack overflow",
        0xc000_013a => "Ctrl-C",
        0xc000_0374 => "heap corruption",
        0xc000_0409 => "abort",
        _ => "exception",
    };
    format!("{name} (0x{code:08X})")
}
