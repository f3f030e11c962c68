//! Folders for what is needed while a command runs, such as the unpacked FMU.
//!
//! They are removed when the command ends, also where a signal ends it: an FMU may hold hundreds of megabytes, and
//! nobody else would ever remove them.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::thread::sleep;
use std::time::Duration;

use tempfile::TempDir;

use crate::results::ResultsError;

/// A folder that is removed with this.
#[derive(Debug)]
pub struct Scratch(TempDir);

/// The folders that there are.
static FOLDERS: Mutex<BTreeSet<PathBuf>> = Mutex::new(BTreeSet::new());

fn folders() -> MutexGuard<'static, BTreeSet<PathBuf>> {
    // A set of paths is sound whatever interrupted its last user.
    FOLDERS.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Scratch {
    /// Makes a folder where the system has such folders.
    ///
    /// # Errors
    /// When the system says no.
    pub(super) fn new() -> Result<Self, ResultsError> {
        // A signal that comes between the two finds the folder.
        let mut folders = folders();
        let folder = tempfile::tempdir().map_err(ResultsError::io(&std::env::temp_dir()))?;
        folders.insert(folder.path().to_owned());
        Ok(Self(folder))
    }

    /// Where it is.
    pub fn path(&self) -> &Path {
        self.0.path()
    }
}

impl Drop for Scratch {
    fn drop(&mut self) {
        // A signal that comes in between removes the rest.
        remove(self.path());
        folders().remove(self.path());
    }
}

/// Removes all folders, for a process that is about to end itself.
pub(super) fn remove_all() {
    folders().iter().for_each(|folder| remove(folder));
}

/// A process that has just been killed may still write there for a moment, or hold a file open.
fn remove(folder: &Path) {
    const TRIES: u32 = 10;
    for _ in 0..TRIES {
        if fs::remove_dir_all(folder).is_ok() || !folder.exists() {
            break;
        }
        sleep(Duration::from_millis(5));
    }
}
