//! Windows: job objects in place of process groups and signals. A worker's job ends what its worker has started.

use std::fs::{File, Metadata};
use std::io;
use std::os::windows::io::{AsHandle, OwnedHandle};
use std::path::{Path, PathBuf};
use std::process::{ChildStdout, ExitStatus};
use std::ptr::{self, NonNull};
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

use fmu_import::isolation::frame::Inbox;
use fmu_import::isolation::pipe::Arrivals;
use fmu_import::isolation::process;
use fmu_import::isolation::{Keeper, Loss};
use windows_sys::Win32::Foundation::INVALID_HANDLE_VALUE;
use windows_sys::Win32::System::Memory::{CreateFileMappingW, FILE_MAP_ALL_ACCESS, MapViewOfFile, PAGE_READWRITE};

pub use fmu_import::isolation::process::memory_of_machine;
pub(crate) use fmu_import::isolation::process::{detach, detach as set_apart};

/// Whether a worker needs a control group to be ended with all that it has started.
pub(crate) const GROUPS_ARE_NEEDED: bool = true;

/// A process that ends leaves its children to nobody.
pub(crate) fn adopt_orphans() {}

/// This program. Its file cannot be replaced while it runs.
pub(crate) fn program() -> io::Result<PathBuf> {
    std::env::current_exe()
}

/// Makes a folder: the user's own folder for temporary files is nobody else's.
pub(crate) fn make_private(folder: &Path) -> io::Result<()> {
    std::fs::create_dir(folder)
}

/// Whether a path is that of an open file: an open file keeps its folder.
pub(crate) fn is_that_file(_: &File, _: &Path) -> bool {
    true
}

/// A port at which this process waits for others: not looked for.
pub(crate) fn held_port() -> Option<String> {
    None
}

/// Where a worker's replies come from.
pub(crate) type Source = Arrivals;

/// The same, from its standard output.
pub(crate) fn source(pipe: ChildStdout) -> Source {
    Arrivals::of(pipe)
}

/// Waits until there is something to read, or the end of it; `false` when the time is over.
pub(crate) fn is_ready(replies: &mut Inbox<Source>, time: Duration) -> bool {
    replies.source_mut().wait(time)
}

/// How a process ended.
pub(crate) fn loss(status: ExitStatus) -> Loss {
    match process::loss(status) {
        Loss::Mute => Loss::Exit(status.code().unwrap_or(-1)),
        loss => loss,
    }
}

/// Whether a process has been stopped: Windows does not tell, so its deadline ends it.
pub(crate) fn is_stopped(_: u32) -> bool {
    false
}

/// Jobs end processes here.
pub(crate) fn kill_group(_: u32) {}

/// There is no such request here.
pub(crate) fn ask_to_end(_: u32) {}

/// Users have folders for temporary files of their own here.
pub(crate) fn user() -> u32 {
    0
}

/// Nobody else may write where this user's temporary files are.
pub(crate) fn is_mine(_: &Metadata) -> bool {
    true
}

/// Sets a handler of signals.
pub(crate) fn without_hangup(set: impl FnOnce()) {
    set();
}

/// Jobs end workers here.
pub(crate) fn kill_worker(_: u32) {}

/// Jobs end processes here, so none outlives its worker. Whether there were any.
pub(crate) fn end_marked(_: &str, _: impl Fn(u32) -> bool) -> bool {
    false
}

/// The keeper's children end with their jobs.
pub(crate) fn end_all() {}

/// Ends this process at once: the destructors of an FMU in it have no say any more.
pub(crate) fn leave(code: i32) -> ! {
    process::end(code)
}

/// There are no forks.
pub(crate) const FORKS: bool = false;

/// A worker's standard streams. The FMU runs in other processes, which have streams of their own.
#[derive(Debug)]
pub(crate) struct Streams;

impl Streams {
    /// Where orders come from, where replies go, and the rest.
    pub(crate) fn take() -> io::Result<(File, File, Self)> {
        let input = io::stdin().as_handle().try_clone_to_owned()?;
        let output = io::stdout().as_handle().try_clone_to_owned()?;
        Ok((input.into(), output.into(), Self))
    }

    /// The keeper of the worker's children; with `echo`, what they print is shown on standard error.
    pub(crate) fn keeper(self, echo: bool, seed: u64) -> io::Result<Keeper> {
        let error = echo.then(|| io::stderr().as_handle().try_clone_to_owned());
        let error: Option<OwnedHandle> = error.transpose()?;
        Ok(Keeper::new(error.map(File::from), seed))
    }
}

/// A number that this process and its children see. An FMU may overwrite it: nothing but a guess may rest on it.
#[derive(Debug)]
pub(crate) struct Shared {
    place: NonNull<AtomicU64>,
    name: String,
}

impl Shared {
    pub(crate) fn new() -> io::Result<Self> {
        Self::open(format!(r"Local\orchestrator-{:032x}", rand::random::<u128>()))
    }

    /// The number of this name; a new one, zero, where there is none yet.
    pub(crate) fn open(name: String) -> io::Result<Self> {
        let size = size_of::<AtomicU64>();
        let wide: Vec<u16> = name.encode_utf16().chain([0]).collect();
        let (file, none) = (INVALID_HANDLE_VALUE, ptr::null());
        // SAFETY: fresh memory without a file behind it; the name ends with a zero.
        let mapping = unsafe { CreateFileMappingW(file, none, PAGE_READWRITE, 0, size as u32, wide.as_ptr()) };
        if mapping.is_null() {
            return Err(io::Error::last_os_error());
        }
        // SAFETY: a valid handle, of which the whole is asked for. The handle and the view live as long as this process.
        let view = unsafe { MapViewOfFile(mapping, FILE_MAP_ALL_ACCESS, 0, 0, size) };
        let place = NonNull::new(view.Value.cast()).ok_or_else(io::Error::last_os_error)?;
        Ok(Self { place, name })
    }

    /// By which a child finds it.
    pub(crate) fn name(&self) -> &str {
        &self.name
    }

    pub(crate) fn get(&self) -> u64 {
        // SAFETY: the view is page-aligned, holds zeroes at first, and is never unmapped.
        unsafe { self.place.as_ref() }.load(Ordering::Relaxed)
    }

    pub(crate) fn set(&self, value: u64) {
        // SAFETY: as in `get`.
        unsafe { self.place.as_ref() }.store(value, Ordering::Relaxed);
    }
}
