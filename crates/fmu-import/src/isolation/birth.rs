//! Forks a child, and the child's own side: its channel, its descriptors, its end.

use std::{
    fs::File,
    io,
    os::fd::{AsRawFd, OwnedFd, RawFd},
};

use rustix::{
    io::fcntl_dupfd_cloexec,
    process::{Pid, getppid, setpgid},
};

use super::{
    child::Child,
    frame::{self, Inbox},
    keeper::{Keeper, Process},
    loss::{DONE, MUTE},
    system::{pipe, usual_signals},
};

impl Keeper {
    /// Forks a child that does `work`, and ends without running any destructor when that returns.
    ///
    /// # Errors
    /// When the system has no room for a further process or descriptor.
    ///
    /// # Safety
    /// This process has a single thread: in a forked child of several, locks that other threads hold stay
    /// locked for ever.
    pub unsafe fn fork(&mut self, work: &mut dyn FnMut(ChildEnd)) -> io::Result<Child> {
        // Odd, so that every ticket of the 2^64 has its turn.
        self.tickets = self.tickets.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let ticket = self.tickets;
        let (answers, answers_end) = pipe()?;
        let (orders_end, orders) = pipe()?;
        // What was heard so far is of an earlier child.
        self.words.clear();
        let parent = std::process::id();
        // SAFETY: the caller vouches for a single thread.
        match unsafe { libc::fork() } {
            -1 => Err(io::Error::last_os_error()),
            0 => be_child(parent, orders_end, answers_end, ticket, work),
            pid => {
                // Parent and child both do so, whoever comes first.
                let _ = setpgid(Pid::from_raw(pid), Pid::from_raw(pid));
                Ok(Child::new(Process(pid as u32), answers.into(), orders.into(), ticket))
            }
        }
    }
}

/// The exit code of a process for which nobody waits: no child, or one without a parent.
const STRAY: i32 = 0;

/// A child's own end of the pipes to its keeper.
#[derive(Debug)]
pub struct ChildEnd {
    process: u32,
    ticket: u64,
    orders: Inbox<File>,
    answers: File,
}

impl ChildEnd {
    /// Sends an answer. A process that the FMU has forked and let return ends here instead: only the child
    /// itself answers. So does a child that cannot send.
    pub fn send(&mut self, payload: &[u8]) {
        if std::process::id() != self.process {
            end(STRAY);
        }
        if frame::write(&self.answers, self.ticket, payload).is_err() {
            end(MUTE);
        }
    }

    /// Waits for the keeper's next message; `None` when none will come.
    pub fn receive(&mut self) -> Option<Vec<u8>> {
        let message = self.orders.wait().ok().flatten();
        if std::process::id() != self.process {
            end(STRAY);
        }
        message
    }
}

/// Ends this process at once, without running the FMU's destructors.
fn end(code: i32) -> ! {
    // SAFETY: never returns, runs no code of this process.
    unsafe { libc::_exit(code) }
}

/// The child's side: a group of its own, no descriptor but its own, the work, the end.
fn be_child(parent: u32, orders: OwnedFd, answers: OwnedFd, ticket: u64, work: &mut dyn FnMut(ChildEnd)) -> ! {
    let _ = setpgid(None, None);
    #[cfg(target_os = "linux")]
    let _ = rustix::process::set_parent_process_death_signal(Some(rustix::process::Signal::KILL));
    // The parent may have ended before.
    if getppid().map(Pid::as_raw_pid) != Some(parent as i32) {
        end(STRAY);
    }
    usual_signals();
    let (orders, answers) = hidden(orders, answers);
    let channel = ChildEnd { process: std::process::id(), ticket, orders: Inbox::new(orders, ticket), answers };
    // A panic must not unwind into the parent's code, which this process has a copy of.
    let done = std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| work(channel)));
    if done.is_err() {
        // SAFETY: ends this process.
        unsafe { libc::abort() }
    }
    // SAFETY: writes what the FMU has printed so far, of all streams.
    unsafe { libc::fflush(std::ptr::null_mut()) };
    end(DONE)
}

/// Closes every descriptor above standard error except these two, then moves these two to high numbers: FMUs that use or close
/// descriptors they never opened rarely hit those. First close, then move: the cost of `close_range` grows with the highest open
/// number.
fn hidden(orders: OwnedFd, answers: OwnedFd) -> (File, File) {
    const FIRST: RawFd = 3;
    let [one, other] = [orders.as_raw_fd(), answers.as_raw_fd()];
    let (low, high) = (one.min(other), one.max(other));
    close_between(FIRST, low - 1);
    close_between((low + 1).max(FIRST), high - 1);
    close_between((high + 1).max(FIRST), RawFd::MAX);
    (raised(orders), raised(answers))
}

/// The same file under a high number, where the system has one; programs that the FMU starts do not get it.
fn raised(fd: OwnedFd) -> File {
    const HIGH: [RawFd; 2] = [1016, 248];
    HIGH.into_iter().find_map(|least| fcntl_dupfd_cloexec(&fd, least).ok()).unwrap_or(fd).into()
}

/// Closes the descriptors of a range; where the system has no call for that, those up to 4096 alone.
fn close_between(first: RawFd, last: RawFd) {
    if first > last {
        return;
    }
    // SAFETY: nothing in this child uses any of them again.
    unsafe {
        #[cfg(target_os = "linux")]
        if libc::syscall(libc::SYS_close_range, first as u32, last as u32, 0) == 0 {
            return;
        }
        for other in first..=last.min(libc::sysconf(libc::_SC_OPEN_MAX).clamp(64, 4096) as RawFd) {
            libc::close(other);
        }
    }
}
