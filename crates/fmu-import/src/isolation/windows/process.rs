//! Memory, end and modes of processes.

use std::{
    os::windows::{
        io::{AsRawHandle, FromRawHandle, OwnedHandle},
        process::CommandExt,
    },
    process::{Command, ExitStatus},
};

use windows_sys::Win32::System::{
    Console::GetConsoleCP,
    Diagnostics::Debug::{SEM_FAILCRITICALERRORS, SEM_NOGPFAULTERRORBOX, SEM_NOOPENFILEERRORBOX, SetErrorMode},
    ProcessStatus::{K32GetProcessMemoryInfo, PROCESS_MEMORY_COUNTERS},
    SystemInformation::{GlobalMemoryStatusEx, MEMORYSTATUSEX},
    Threading::{
        CREATE_NEW_PROCESS_GROUP, CREATE_NO_WINDOW, GetCurrentProcess, OpenProcess, PROCESS_QUERY_LIMITED_INFORMATION,
        TerminateProcess,
    },
};

use crate::isolation::loss::{Loss, MUTE};

/// The exit code of processes that a job ends.
pub(super) const KILLED: u32 = 1;
/// Exception codes begin here: errors and warnings of the system (NTSTATUS).
const EXCEPTIONS: u32 = 0x8000_0000;

/// A handle of a process; `None` when there is none, or this one may not have it.
pub(super) fn open(pid: u32, access: u32) -> Option<OwnedHandle> {
    // SAFETY: asks for a handle that children do not inherit.
    let handle = unsafe { OpenProcess(access, 0, pid) };
    // SAFETY: it was just made, and nobody else owns it.
    (!handle.is_null()).then(|| unsafe { OwnedHandle::from_raw_handle(handle) })
}

/// The memory that a process occupies, bytes; 0 where that is not known.
pub fn resident(pid: u32) -> u64 {
    let Some(process) = open(pid, PROCESS_QUERY_LIMITED_INFORMATION) else {
        return 0;
    };
    let mut counters = PROCESS_MEMORY_COUNTERS::default();
    let size = size_of_val(&counters) as u32;
    // SAFETY: a valid handle, and a struct of the size that is named.
    let told = unsafe { K32GetProcessMemoryInfo(process.as_raw_handle(), &raw mut counters, size) };
    if told == 0 {
        return 0;
    }
    counters.WorkingSetSize as u64
}

/// The memory of this machine, bytes; `None` where that is not known.
pub fn memory_of_machine() -> Option<u64> {
    let mut status = MEMORYSTATUSEX { dwLength: size_of::<MEMORYSTATUSEX>() as u32, ..MEMORYSTATUSEX::default() };
    // SAFETY: `status` may be written to, and `dwLength` is its size, as the function demands.
    let told = unsafe { GlobalMemoryStatusEx(&raw mut status) };
    (told != 0).then_some(status.ullTotalPhys)
}

/// Lets a command run apart from this process's console: Ctrl-C is for this process alone. Where this process has no
/// console, none appears.
pub fn detach(command: &mut Command) -> &mut Command {
    // SAFETY: asks for a number; 0 means that there is no console.
    let console = unsafe { GetConsoleCP() } != 0;
    let hidden = if console { 0 } else { CREATE_NO_WINDOW };
    command.creation_flags(CREATE_NEW_PROCESS_GROUP | hidden)
}

/// Lets this process and its children end without a window that tells of it and waits for an answer.
pub fn end_without_words() {
    // SAFETY: sets a mode of this process; the arguments are plain numbers.
    unsafe {
        SetErrorMode(SEM_FAILCRITICALERRORS | SEM_NOGPFAULTERRORBOX | SEM_NOOPENFILEERRORBOX);
    }
}

/// Ends this process at once: no destructor of any library has a say any more.
pub fn end(code: i32) -> ! {
    // SAFETY: ends this process; the handle stands for it and needs no closing.
    unsafe { TerminateProcess(GetCurrentProcess(), code.cast_unsigned()) };
    std::process::abort()
}

/// How a process ended that should not have ended so.
pub fn loss(status: ExitStatus) -> Loss {
    match status.code() {
        Some(MUTE) => Loss::Mute,
        Some(code) if code.cast_unsigned() >= EXCEPTIONS => Loss::Signal(code),
        code => Loss::Exit(code.unwrap_or(-1)),
    }
}
