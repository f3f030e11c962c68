//! Processes that an FMU leaves behind: found, ended and reaped.
//!
//! A child has a process group of its own, but an FMU may leave it (`setsid`) or start daemons. As a
//! *subreaper* (`prctl(2)`) this process inherits whatever its children leave behind, and ends it.

use std::fs;
use std::time::{Duration, Instant};

/// Makes this process the parent of all that its children leave behind. Without effect where the system cannot.
pub fn adopt_orphans() {
    #[cfg(target_os = "linux")]
    // SAFETY: sets a property of this process; the arguments are plain numbers.
    unsafe {
        libc::prctl(libc::PR_SET_CHILD_SUBREAPER, 1, 0, 0, 0);
    }
}

/// Ends a process and its group at once: SIGKILL cannot be blocked, and reaches stopped processes too.
pub fn kill_group(leader: libc::pid_t) {
    // A group of 0 or 1 would be this process's own or everyone's.
    if leader > 1 {
        // SAFETY: sends a signal; nothing of this process changes.
        unsafe {
            libc::kill(-leader, libc::SIGKILL);
            libc::kill(leader, libc::SIGKILL);
        }
    }
}

/// Ends and reaps all children of this process, with all that becomes its child by that.
/// Gives up after a second: what the kernel holds (a dead network disk) cannot be ended by anyone.
///
/// Only for a process that wants no child to live, and waits for none elsewhere.
pub fn end_all() {
    let deadline = Instant::now() + Duration::from_secs(1);
    loop {
        let mut status = 0;
        // SAFETY: `status` is valid for writing.
        match unsafe { libc::waitpid(-1, &raw mut status, libc::WNOHANG) } {
            // No child is left: the usual case, at the cost of one system call.
            -1 => return,
            0 => {
                if Instant::now() > deadline {
                    return;
                }
                children_of(own_pid()).into_iter().for_each(kill_group);
                std::thread::sleep(Duration::from_micros(200));
            }
            _ => {}
        }
    }
}

/// This process's number.
pub fn own_pid() -> libc::pid_t {
    // SAFETY: always succeeds, changes nothing.
    unsafe { libc::getpid() }
}

/// The children of a process, whichever of its threads started them; none where the system does not tell.
pub fn children_of(parent: libc::pid_t) -> Vec<libc::pid_t> {
    let Ok(processes) = fs::read_dir("/proc") else {
        return Vec::new();
    };
    let number = |name: &std::ffi::OsStr| name.to_str()?.parse::<libc::pid_t>().ok();
    processes
        .flatten()
        .filter_map(|entry| number(&entry.file_name()))
        .filter(|pid| parent_of(*pid) == Some(parent))
        .collect()
}

/// The parent of a process: the second field after its name, which may hold anything (proc(5), `stat`).
fn parent_of(pid: libc::pid_t) -> Option<libc::pid_t> {
    let stat = fs::read_to_string(format!("/proc/{pid}/stat")).ok()?;
    let (_, fields) = stat.rsplit_once(')')?;
    fields.split_ascii_whitespace().nth(1)?.parse().ok()
}
