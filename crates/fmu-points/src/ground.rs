//! The unpacked FMU under the feet of all processes, and what becomes of points when one of them changes it.
//!
//! Points share one unpacked folder, since a copy each would cost more than a short point. An FMU may write there,
//! and then the next point would read what the one before has left. So the folder is watched, and an answer counts only
//! while nothing has changed: from the first change on each point has a folder of its own.

use std::{
    path::{Path, PathBuf},
    sync::Mutex,
};

use tempfile::TempDir;

use fmu_import::{FmuError, Package, isolation::watch::Watch, locked};

/// The FMU's unpacked files.
#[derive(Debug)]
pub struct Ground {
    /// The folder that points share.
    pub shared: PathBuf,
    /// The FMU's path as the user gave it.
    pub name: PathBuf,
    /// For further folders.
    pub scratch: PathBuf,
    state: Mutex<State>,
}

#[derive(Debug)]
struct State {
    watch: Watch,
    /// The first change, once there is one.
    changed: Option<String>,
    /// The FMU once more, when it has to be unpacked again.
    package: Option<Package>,
}

impl Ground {
    pub fn new(shared: PathBuf, name: &Path, scratch: &Path) -> Self {
        let state = Mutex::new(State { watch: Watch::on(&shared), changed: None, package: None });
        Self { shared, name: name.to_owned(), scratch: scratch.to_owned(), state }
    }

    /// The first change that the FMU has made in the folder that points share; `None` while all is as it was unpacked.
    /// Whatever a point has changed before its answer came is known here.
    pub fn changed(&self) -> Option<String> {
        // One at a time: who finds no further event must know of those that another has just taken.
        let mut state = locked(&self.state);
        if state.changed.is_none() {
            let place = state.watch.changed().map(|path| match path.to_str() {
                Some("") => ".".to_owned(),
                _ => path.display().to_string(),
            });
            state.changed = place;
        }
        state.changed.clone()
    }

    /// Takes it for known that the FMU changes this file.
    pub fn know(&self, changed: &str) {
        let mut state = locked(&self.state);
        state.changed.get_or_insert_with(|| changed.to_owned());
    }

    /// A copy of the files that points share: an FMU whose results depend on where or when it was unpacked shows it there.
    pub fn copy(&self) -> Option<TempDir> {
        Package::open(&self.shared).ok()?.unpack_anew(&self.scratch).ok()
    }

    /// A new folder with the FMU as it came, for one process.
    pub fn folder(&self) -> Result<TempDir, FmuError> {
        let mut state = locked(&self.state);
        let package = match &mut state.package {
            Some(package) => package,
            none => none.insert(Package::open(&self.name)?),
        };
        package.unpack_anew(&self.scratch)
    }
}
