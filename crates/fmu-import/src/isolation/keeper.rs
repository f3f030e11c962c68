//! A process that keeps children, watches them and outlives whatever they do. It has a single thread.

use std::fs::File;
use std::io;
use std::os::fd::{AsRawFd, OwnedFd, RawFd};
use std::time::Duration;

use super::frame::Inbox;
use super::loss::{DONE, Loss, MUTE, State};
use super::offspring::{self, kill_group};
use super::words::Words;

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
        Self {
            superior,
            words,
            tickets: seed,
        }
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
            let fd = self.superior.as_raw_fd();
            // SAFETY: changes what this process does when its own descriptor becomes ready.
            unsafe {
                let flags = libc::fcntl(fd, libc::F_GETFL);
                libc::fcntl(fd, libc::F_SETOWN, std::process::id());
                libc::fcntl(fd, F_SETSIG, libc::SIGKILL);
                let flags = if wanted {
                    flags | libc::O_ASYNC
                } else {
                    flags & !libc::O_ASYNC
                };
                libc::fcntl(fd, libc::F_SETFL, flags);
            }
        }
        #[cfg(not(target_os = "linux"))]
        let _ = wanted;
    }

    /// Whether the superior has gone.
    pub(super) fn is_orphaned(&self) -> bool {
        let mut superior = libc::pollfd {
            fd: self.superior.as_raw_fd(),
            events: 0,
            revents: 0,
        };
        // SAFETY: one valid descriptor, which stays open through the call.
        unsafe { libc::poll(&raw mut superior, 1, 0) > 0 }
    }

    /// Waits a short time until there is something to read, or the end of it.
    pub(super) fn is_ready(&mut self, answers: &mut Inbox<File>) -> Result<bool, Loss> {
        let look = |fd: RawFd, events| libc::pollfd {
            fd,
            events,
            revents: 0,
        };
        let mut polled = [
            look(answers.source().as_raw_fd(), libc::POLLIN),
            look(self.words.as_raw_fd(), libc::POLLIN),
            // Its hang-up is told in any case.
            look(self.superior.as_raw_fd(), 0),
        ];
        // SAFETY: three valid descriptors, which stay open through the call.
        let count = unsafe { libc::poll(polled.as_mut_ptr(), 3, LOOK.as_millis() as i32) };
        if count <= 0 {
            return Ok(false);
        }
        if polled[1].revents != 0 {
            self.words.hear();
        }
        if polled[2].revents & (libc::POLLHUP | libc::POLLERR | libc::POLLNVAL) != 0 {
            return Err(Loss::Orphaned);
        }
        Ok(polled[0].revents != 0)
    }
}

/// The child's side of a keeper: what it answers, and where it is told what to do.
pub(super) type Answers = File;
pub(super) type Orders = File;
/// How often a silent child is looked at.
const LOOK: Duration = Duration::from_millis(10);
/// Between two looks at a child that has nothing more to say.
pub(super) const PAUSE: Duration = Duration::from_micros(50);

/// The process of a child, by its number.
#[derive(Debug)]
pub(super) struct Process(pub(super) u32);

impl Process {
    pub(super) fn resident(&self) -> u64 {
        offspring::resident(self.0)
    }

    /// Looks at the child without reaping it, so that its number stays its own.
    pub(super) fn state(&self) -> State {
        // SAFETY: zeroes are a valid value of this plain struct.
        let mut info: libc::siginfo_t = unsafe { std::mem::zeroed() };
        let flags = libc::WEXITED | libc::WSTOPPED | libc::WNOHANG | libc::WNOWAIT;
        // SAFETY: `info` is valid for writing.
        let result = unsafe { libc::waitid(libc::P_PID, self.0 as _, &raw mut info, flags) };
        // SAFETY: `waitid` fills these fields, or leaves them at zero where nothing has happened.
        let (pid, status) = unsafe { (info.si_pid(), info.si_status()) };
        if result != 0 {
            // Somebody else has reaped it.
            let gone = io::Error::last_os_error().raw_os_error() == Some(libc::ECHILD);
            return if gone {
                State::Ended(Loss::Mute)
            } else {
                State::Running
            };
        }
        if pid == 0 {
            return State::Running;
        }
        match info.si_code {
            libc::CLD_STOPPED | libc::CLD_TRAPPED => State::Stopped,
            libc::CLD_EXITED if status == MUTE => State::Ended(Loss::Mute),
            libc::CLD_EXITED => State::Ended(Loss::Exit(status)),
            libc::CLD_KILLED | libc::CLD_DUMPED => State::Ended(Loss::Signal(status)),
            _ => State::Running,
        }
    }

    /// Ends the child with its group at once, and reaps it. The loss that its status tells.
    pub(super) fn finish(&mut self) -> Option<Loss> {
        kill_group(self.0);
        let mut status = 0;
        // SAFETY: `status` is valid for writing; SIGKILL ends the child, so the wait is short.
        let reaped = unsafe { libc::waitpid(self.0 as libc::pid_t, &raw mut status, 0) };
        // Whatever it has started and left to us.
        offspring::end_all();
        unusual(status).filter(|_| reaped as u32 == self.0)
    }
}

/// The loss that the status of an ended child tells. One that was ending by itself when it was killed ends as it
/// would have, so SIGKILL is our own.
fn unusual(status: i32) -> Option<Loss> {
    if libc::WIFSIGNALED(status) {
        let signal = libc::WTERMSIG(status);
        return (signal != libc::SIGKILL).then_some(Loss::Signal(signal));
    }
    let code = libc::WEXITSTATUS(status);
    (![DONE, MUTE].contains(&code)).then_some(Loss::Exit(code))
}

/// The name of a signal that ends processes.
pub fn signal_name(signal: i32) -> String {
    let name = match signal {
        libc::SIGSEGV => "SIGSEGV",
        libc::SIGABRT => "SIGABRT",
        libc::SIGFPE => "SIGFPE",
        libc::SIGILL => "SIGILL",
        libc::SIGBUS => "SIGBUS",
        libc::SIGKILL => "SIGKILL",
        libc::SIGTERM => "SIGTERM",
        libc::SIGTRAP => "SIGTRAP",
        libc::SIGPIPE => "SIGPIPE",
        libc::SIGALRM => "SIGALRM",
        libc::SIGSYS => "SIGSYS",
        other => return format!("signal {other}"),
    };
    name.to_owned()
}
