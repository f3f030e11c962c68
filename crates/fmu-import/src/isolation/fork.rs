//! A piece of work in a forked child: one frame comes back, or the reason why none does.

use std::fs::File;
use std::io::{self, Read};
use std::os::fd::{AsRawFd, FromRawFd, OwnedFd};
use std::time::{Duration, Instant};

use super::frame::{self, Broken};
use super::offspring::{kill_group, own_pid};

/// How often a silent child is looked at: it may have stopped, or have ended with its pipe held open by others.
const LOOK: Duration = Duration::from_millis(10);

/// How a child ended that gave no answer.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Loss {
    /// A signal ended it.
    Signal(i32),
    /// It ended by itself with this exit code.
    Exit(i32),
    /// It stopped itself, and would have waited for ever.
    Stopped,
    /// It took longer than it may.
    Timeout,
    /// It closed its pipe, or what it sent is no answer.
    Garbled(Option<Broken>),
}

/// A forked child at work.
pub struct Child {
    pid: libc::pid_t,
    answers: File,
    ticket: u64,
    reaped: bool,
}

impl Child {
    /// Forks; the child does `work`, sends its answer and ends without running any destructor.
    ///
    /// # Errors
    /// When the system has no room for a further process or descriptor.
    ///
    /// # Safety
    /// This process has a single thread: in a forked child of several, locks that other threads hold stay
    /// locked for ever.
    pub unsafe fn fork(ticket: u64, work: impl FnOnce() -> Vec<u8>) -> io::Result<Self> {
        let (answers, place) = pipe()?;
        // SAFETY: the caller vouches for a single thread.
        match unsafe { libc::fork() } {
            -1 => Err(io::Error::last_os_error()),
            0 => {
                drop(answers);
                be_child(place, ticket, work)
            }
            pid => {
                // Both sides do so: whoever comes first.
                // SAFETY: changes the child's group only.
                unsafe { libc::setpgid(pid, pid) };
                Ok(Self {
                    pid,
                    answers: answers.into(),
                    ticket,
                    reaped: false,
                })
            }
        }
    }

    /// Waits for the answer, at most until `deadline`. The child and its group are ended in any case.
    ///
    /// # Errors
    /// When none comes.
    pub fn answer(mut self, deadline: Option<Instant>) -> Result<Vec<u8>, Loss> {
        let answer = self.wait(deadline);
        self.end();
        answer
    }

    fn wait(&mut self, deadline: Option<Instant>) -> Result<Vec<u8>, Loss> {
        let mut arrived = Vec::new();
        let mut buffer = [0; 1 << 12];
        loop {
            if self.readable() {
                match self.answers.read(&mut buffer) {
                    // Nobody can write any more; how the child ends says why.
                    Ok(0) => return Err(self.ending(deadline)),
                    Ok(n) => arrived.extend_from_slice(&buffer[..n]),
                    Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
                    Err(_) => return Err(Loss::Garbled(None)),
                }
                match frame::take(&mut arrived, self.ticket) {
                    Ok(Some(payload)) => return Ok(payload),
                    Ok(None) => {}
                    Err(broken) => return Err(Loss::Garbled(Some(broken))),
                }
            } else if let Some(loss) = self.look() {
                // It may have answered just before.
                if !self.readable() {
                    return Err(loss);
                }
            }
            if deadline.is_some_and(|deadline| Instant::now() > deadline) {
                return Err(Loss::Timeout);
            }
        }
    }

    /// Whether there is something to read, or the end of it, within a short time.
    fn readable(&self) -> bool {
        let mut poll = libc::pollfd {
            fd: self.answers.as_raw_fd(),
            events: libc::POLLIN,
            revents: 0,
        };
        // SAFETY: one valid descriptor, which `self` keeps open.
        unsafe { libc::poll(&raw mut poll, 1, LOOK.as_millis() as i32) > 0 }
    }

