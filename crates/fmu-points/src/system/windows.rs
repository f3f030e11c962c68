//! Windows: job objects in place of process groups and signals. A worker's job ends what its worker has started.

use std::{
    fs::File,
    io,
    os::windows::io::{AsHandle, OwnedHandle},
    path::{Path, PathBuf},
    process::{ChildStdout, ExitStatus},
    time::Duration,
};

use fmu_import::isolation::{Keeper, Loss, frame::Inbox, pipe::Arrivals, process};

pub use fmu_import::isolation::process::memory_of_machine;
pub use fmu_import::isolation::process::{detach, detach as set_apart};

/// Whether a worker needs a control group to be ended with all that it has started.
pub const GROUPS_ARE_NEEDED: bool = true;

/// A process that ends leaves its children to nobody.
pub fn adopt_orphans() {}

/// This program. Its file cannot be replaced while it runs.
pub fn program() -> io::Result<PathBuf> {
    std::env::current_exe()
}

/// Makes a folder: the user's own folder for temporary files is nobody else's.
pub fn make_private(folder: &Path) -> io::Result<()> {
    std::fs::create_dir(folder)
}

/// Whether a path is that of an open file: an open file keeps its folder.
pub fn is_that_file(_: &File, _: &Path) -> bool {
    true
}

/// What no other process of this machine can have meanwhile: not looked for.
pub fn held() -> Option<String> {
    None
}

/// Where a worker's replies come from.
pub type ReplyPipe = Arrivals;

/// The same, from its standard output.
pub fn source(pipe: ChildStdout) -> ReplyPipe {
    Arrivals::of(pipe)
}

/// Waits until there is something to read, or the end of it; `false` when the time is over.
pub fn is_ready(replies: &mut Inbox<ReplyPipe>, time: Duration) -> bool {
    replies.source_mut().wait(time)
}

/// How a process ended.
pub fn loss(status: ExitStatus) -> Loss {
    match process::loss(status) {
        Loss::Mute => Loss::Exit(status.code().unwrap_or(-1)),
        loss => loss,
    }
}

/// Whether a process has been stopped: Windows does not tell, so its deadline ends it.
pub fn is_stopped(_: u32) -> bool {
    false
}

/// Jobs end processes here.
pub fn kill_group(_: u32) {}

/// There is no such request here.
pub fn ask_to_end(_: u32) {}

/// Users have folders for temporary files of their own here.
pub fn user() -> u32 {
    0
}

/// Sets a handler of signals.
pub fn without_hangup(set: impl FnOnce()) {
    set();
}

/// Jobs end workers here.
pub fn kill_worker(_: u32) {}

/// Jobs end processes here, so none outlives its worker. Whether there were any.
pub fn end_marked(_: &str, _: impl Fn(u32) -> bool) -> bool {
    false
}

/// The keeper's children end with their jobs.
pub fn end_all() {}

/// Ends this process at once: the destructors of an FMU in it have no say any more.
pub fn leave(code: i32) -> ! {
    process::end(code)
}

/// There are no forks.
pub const FORKS: bool = false;

/// A worker's standard streams. The FMU runs in other processes, which have streams of their own.
#[derive(Debug)]
pub struct Streams;

impl Streams {
    /// Where orders come from, where replies go, and the rest.
    pub fn take() -> io::Result<(File, File, Self)> {
        let input = io::stdin().as_handle().try_clone_to_owned()?;
        let output = io::stdout().as_handle().try_clone_to_owned()?;
        Ok((input.into(), output.into(), Self))
    }

    /// The keeper of the worker's children; with `echo`, what they print is shown on standard error.
    pub fn keeper(self, echo: bool, seed: u64) -> io::Result<Keeper> {
        let error = echo.then(|| io::stderr().as_handle().try_clone_to_owned());
        let error: Option<OwnedHandle> = error.transpose()?;
        Ok(Keeper::new(error.map(File::from), seed))
    }
}
