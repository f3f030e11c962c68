//! Start and end of a forked child.

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
    pub unsafe fn fork(&mut self, work: &mut dyn FnMut(Place)) -> io::Result<Child> {
        // Odd, so that every ticket of the 2^64 has its turn.
        self.tickets = self.tickets.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let ticket = self.tickets;
        let (answers, answers_end) = pipe()?;
        let (orders_end, orders) = pipe()?;
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

/// A child's own end of the pipes to its keeper.
#[derive(Debug)]
pub struct Place {
    process: u32,
    ticket: u64,
    orders: Inbox<File>,
    answers: File,
}

impl Place {
    /// Sends an answer. A process that the FMU has forked and let return ends here instead: only the child
    /// itself answers. So does a child that cannot send.
    pub fn send(&mut self, payload: &[u8]) {
        if std::process::id() != self.process {
            end(0);
        }
        if frame::write(&self.answers, self.ticket, payload).is_err() {
            end(MUTE);
        }
    }

    /// Waits for the keeper's next message; `None` when none will come.
    pub fn receive(&mut self) -> Option<Vec<u8>> {
        let message = self.orders.wait().ok().flatten();
        if std::process::id() != self.process {
            end(0);
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
fn be_child(parent: u32, orders: OwnedFd, answers: OwnedFd, ticket: u64, work: &mut dyn FnMut(Place)) -> ! {
    let _ = setpgid(None, None);
    #[cfg(target_os = "linux")]
    let _ = rustix::process::set_parent_process_death_signal(Some(rustix::process::Signal::KILL));
    // The parent may have ended before.
    if getppid().map(Pid::as_raw_pid) != Some(parent as i32) {
        end(0);
    }
    usual_signals();
    let (orders, answers) = hidden(orders, answers);
    let place = Place { process: std::process::id(), ticket, orders: Inbox::new(orders, ticket), answers };
    // A panic must not unwind into the parent's code, which this process has a copy of.
    let done = std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| work(place)));
    if done.is_err() {
        // SAFETY: ends this process.
        unsafe { libc::abort() }
    }
    // SAFETY: writes what the FMU has printed so far, of all streams.
    unsafe { libc::fflush(std::ptr::null_mut()) };
    end(DONE)
}

/// Closes all descriptors above standard error but these two, and moves them to high numbers, which FMUs that write into or
/// close what they did not open seldom reach. In this order, as the system looks at each number up to the highest one.
fn hidden(orders: OwnedFd, answers: OwnedFd) -> (File, File) {
    const FIRST: RawFd = 3;
    let [one, other] = [orders.as_raw_fd(), answers.as_raw_fd()];
    let (low, high) = (one.min(other), one.max(other));
    close_between(FIRST, low - 1);
    close_between(low + 1, high - 1);
    close_between(high + 1, RawFd::MAX);
    (raised(orders), raised(answers))
}

/// The same file under a high number, where the system has one; programs that the FMU starts do not get it.
fn raised(fd: OwnedFd) -> File {
    const HIGH: [RawFd; 2] = [1016, 248];
    HIGH.into_iter().find_map(|least| fcntl_dupfd_cloexec(&fd, least).ok()).unwrap_or(fd).into()
}

/// Closes the descriptors of a range.
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
