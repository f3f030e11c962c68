//! A process that forks children, watches them and outlives whatever they do.
//!
//! The keeper has a single thread and asks nothing of its children: each is looked at now and then, so that one
//! that is silent because it has stopped, has ended with its pipe held open by others, or has swollen is noticed
//! long before its deadline.

use std::fs::File;
use std::io;
use std::os::fd::{AsRawFd, OwnedFd, RawFd};
use std::time::{Duration, Instant};

pub use super::birth::Place;
use super::birth::be_child;
use super::frame::{self, Inbox};
pub use super::loss::{Bounds, Loss, Parting};
use super::loss::{DONE, MUTE};
use super::offspring::{self, kill_group};
use super::system::{own_pid, pipe};
use super::words::Words;

/// How often a silent child is looked at.
const LOOK: Duration = Duration::from_millis(10);
/// How long a child may take to end after it has closed its pipe.
const PATIENCE: Duration = Duration::from_secs(1);

/// A process that keeps children.
#[derive(Debug)]
pub struct Keeper {
    superior: OwnedFd,
    words: Words,
    tickets: u64,
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

    /// Forks a child that does `work`, and ends without running any destructor when that returns.
    ///
    /// # Errors
    /// When the system has no room for a further process or descriptor.
    ///
    /// # Safety
    /// This process has a single thread: in a forked child of several, locks that other threads hold stay
    /// locked for ever.
    pub unsafe fn fork(&mut self, work: &mut dyn FnMut(Place)) -> io::Result<Child> {
        // Odd, so that every ticket of the 2^64 has its turn.
        self.tickets = self.tickets.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let ticket = self.tickets;
        let (answers, answers_end) = pipe()?;
        let (orders_end, orders) = pipe()?;
        self.words.clear();
        let parent = own_pid();
        // SAFETY: the caller vouches for a single thread.
        match unsafe { libc::fork() } {
            -1 => Err(io::Error::last_os_error()),
            0 => be_child(parent, orders_end, answers_end, ticket, work),
            pid => {
                // Parent and child both do so, whoever comes first.
                // SAFETY: changes the child's group only.
                unsafe { libc::setpgid(pid, pid) };
                Ok(Child {
                    pid,
                    answers: Inbox::new(answers.into(), ticket),
                    orders: orders.into(),
                    ticket,
                    gone: false,
                })
            }
        }
    }

    /// The last line that children have printed since the last [`fork`](Self::fork) or [`forget`](Self::forget).
    pub fn last_line(&mut self) -> String {
        self.words.last_line()
    }

    /// All that is kept of what they have printed since then.
    pub fn text(&mut self) -> String {
        self.words.text()
    }

    /// Reads what has been printed so far, and repeats it where that is wanted.
    pub fn hear(&mut self) {
        self.words.hear();
    }

    /// Forgets what has been printed so far.
    pub fn forget(&mut self) {
        self.words.clear();
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
                libc::fcntl(fd, libc::F_SETOWN, own_pid());
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
    fn is_orphaned(&self) -> bool {
        let mut superior = libc::pollfd {
            fd: self.superior.as_raw_fd(),
            events: 0,
            revents: 0,
        };
        // SAFETY: one valid descriptor, which stays open through the call.
        unsafe { libc::poll(&raw mut superior, 1, 0) > 0 }
    }
}

/// A forked child at work.
#[derive(Debug)]
pub struct Child {
    pid: libc::pid_t,
    answers: Inbox<File>,
    orders: File,
    ticket: u64,
    /// Whether it has been reaped.
    gone: bool,
}

/// The state of a child.
enum State {
    Running,
    Stopped,
    Ended(Loss),
}

impl Child {
    /// The memory that it occupies, bytes; 0 where that is not known.
    pub fn resident(&self) -> u64 {
        offspring::resident(self.pid)
    }

    /// Sends it a message, which it must be waiting for: this blocks while it does not read.
    ///
    /// # Errors
    /// When it does not listen any more.
    pub fn send(&mut self, payload: &[u8]) -> io::Result<()> {
        frame::write(&mut self.orders, self.ticket, payload)
    }

    /// Waits for its next answer.
    ///
    /// # Errors
    /// When none comes; then only [`end`](Self::end) is left.
    pub fn answer(&mut self, keeper: &mut Keeper, bounds: Bounds) -> Result<Vec<u8>, Loss> {
        let begun = Instant::now();
        loop {
            match self.answers.arrived() {
                Ok(Some(payload)) => return Ok(payload),
                Ok(None) => {}
                Err(broken) => return Err(Loss::Garbled(broken)),
            }
            if self.is_ready(keeper)? {
                match self.answers.read() {
                    Ok(true) => continue,
                    // Nobody can write any more; how the child ends says why.
                    Ok(false) => return Err(self.ending(keeper)),
                    Err(_) => return Err(Loss::Mute),
                }
            }
            match self.state() {
                State::Running => {}
                // It may have answered just before.
                _ if self.is_ready(keeper)? => continue,
                State::Stopped => return Err(Loss::Stopped),
                State::Ended(loss) => return Err(loss),
            }
            if begun.elapsed() > bounds.time {
                return Err(Loss::Timeout);
            }
            if self.resident() > bounds.memory {
                return Err(Loss::Memory);
            }
        }
    }

