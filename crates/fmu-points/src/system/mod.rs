//! The operating system under the engine: everything in which Unix and Windows differ. Both files give the same names.

#[cfg(unix)]
mod unix;
#[cfg(windows)]
mod windows;

#[cfg(unix)]
use unix as own;
#[cfg(windows)]
use windows as own;

pub(crate) use own::*;
pub use own::{held, memory_of_machine};

/// Four fifths of the machine's memory, shared by so many workers, bytes.
pub fn share_of_memory(workers: usize) -> u64 {
    // Where the size is not known, a limit that any of today's machines keeps.
    const UNKNOWN: u64 = 4 << 30;
    memory_of_machine().map_or(UNKNOWN, |bytes| bytes / 5 * 4) / workers.max(1) as u64
}

/// Lets a file that grows beyond the user's limit (`ulimit -f`) be an error of writing it, and not the end of this process.
pub fn survive_large_files() {
    #[cfg(unix)]
    // SAFETY: the signal then has no effect; no handler is involved.
    unsafe {
        libc::signal(libc::SIGXFSZ, libc::SIG_IGN)
    };
}

/// Gives large blocks of memory back to the system when they are freed. Without this, the GNU C library keeps blocks as large as
/// the largest one freed so far: a program that reads long recordings would hold on to half as much again as it needs.
pub fn give_back_memory() {
    #[cfg(all(target_os = "linux", target_env = "gnu"))]
    {
        const LARGE: i32 = 1 << 20;
        // Smaller ones come and go by the thousand: what is free at the heap's end is kept for the next ones.
        const KEPT: i32 = 32 << 20;
        // SAFETY: sets options of this process's C library.
        unsafe {
            libc::mallopt(libc::M_MMAP_THRESHOLD, LARGE);
            libc::mallopt(libc::M_TRIM_THRESHOLD, KEPT);
        }
    }
}

/// Gives all memory that is free back to the system: a fork has less to copy then.
pub(crate) fn give_back_free_memory() {
    #[cfg(all(target_os = "linux", target_env = "gnu"))]
    // SAFETY: asks this process's C library, which knows what is free.
    unsafe {
        libc::malloc_trim(0);
    }
}
