//! A control group for a worker: unlike a process group, no process can leave it by itself, and one word to the system
//! ends all that are in it (cgroups(7), version 2, `cgroup.kill` of Linux 5.14).
//!
//! Only where this process may make groups below its own; elsewhere there are none, and nobody is told: what
//! [`offspring`](super::offspring) does is enough for all but processes that hide on purpose.

use std::{
    fs,
    path::{Path, PathBuf},
    sync::{
        OnceLock,
        atomic::{AtomicU64, Ordering},
    },
    time::{Duration, Instant},
};

use crate::archive::entries_in;

/// The beginning of the names of groups; the number of the process that made a group follows.
const NAME: &str = "orchestrator-";

/// A group of processes, which end with it.
#[derive(Debug)]
pub struct ControlGroup {
    folder: PathBuf,
}

impl ControlGroup {
    /// A new group without processes; `None` where this process may make none.
    pub fn new() -> Option<Self> {
        static PARENT: OnceLock<Option<PathBuf>> = OnceLock::new();
        static MADE: AtomicU64 = AtomicU64::new(0);
        let parent = PARENT.get_or_init(own_folder).as_deref()?;
        let number = MADE.fetch_add(1, Ordering::Relaxed);
        if number == 0 {
            remove_forsaken(parent);
        }
        let folder = parent.join(format!("{NAME}{}-{number}", std::process::id()));
        fs::create_dir(&folder).ok()?;
        let group = Self { folder };
        // Older systems cannot end a group at once.
        group.folder.join("cgroup.kill").exists().then_some(group)
    }

    /// Takes a process in, with all that it will start. Whether that was possible.
    pub fn take(&self, pid: u32) -> bool {
        fs::write(self.folder.join("cgroup.procs"), pid.to_string()).is_ok()
    }

    /// The processes in it.
    pub fn processes(&self) -> Vec<u32> {
        fs::read_to_string(self.folder.join("cgroup.procs"))
            .unwrap_or_default()
            .lines()
            .filter_map(|line| line.parse().ok())
            .collect()
    }

    /// Ends all processes in it at once, whatever signals they block, and those that they are just starting.
    pub fn end(&self) {
        // Where that fails, there is none left to end.
        let _ = fs::write(self.folder.join("cgroup.kill"), "1");
    }
}

impl Drop for ControlGroup {
    fn drop(&mut self) {
        // A process that was ended takes a moment to go; one that waits in the kernel may never do.
        const PATIENCE: Duration = Duration::from_millis(100);
        self.end();
        let until = Instant::now() + PATIENCE;
        while fs::remove_dir(&self.folder).is_err() && Instant::now() < until {
            std::thread::sleep(Duration::from_micros(500));
        }
    }
}

/// The folder of the group in which this process is.
fn own_folder() -> Option<PathBuf> {
    let groups = fs::read_to_string("/proc/self/cgroup").ok()?;
    let mounts = fs::read_to_string("/proc/self/mountinfo").ok()?;
    folder_of(&groups, &mounts)
}

/// The folder of the group that `/proc/PID/cgroup` names, from the mounts in `/proc/PID/mountinfo` (proc(5)).
fn folder_of(groups: &str, mounts: &str) -> Option<PathBuf> {
    let group = groups.lines().find_map(|line| line.strip_prefix("0::"))?;
    mounts.lines().find_map(|line| {
        let (fields, file_system) = line.split_once(" - ")?;
        if !file_system.starts_with("cgroup2 ") {
            return None;
        }
        let mut fields = fields.split(' ').skip(3);
        let (root, place) = (fields.next()?, fields.next()?);
        let below = Path::new(group).strip_prefix(root).ok()?;
        Some(Path::new(place).join(below))
    })
}

/// Removes the groups of processes that were killed before they could. A group with processes is not removable.
fn remove_forsaken(parent: &Path) {
    for entry in entries_in(parent) {
        let name = entry.file_name();
        let maker = name.to_str().and_then(|name| {
            let (pid, _) = name.strip_prefix(NAME)?.split_once('-')?;
            pid.parse::<u32>().ok()
        });
        if maker.is_some_and(|pid| !Path::new(&format!("/proc/{pid}")).exists()) {
            let _ = fs::remove_dir(entry.path());
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_own_folder_is_found_wherever_the_groups_are_mounted() {
        let mounts = "24 18 0:21 / /sys rw - sysfs sysfs rw\n\
                      31 24 0:26 / /sys/fs/cgroup rw,nosuid - cgroup2 cgroup2 rw\n";
        let folder = |groups, mounts| folder_of(groups, mounts).map(|path| path.display().to_string());
        assert_eq!(
            folder("0::/user.slice/run.scope\n", mounts).as_deref(),
            Some("/sys/fs/cgroup/user.slice/run.scope")
        );
        // Both versions at once; a container that sees only a part of the tree.
        let part = "31 24 0:26 /machine/one /groups rw - cgroup2 none rw\n";
        assert_eq!(folder("5:cpu:/x\n0::/machine/one/a\n", part).as_deref(), Some("/groups/a"));
        assert_eq!(folder("0::/elsewhere\n", part), None);
        assert_eq!(folder("5:cpu:/x\n", mounts), None);
        assert_eq!(folder("0::/a\n", "24 18 0:21 / /sys rw - sysfs sysfs rw\n"), None);
    }
}