    /// Waits a short time until there is something to read, or the end of it.
    fn is_ready(&mut self, keeper: &mut Keeper) -> Result<bool, Loss> {
        let look = |fd: RawFd, events| libc::pollfd {
            fd,
            events,
            revents: 0,
        };
        let mut polled = [
            look(self.answers.source().as_raw_fd(), libc::POLLIN),
            look(keeper.words.as_raw_fd(), libc::POLLIN),
            // Its hang-up is told in any case.
            look(keeper.superior.as_raw_fd(), 0),
        ];
        // SAFETY: three valid descriptors, which stay open through the call.
        let count = unsafe { libc::poll(polled.as_mut_ptr(), 3, LOOK.as_millis() as i32) };
        if count <= 0 {
            return Ok(false);
        }
        if polled[1].revents != 0 {
            keeper.words.hear();
        }
        if polled[2].revents & (libc::POLLHUP | libc::POLLERR | libc::POLLNVAL) != 0 {
            return Err(Loss::Orphaned);
        }
        Ok(polled[0].revents != 0)
    }

    /// Looks at the child without reaping it, so that its number stays its own.
    fn state(&self) -> State {
        // SAFETY: zeroes are a valid value of this plain struct.
        let mut info: libc::siginfo_t = unsafe { std::mem::zeroed() };
        let flags = libc::WEXITED | libc::WSTOPPED | libc::WNOHANG | libc::WNOWAIT;
        // SAFETY: `info` is valid for writing.
        let result = unsafe { libc::waitid(libc::P_PID, self.pid as _, &raw mut info, flags) };
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

    /// How a child ends whose pipe is closed. One that only closed it must not hold us up.
    fn ending(&mut self, keeper: &mut Keeper) -> Loss {
        let patience = Instant::now() + PATIENCE;
        while Instant::now() < patience {
            match self.state() {
                State::Ended(loss) => return loss,
                State::Stopped => return Loss::Stopped,
                State::Running if keeper.is_orphaned() => return Loss::Orphaned,
                State::Running => {}
            }
            keeper.words.hear();
            std::thread::sleep(Duration::from_micros(50));
        }
        Loss::Mute
    }

    /// Lets a child that has answered end by itself, but not longer than `grace`; then ends it. It closes its pipe before
    /// it writes what the FMU has printed or put into files, so the closed pipe is not its end.
    pub fn part(mut self, keeper: &mut Keeper, grace: Duration) -> Parting {
        let until = Instant::now() + grace;
        let mut open = true;
        let mut loss = Some(Loss::Timeout);
        while Instant::now() < until {
            let arrived = if open {
                self.is_ready(keeper)
            } else if keeper.is_orphaned() {
                Err(Loss::Orphaned)
            } else {
                keeper.words.hear();
                std::thread::sleep(Duration::from_micros(50));
                Ok(false)
            };
            match arrived {
                Ok(true) => {
                    open = matches!(self.answers.read(), Ok(true));
                    continue;
                }
                Ok(false) => match self.state() {
                    State::Running => continue,
                    State::Stopped => loss = Some(Loss::Stopped),
                    State::Ended(_) => loss = None,
                },
                Err(_) => loss = None,
            }
            break;
        }
        let mut words = None;
        while let Ok(Some(payload)) = self.answers.arrived() {
            words = Some(payload);
        }
        let status = self.finish();
        // The last that it printed is in the pipe still.
        keeper.words.hear();
        Parting {
            words,
            loss: loss.or_else(|| status.and_then(unusual)),
        }
    }

    /// Ends the child with its group at once, and reaps it.
    pub fn end(mut self) {
        self.finish();
    }

    /// The status with which it ended.
    fn finish(&mut self) -> Option<i32> {
        if self.gone {
            return None;
        }
        kill_group(self.pid);
        let mut status = 0;
        // SAFETY: `status` is valid for writing; SIGKILL ends the child, so the wait is short.
        let reaped = unsafe { libc::waitpid(self.pid, &raw mut status, 0) };
        self.gone = true;
        // Whatever it has started and left to us.
        offspring::end_all();
        (reaped == self.pid).then_some(status)
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

impl Drop for Child {
    fn drop(&mut self) {
        self.finish();
    }
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
