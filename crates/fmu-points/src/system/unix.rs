//! Unix: process groups, signals, `/proc` where there is one.

use std::{
    fs::{self, File},
    io,
    mem::ManuallyDrop,
    net::UdpSocket,
    os::{
        fd::{AsFd, FromRawFd, OwnedFd},
        unix::{
            fs::{DirBuilderExt, MetadataExt},
            net::UnixDatagram,
            process::{CommandExt, ExitStatusExt},
        },
    },
    path::{Path, PathBuf},
    process::{ChildStdout, Command, ExitStatus},
    time::Duration,
};

use fmu_import::isolation::{Keeper, Loss, frame::Inbox, offspring, words::Words};
use rustix::{
    event::{PollFd, PollFlags, Timespec, poll},
    process::{Pid, Signal, geteuid, kill_process_group},
    stdio::dup2_stdin,
};

pub use fmu_import::isolation::offspring::{adopt_orphans, end_all, end_marked, is_stopped, kill_group as kill_worker};

/// Whether a worker needs a control group to be ended with all that it has started; else a group only makes that surer.
pub const GROUPS_ARE_NEEDED: bool = false;

/// Lets a command, which is this program, run in a process group of its own, out of reach of Ctrl-C.
pub fn detach(command: &mut Command) -> &mut Command {
    let name = std::env::args_os().next().unwrap_or_default();
    command.arg0(name).process_group(0)
}

/// Lets a command run in a session of its own: out of reach of Ctrl-C, and without a terminal where it could ask for a password.
pub fn set_apart(command: &mut Command) -> &mut Command {
    // SAFETY: a system call, which is all that happens between fork and exec.
    unsafe {
        command.pre_exec(|| rustix::process::setsid().map(|_| ()).map_err(Into::into));
    }
    command
}

/// This program, even when its file has been replaced since.
pub fn program() -> io::Result<PathBuf> {
    let program = Path::new("/proc/self/exe");
    if program.exists() { Ok(program.to_owned()) } else { std::env::current_exe() }
}

/// Where a worker's replies come from.
pub type ReplyPipe = File;

/// The same, from its standard output.
pub fn source(pipe: ChildStdout) -> ReplyPipe {
    File::from(OwnedFd::from(pipe))
}

/// Waits until there is something to read, or the end of it; `false` when the time is over.
pub fn is_ready(replies: &mut Inbox<ReplyPipe>, time: Duration) -> bool {
    let mut replies = [PollFd::new(replies.source(), PollFlags::IN)];
    let time = Timespec::try_from(time).ok();
    poll(&mut replies, time.as_ref()).is_ok_and(|ready| ready > 0)
}

/// How a process ended.
pub fn loss(status: ExitStatus) -> Loss {
    status.signal().map_or_else(|| Loss::Exit(status.code().unwrap_or(-1)), Loss::Signal)
}

/// Ends the group of a process at once. The process itself may have ended, and its number may be another's.
pub fn kill_group(leader: u32) {
    // Where that fails, there is none left to end.
    let _ = Pid::from_raw(leader as i32).map(|leader| kill_process_group(leader, Signal::KILL));
}

/// Asks the group of a process to end, also where it is stopped: a scheduler's command takes its job back.
pub fn ask_to_end(leader: u32) {
    if let Some(leader) = Pid::from_raw(leader as i32) {
        for signal in [Signal::TERM, Signal::CONT] {
            // Where that fails, there is none left to end.
            let _ = kill_process_group(leader, signal);
        }
    }
}

/// The user's number.
pub fn user() -> u32 {
    geteuid().as_raw()
}

/// Makes a folder into which nobody else can look.
pub fn make_private(folder: &Path) -> io::Result<()> {
    fs::DirBuilder::new().mode(0o700).create(folder)
}

/// Whether a path is that of an open file.
pub fn is_that_file(file: &File, path: &Path) -> bool {
    let place = |of: fs::Metadata| (of.dev(), of.ino());
    file.metadata().ok().zip(fs::metadata(path).ok()).is_some_and(|(open, named)| place(open) == place(named))
}

/// Sets a handler of signals, and leaves a hangup ignored where it was before, as by `nohup`.
pub fn without_hangup(set: impl FnOnce()) {
    // SAFETY: zeroes are a valid value of this plain struct, which the call fills.
    let ignored = unsafe {
        let mut now: libc::sigaction = std::mem::zeroed();
        libc::sigaction(libc::SIGHUP, std::ptr::null(), &raw mut now);
        now.sa_sigaction == libc::SIG_IGN
    };
    set();
    if ignored {
        // SAFETY: the signal then has no effect; no handler is involved.
        unsafe { libc::signal(libc::SIGHUP, libc::SIG_IGN) };
    }
}

