//! Processes that an FMU leaves behind: found, ended and reaped.
//!
//! A child has a process group of its own, but an FMU may leave it (`setsid`) or start daemons. As a
//! *subreaper* (`prctl(2)`) this process inherits whatever its children leave behind, and ends it.

use std::{
    fs,
    time::{Duration, Instant},
};

use rustix::{
    param::page_size,
    process::{
        Pid, Resource, Rlimit, Signal, WaitOptions, getrlimit, kill_process, kill_process_group, setrlimit, wait,
        waitpid,
    },
};

use super::system::ignore_signals;

/// Makes this process the parent of all that its children leave behind, where the system can. Whoever started it may ignore
/// SIGCHLD, and so may the initialisers of an FMU: then nobody could ask how a child ended.
pub fn adopt_orphans() {
    // SAFETY: this signal then has no effect; no handler is involved.
    unsafe { libc::signal(libc::SIGCHLD, libc::SIG_DFL) };
    // Every Linux of today can.
    #[cfg(target_os = "linux")]
    let _ = rustix::process::set_child_subreaper(Some(rustix::process::getpid()));
}

/// Ends a process and its group at once: SIGKILL cannot be blocked, and reaches stopped processes too.
pub fn kill_group(leader: u32) {
    // A group of 0 or 1 would be this process's own or everyone's.
    if let Some(leader) = Pid::from_raw(leader as i32).filter(|_| leader > 1) {
        // Where that fails, there is none left to end.
        let _ = kill_process_group(leader, Signal::KILL);
        let _ = kill_process(leader, Signal::KILL);
    }
}

/// Ends and reaps all children of this process, and the grandchildren that it inherits by that.
/// Gives up after a second: nobody can end a process that waits in the kernel (for a dead network disk).
///
/// Only for a process that needs none of its children any more, and waits for none elsewhere.
pub fn end_all() {
    let deadline = Instant::now() + Duration::from_secs(1);
    loop {
        match wait(WaitOptions::NOHANG) {
            // No child is left: the usual case, at the cost of one system call.
            Err(_) => return,
            Ok(None) => {
                if Instant::now() > deadline {
                    return;
                }
                children_of(std::process::id()).into_iter().for_each(kill_group);
                std::thread::sleep(Duration::from_micros(200));
            }
            Ok(Some(_)) => {}
        }
    }
}

/// Makes this process fit to keep children: what they leave behind becomes its own, and the signals that they may
/// send it have no effect. Crashes leave no dump of the memory: a study may see thousands.
pub fn become_keeper() {
    adopt_orphans();
    ignore_signals();
    let limit = Rlimit { current: Some(0), ..getrlimit(Resource::Core) };
    // A dump is a nuisance, and no more.
    let _ = setrlimit(Resource::Core, limit);
}

/// The memory that a process occupies, bytes; 0 where that is not known, so that no limit is passed there.
pub fn resident(pid: u32) -> u64 {
    // The second number is the resident set in pages (proc(5)).
    let text = fs::read_to_string(format!("/proc/{pid}/statm"));
    let pages = text.ok().and_then(|text| text.split(' ').nth(1)?.parse::<u64>().ok());
    pages.unwrap_or(0) * page_size() as u64
}

/// Whether a process has been stopped (SIGSTOP), so that nothing will come from it.
pub fn is_stopped(pid: u32) -> bool {
    state_and_parent(pid).is_some_and(|(state, _)| state == "T" || state == "t")
}

/// Ends and reaps the children of this process whose environment holds `mark`, except `spared`: processes that
/// outlived the keeper that they belonged to. Whether there were any. What has not ended after a moment stays for the next call.
pub fn end_marked(mark: &str, spared: impl Fn(u32) -> bool) -> bool {
    let until = Instant::now() + Duration::from_millis(50);
    let mut any = false;
    for pid in children_of(std::process::id()).into_iter().filter(|pid| !spared(*pid)) {
        let killed = is_marked(pid, mark);
        if killed {
            any = true;
            kill_group(pid);
        }
        // One that has ended already has no environment any more; nobody else will wait for it.
        let reap = || waitpid(Pid::from_raw(pid as i32), WaitOptions::NOHANG);
        while matches!(reap(), Ok(None)) && killed && Instant::now() < until {
            std::thread::sleep(Duration::from_micros(200));
        }
    }
    any
}

/// Whether a process was started with `mark` in its environment.
fn is_marked(pid: u32, mark: &str) -> bool {
    let environment = fs::read(format!("/proc/{pid}/environ")).unwrap_or_default();
    let mut entries = environment.split(|&byte| byte == 0);
    entries.any(|entry| entry == mark.as_bytes())
}

/// The children of a process, whichever of its threads started them; none where the system does not tell.
fn children_of(parent: u32) -> Vec<u32> {
    let Ok(processes) = fs::read_dir("/proc") else { return Vec::new() };
    let number = |name: &std::ffi::OsStr| name.to_str()?.parse::<u32>().ok();
    processes
        .flatten()
        .filter_map(|entry| number(&entry.file_name()))
        .filter(|pid| state_and_parent(*pid).is_some_and(|(_, of)| of == parent))
        .collect()
}

/// State and parent of a process: the fields after its name, which may hold anything (proc(5), `stat`).
fn state_and_parent(pid: u32) -> Option<(String, u32)> {
    let stat = fs::read(format!("/proc/{pid}/stat")).ok()?;
    let stat = String::from_utf8_lossy(&stat);
    let (_, fields) = stat.rsplit_once(')')?;
    let mut fields = fields.split_ascii_whitespace();
    Some((fields.next()?.to_owned(), fields.next()?.parse().ok()?))
}

#[cfg(test)]
mod tests {
    use std::{
        ffi::OsStr,
        os::unix::{ffi::OsStrExt, fs::symlink, process::CommandExt},
        process::{Command, Stdio},
    };

    use super::*;

    #[test]
    fn a_process_is_found_and_ended_whatever_its_name() {
        let folder = tempfile::tempdir().unwrap();
        let shell = folder.path().join(OsStr::from_bytes(b"\xff) Z 1"));
        symlink("/bin/sh", &shell).unwrap();
        let mut command = Command::new(&shell);
        // It waits for what it is to do, and ends well if nothing comes.
        let mut child = command.arg0("sh").env("OFFSPRING", "marked").stdin(Stdio::piped()).spawn().unwrap();
        let until = Instant::now() + Duration::from_secs(10);
        while !is_marked(child.id(), "OFFSPRING=marked") && Instant::now() < until {
            std::thread::sleep(Duration::from_millis(1));
        }
        assert!(end_marked("OFFSPRING=marked", |pid| pid != child.id()));
        assert!(!child.wait().is_ok_and(|end| end.success()));
    }
}
