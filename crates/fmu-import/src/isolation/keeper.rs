//! A process that keeps children, watches them and outlives whatever they do. It has a single thread.

use std::{fs::File, os::fd::OwnedFd, time::Duration};

use rustix::{
    event::{PollFd, PollFlags, Timespec, poll},
    io::Errno,
    process::{Pid, Signal, WaitId, WaitIdOptions, WaitOptions, WaitStatus, waitid, waitpid},
};

use super::{
    frame::Inbox,
    loss::{DONE, Loss, MUTE, State},
    offspring::{self, kill_group},
    words::Words,
};

/// A process that keeps children.
#[derive(Debug)]
pub struct Keeper {
    superior: OwnedFd,
    pub(super) words: Words,
    pub(super) tickets: u64,
}

impl Keeper {
    /// A keeper that ends its children when the other end of the pipe `superior` is closed.
    /// `seed` makes its frames unlike those of other keepers.
    pub fn new(superior: OwnedFd, words: Words, seed: u64) -> Self {
        Self { superior, words, tickets: seed }
    }

    /// Reads what has been printed so far, and repeats it where that is wanted.
    pub fn hear(&mut self) {
        self.words.hear();
    }

    /// The same when a child has ended: the last that it printed is in the pipe still.
    pub(super) fn hear_the_last(&mut self) {
        self.words.hear();
    }

    /// Does what may take long without a look at the superior, such as running initialisers of an FMU: if the superior goes
    /// meanwhile, this process ends at once.
    pub fn blindly<T>(&self, work: impl FnOnce() -> T) -> T {
        self.end_with_superior(true);
        if self.is_orphaned() {
            offspring::end_all();
            // SAFETY: never returns, runs no code of this process.
            unsafe { libc::_exit(0) }
        }
        let done = work();
        self.end_with_superior(false);
        done
    }

    /// Lets the system kill this process when the other end of the superior's pipe is closed. Nothing else comes through it
    /// before an order is done.
    fn end_with_superior(&self, wanted: bool) {
        #[cfg(target_os = "linux")]
        {
            const F_SETSIG: i32 = 10;
            let fd = std::os::fd::AsRawFd::as_raw_fd(&self.superior);
            // SAFETY: changes what this process does when its own descriptor becomes ready.
            unsafe {
                let flags = libc::fcntl(fd, libc::F_GETFL);
                libc::fcntl(fd, libc::F_SETOWN, std::process::id());
                libc::fcntl(fd, F_SETSIG, libc::SIGKILL);
                let flags = if wanted { flags | libc::O_ASYNC } else { flags & !libc::O_ASYNC };
                libc::fcntl(fd, libc::F_SETFL, flags);
            }
        }
        #[cfg(not(target_os = "linux"))]
        let _ = wanted;
    }

    /// Whether the superior has gone.
    pub(super) fn is_orphaned(&self) -> bool {
        let mut superior = [PollFd::new(&self.superior, PollFlags::empty())];
        poll(&mut superior, Some(&Timespec::default())).is_ok_and(|ready| ready > 0)
    }

    /// Waits a short time until there is something to read, or the end of it.
    pub(super) fn is_ready(&mut self, answers: &mut Inbox<File>) -> Result<bool, Loss> {
        let mut polled = [
            PollFd::new(answers.source(), PollFlags::IN),
            PollFd::new(&self.words, PollFlags::IN),
            // Its hang-up is told in any case.
            PollFd::new(&self.superior, PollFlags::empty()),
        ];
        if !poll(&mut polled, Some(&LOOK)).is_ok_and(|ready| ready > 0) {
            return Ok(false);
        }
        let [answers, words, superior] = polled.map(|polled| polled.revents());
        if !words.is_empty() {
            self.words.hear();
        }
        if superior.intersects(PollFlags::HUP | PollFlags::ERR | PollFlags::NVAL) {
            return Err(Loss::Orphaned);
        }
        Ok(!answers.is_empty())
    }
}

/// The child's side of a keeper: what it answers, and where it is told what to do.
pub(super) type Answers = File;
pub(super) type Orders = File;
/// How often a silent child is looked at.
const LOOK: Timespec = Timespec { tv_sec: 0, tv_nsec: 10_000_000 };
/// The longest time between two looks at a child that has nothing more to say.
const PAUSE: Timespec = Timespec { tv_sec: 0, tv_nsec: 1_000_000 };

/// The process of a child, by its number.
#[derive(Debug)]
pub(super) struct Process(pub u32);

impl Process {
    pub fn resident(&self) -> u64 {
        offspring::resident(self.0)
    }

    /// Looks at the child without reaping it, so that its number stays its own.
    pub fn state(&self) -> State {
        let options = WaitIdOptions::EXITED | WaitIdOptions::STOPPED | WaitIdOptions::NOHANG | WaitIdOptions::NOWAIT;
        let status = match waitid(WaitId::Pid(self.pid()), options) {
            Ok(Some(status)) => status,
            // Somebody else has reaped it.
            Err(Errno::CHILD) => return State::Ended(Loss::Mute),
            _ => return State::Running,
        };
        if status.stopped() || status.trapped() {
            return State::Stopped;
        }
        let loss = match status.exit_status() {
            Some(MUTE) => Some(Loss::Mute),
            Some(code) => Some(Loss::Exit(code)),
            None => status.terminating_signal().map(Loss::Signal),
        };
        loss.map_or(State::Running, State::Ended)
    }

    /// Waits a short time for the child's end. Where the system does not tell of it, the time is shorter.
    pub fn await_end(&self) {
        #[cfg(target_os = "linux")]
        if let Ok(process) = rustix::process::pidfd_open(self.pid(), rustix::process::PidfdFlags::empty()) {
            let _ = poll(&mut [PollFd::new(&process, PollFlags::IN)], Some(&PAUSE));
            return;
        }
        std::thread::sleep(Duration::from_micros(50));
    }

    /// Ends the child with its group at once, and reaps it. The loss that its status tells.
    pub fn finish(&mut self) -> Option<Loss> {
        kill_group(self.0);
        // SIGKILL ends the child, so the wait is short.
        let ended = waitpid(Some(self.pid()), WaitOptions::empty());
        // Whatever it has started and left to us.
        offspring::end_all();
        let (_, status) = ended.ok()??;
        unusual(status)
    }

    fn pid(&self) -> Pid {
        Pid::from_raw(self.0 as i32).expect("a process that was forked has a number")
    }
}

/// The loss that the status of an ended child tells. One that was ending by itself when it was killed ends as it
/// would have, so SIGKILL is our own.
fn unusual(status: WaitStatus) -> Option<Loss> {
    if let Some(signal) = status.terminating_signal() {
        return (signal != Signal::KILL.as_raw()).then_some(Loss::Signal(signal));
    }
    let code = status.exit_status()?;
    (![DONE, MUTE].contains(&code)).then_some(Loss::Exit(code))
}

/// The name of a signal that ends processes.
pub fn signal_name(signal: i32) -> String {
    macro_rules! name_among {
        ($($name:ident)*) => {
            match signal {
                $(libc::$name => stringify!($name).to_owned(),)*
                other => format!("signal {other}"),
            }
        };
    }
    name_among!(SIGSEGV SIGABRT SIGFPE SIGILL SIGBUS SIGKILL SIGTERM SIGTRAP SIGPIPE SIGALRM SIGSYS)
}