    /// What has become of the child, where it does not run any more.
    fn look(&mut self) -> Option<Loss> {
        let mut status = 0;
        let flags = libc::WNOHANG | libc::WUNTRACED;
        // SAFETY: `status` is valid for writing.
        let found = unsafe { libc::waitpid(self.pid, &raw mut status, flags) };
        if found != self.pid {
            return None;
        }
        if libc::WIFSTOPPED(status) {
            return Some(Loss::Stopped);
        }
        self.reaped = true;
        Some(if libc::WIFSIGNALED(status) {
            Loss::Signal(libc::WTERMSIG(status))
        } else {
            Loss::Exit(libc::WEXITSTATUS(status))
        })
    }

    /// How a child ends whose pipe is closed. One that only closed it must not hold us up.
    fn ending(&mut self, deadline: Option<Instant>) -> Loss {
        const PATIENCE: Duration = Duration::from_secs(1);
        let patience = Instant::now() + PATIENCE;
        let until = deadline.map_or(patience, |deadline| deadline.min(patience));
        loop {
            if let Some(loss) = self.look() {
                return loss;
            }
            if Instant::now() > until {
                return Loss::Garbled(None);
            }
            std::thread::sleep(Duration::from_micros(100));
        }
    }

    /// Ends the child with its group, and reaps it.
    fn end(&mut self) {
        if self.reaped {
            // Its number may be another's by now, but a group keeps its number while it has members.
            // SAFETY: sends a signal; nothing of this process changes.
            unsafe { libc::kill(-self.pid, libc::SIGKILL) };
            return;
        }
        kill_group(self.pid);
        let mut status = 0;
        // SAFETY: `status` is valid for writing; SIGKILL ends the child, so the wait is short.
        unsafe { libc::waitpid(self.pid, &raw mut status, 0) };
        self.reaped = true;
    }
}

impl Drop for Child {
    fn drop(&mut self) {
        if !self.reaped {
            self.end();
        }
    }
}

/// The child's side: a group of its own, no descriptor but its own, the work, one frame, the end.
fn be_child(place: OwnedFd, ticket: u64, work: impl FnOnce() -> Vec<u8>) -> ! {
    let own = own_pid();
    // SAFETY: these change this process only; the arguments are plain numbers.
    unsafe {
        libc::setpgid(0, 0);
        #[cfg(target_os = "linux")]
        libc::prctl(libc::PR_SET_PDEATHSIG, libc::SIGKILL);
    }
    let place = close_others(place);
    // A panic must not unwind into the parent's code, which this process has a copy of.
    let answer = std::panic::catch_unwind(std::panic::AssertUnwindSafe(work));
    // An FMU may have forked and returned in both processes: only the child itself answers.
    if own_pid() == own
        && let Ok(answer) = answer
    {
        let _ = frame::write(&place, ticket, &answer);
    }
    // SAFETY: writes what the FMU has printed so far; then ends this process without any destructor, which might
    // be the FMU's.
    unsafe {
        libc::fflush(std::ptr::null_mut());
        libc::_exit(0)
    }
}

/// Closes every descriptor above standard error but one, which is moved there.
fn close_others(place: OwnedFd) -> File {
    const FIRST: i32 = 3;
    let number = place.as_raw_fd();
    if number != FIRST {
        // SAFETY: the descriptor is open; whatever number 3 was is this child's copy, to be closed anyway.
        unsafe { libc::dup2(number, FIRST) };
    }
    // Closed below with the others, or in use as number 3.
    std::mem::forget(place);
    // SAFETY: nothing in this child uses any of them again.
    unsafe {
        #[cfg(target_os = "linux")]
        let closed = libc::syscall(libc::SYS_close_range, FIRST + 1, u32::MAX, 0) == 0;
        #[cfg(not(target_os = "linux"))]
        let closed = false;
        if !closed {
            for other in FIRST + 1..libc::sysconf(libc::_SC_OPEN_MAX).clamp(64, 4096) as i32 {
                libc::close(other);
            }
        }
        // Programs that the FMU starts do not get it.
        libc::fcntl(FIRST, libc::F_SETFD, libc::FD_CLOEXEC);
        File::from_raw_fd(FIRST)
    }
}

/// A pipe: the end to read from, the end to write to.
fn pipe() -> io::Result<(OwnedFd, OwnedFd)> {
    let (reader, writer) = io::pipe()?;
    Ok((reader.into(), writer.into()))
}