/// The memory of this machine, bytes; `None` where that is not known.
pub fn memory_of_machine() -> Option<u64> {
    let text = fs::read_to_string("/proc/meminfo").ok()?;
    let total = text.lines().find_map(|line| line.strip_prefix("MemTotal:"))?;
    let kibibytes: u64 = total.split_whitespace().next()?.parse().ok()?;
    Some(kibibytes * 1024)
}

/// What this process holds that no other one of this machine can have meanwhile: a port at which it waits for others, the name of a
/// socket, a lock of a file outside of its room. None of the program's own descriptors does.
pub fn held() -> Option<String> {
    // The first descriptors are those of the FMU: the program keeps its own far above. Of more files it is not looked at.
    let mut first: [libc::pollfd; 13] =
        std::array::from_fn(|at| libc::pollfd { fd: 3 + at as i32, events: 0, revents: 0 });
    // SAFETY: writes to these entries which of the descriptors are open.
    unsafe { libc::poll(first.as_mut_ptr(), first.len() as libc::nfds_t, 0) };
    let mut open = first.iter().filter(|entry| entry.revents & libc::POLLNVAL == 0).map(|entry| entry.fd);
    open.find_map(|descriptor| {
        let Some(kind) = option(descriptor, libc::SO_TYPE) else {
            let is_file = io::Error::last_os_error().raw_os_error() == Some(libc::ENOTSOCK);
            return is_file.then(|| lock(descriptor))?;
        };
        // SAFETY: it is an open socket, which is asked for its address and not closed.
        let internet = ManuallyDrop::new(unsafe { UdpSocket::from_raw_fd(descriptor) });
        // SAFETY: the same.
        let local = ManuallyDrop::new(unsafe { UnixDatagram::from_raw_fd(descriptor) });
        if let Ok(name) = local.local_addr() {
            // A path is none of these.
            return (!name.is_unnamed() && name.as_pathname().is_none()).then(|| format!("socket {name:?}"));
        }
        let port = internet.local_addr().ok()?.port();
        let protocol = if kind == libc::SOCK_DGRAM { "UDP" } else { "TCP" };
        let waits = protocol == "UDP" || option(descriptor, libc::SO_ACCEPTCONN)? != 0;
        (waits && port != 0).then(|| format!("{protocol} port {port}"))
    })
}

/// The file that a descriptor has locked against others, unless it lies in the room, which no other point has.
fn lock(descriptor: i32) -> Option<String> {
    let [info, file] = ["fdinfo", "fd"].map(|what| format!("/proc/self/{what}/{descriptor}"));
    let file = fs::read_link(file).ok()?;
    let room = fs::canonicalize(std::env::temp_dir()).ok()?;
    let is_locked = fs::read_to_string(info).ok()?.contains(" WRITE ") && !file.starts_with(room.parent()?);
    is_locked.then(|| format!("lock of {}", file.file_name().unwrap_or_default().display()))
}

/// An option of a socket; none where the descriptor is no socket.
fn option(descriptor: i32, which: i32) -> Option<i32> {
    let (mut value, mut size) = (0_i32, size_of::<i32>() as libc::socklen_t);
    // SAFETY: writes at most `size` bytes to `value`; of a descriptor that is none the call says so.
    let done = unsafe { libc::getsockopt(descriptor, libc::SOL_SOCKET, which, (&raw mut value).cast(), &raw mut size) };
    (done == 0).then_some(value)
}

/// Ends this process at once: the destructors of an FMU in it have no say any more.
pub fn leave(code: i32) -> ! {
    // SAFETY: never returns, runs no code of this process.
    unsafe { libc::_exit(code) }
}

/// Whether a process may be forked; the rest is for the FMU to spoil.
pub const FORKS: bool = true;

/// A worker's standard streams, taken for the supervisor alone.
#[derive(Debug)]
pub struct Streams {
    superior: OwnedFd,
    error: OwnedFd,
}

impl Streams {
    /// Takes them: where orders come from, where replies go, and the rest. Reading gives the FMU nothing; what it prints
    /// the keeper hears.
    pub fn take() -> io::Result<(File, File, Self)> {
        let input = io::stdin().as_fd().try_clone_to_owned()?;
        let output = io::stdout().as_fd().try_clone_to_owned()?;
        let error = io::stderr().as_fd().try_clone_to_owned()?;
        dup2_stdin(File::open("/dev/null")?)?;
        offspring::become_keeper();
        let superior = input.try_clone()?;
        Ok((input.into(), output.into(), Self { superior, error }))
    }

    /// The keeper of the worker's children; with `echo`, what they print is shown on standard error.
    pub fn keeper(self, echo: bool, seed: u64) -> io::Result<Keeper> {
        let echo = echo.then(|| File::from(self.error));
        Ok(Keeper::new(self.superior, Words::overhear(echo)?, seed))
    }
}
