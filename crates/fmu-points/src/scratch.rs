//! Folders for what is needed while a command runs, such as the unpacked FMU.
//!
//! They are removed when the command ends, also where a signal ends it: an FMU may hold hundreds of megabytes, and
//! nobody else would ever remove them. Those of a command that was killed go when the next one begins.

use std::{
    collections::BTreeSet,
    fs::{self, File, OpenOptions},
    io,
    path::{Path, PathBuf},
    sync::{Mutex, MutexGuard},
    thread::sleep,
    time::Duration,
};

use thiserror::Error;

use crate::system;
use fmu_import::archive::entries_in;

/// Why there is no folder.
#[derive(Debug, Error)]
#[error("{path}: {source}; set TMPDIR to another folder")]
pub struct ScratchError {
    /// The folder in which it was to be, or its lock.
    pub path: PathBuf,
    /// The operating system's message.
    pub source: io::Error,
}

impl ScratchError {
    pub(crate) fn at(path: &Path) -> impl FnOnce(io::Error) -> Self {
        let path = path.to_owned();
        move |source| Self { path, source }
    }
}

/// A folder that is removed with this.
#[derive(Debug)]
pub struct Scratch {
    folder: PathBuf,
    /// Says that the folder is in use.
    _lock: File,
}

/// The folders that there are.
static FOLDERS: Mutex<BTreeSet<PathBuf>> = Mutex::new(BTreeSet::new());
/// The file of a folder in the system's place for such folders that its process has locked.
const LOCK: &str = "in-use";
/// The names of those folders begin so. Earlier versions sweep up "orchestrator-..." by names that no other command had.
const PREFIX: &str = "fmu-run-";

fn folders() -> MutexGuard<'static, BTreeSet<PathBuf>> {
    fmu_import::locked(&FOLDERS)
}

impl Scratch {
    /// Makes a folder where the system has such folders. Its path is the same in every run of a user, unless several run at a
    /// time: an FMU may see it.
    ///
    /// # Errors
    /// When the system says no.
    pub(crate) fn new() -> Result<Self, ScratchError> {
        let place = place();
        remove_abandoned(&place);
        Self::within(&place).map_err(ScratchError::at(&place))
    }

    fn within(place: &Path) -> io::Result<Self> {
        for number in 1_u32.. {
            let folder = place.join(format!("{PREFIX}{}-{number}", system::user()));
            // A signal that comes between the two finds the folder.
            let mut folders = folders();
            match system::make_private(&folder) {
                Ok(()) => {
                    folders.insert(folder.clone());
                    let lock = locked(&folder.join(LOCK))?;
                    return Ok(Self { folder, _lock: lock });
                }
                Err(error) if error.kind() == io::ErrorKind::AlreadyExists => {}
                Err(error) => return Err(error),
            }
        }
        Err(io::ErrorKind::AlreadyExists.into())
    }

    /// Where it is.
    pub fn path(&self) -> &Path {
        &self.folder
    }
}

impl Drop for Scratch {
    fn drop(&mut self) {
        // Once it has gone, the next command may have a folder of the same name: it is removed once.
        let mut folders = folders();
        if folders.remove(&self.folder) {
            remove(&self.folder);
        }
    }
}

/// The system's place for such folders, unless its path has what FMUs stumble over: a blank, or a percent sign.
fn place() -> PathBuf {
    let is_plain = |path: &Path| path.to_str().is_some_and(|text| !text.contains([' ', '%']));
    let usual = std::env::temp_dir();
    let other = Path::new("/tmp");
    if !is_plain(&usual) && other.is_dir() { other.to_owned() } else { usual }
}

/// Makes a file that is locked from the moment at which it has its name.
fn locked(path: &Path) -> io::Result<File> {
    let unnamed = path.with_extension("new");
    let file = File::create(&unnamed)?;
    // Where there are no locks, the folder of a killed command stays.
    let _ = file.try_lock();
    fs::rename(unnamed, path)?;
    Ok(file)
}

/// Removes the folders of commands that were killed: their locks are free.
fn remove_abandoned(place: &Path) {
    for folder in starting_with(place, &[PREFIX]) {
        let lock = folder.join(LOCK);
        let Ok(file) = OpenOptions::new().write(true).open(&lock) else { continue };
        // Between the two the folder may have gone, and another one have come under its name. The lock keeps other commands from
        // removing the folder, too: they might remove the next one of that name.
        if file.try_lock().is_ok() && system::is_that_file(&file, &lock) {
            remove(&folder);
        }
    }
}

/// Removes all folders, for a process that is about to end itself.
pub(crate) fn remove_all() {
    let mut folders = folders();
    while let Some(folder) = folders.pop_first() {
        remove(&folder);
    }
}

/// Removes the files and folders whose names begin so.
pub fn remove_starting_with(place: &Path, prefixes: &[&str]) {
    starting_with(place, prefixes).for_each(|path| remove(&path));
}

fn starting_with(place: &Path, prefixes: &[&str]) -> impl Iterator<Item = PathBuf> {
    entries_in(place).filter_map(|entry| {
        let name = entry.file_name();
        let name = name.to_string_lossy();
        let wanted = prefixes.iter().any(|prefix| name.starts_with(prefix));
        wanted.then(|| entry.path())
    })
}

/// Removes a folder or a file, if it can; one that stays only takes up room. A process that has just been killed may
/// still write there for a moment, or hold a file open.
fn remove(path: &Path) {
    const TRIES: u32 = 10;
    for _ in 0..TRIES {
        let removed = fs::remove_dir_all(path).or_else(|_| fs::remove_file(path));
        if removed.is_ok() || !path.exists() {
            break;
        }
        sleep(Duration::from_millis(10));
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    #[test]
    fn folders_of_killed_commands_go_and_others_stay() {
        let place = tempfile::tempdir().unwrap();
        let folder = |name: &str| {
            let folder = place.path().join(name);
            fs::create_dir(&folder).unwrap();
            folder
        };
        let used = folder("fmu-run-used");
        let held = locked(&used.join(LOCK)).unwrap();
        let killed = folder("fmu-run-killed");
        drop(locked(&killed.join(LOCK)).unwrap());
        let [begun, other] = ["fmu-run-begun", "other"].map(folder);
        remove_abandoned(place.path());
        assert!(!killed.exists() && [&used, &begun, &other].iter().all(|folder| folder.exists()));
        drop(held);
        remove_abandoned(place.path());
        assert!(!used.exists() && begun.exists());
    }

    /// Folders of ended commands get their names again at once: nobody may remove those of others.
    #[test]
    fn a_folder_is_removed_by_its_owner_alone() {
        let place = tempfile::tempdir().unwrap();
        std::thread::scope(|scope| {
            for _ in 0..4 {
                scope.spawn(|| {
                    for _ in 0..200 {
                        remove_abandoned(place.path());
                        let scratch = Scratch::within(place.path()).unwrap();
                        let file = scratch.path().join("file");
                        fs::write(&file, "x").unwrap();
                        std::thread::yield_now();
                        assert!(file.exists());
                    }
                });
            }
        });
        assert_eq!(fs::read_dir(place.path()).unwrap().count(), 0);
    }
}
