//! The folders that a worker's points have for themselves.

use std::{
    collections::BTreeSet,
    fs, io,
    path::{Path, PathBuf},
    sync::Mutex,
};

use crate::scratch::ScratchError;
use fmu_import::locked;

/// A working directory and a folder for temporary files, both empty for each point. Their paths are the same in every run.
#[derive(Debug)]
pub struct Room(PathBuf);

/// The rooms that are in use.
static TAKEN: Mutex<BTreeSet<PathBuf>> = Mutex::new(BTreeSet::new());

impl Room {
    /// The first room within a folder that nobody has.
    pub fn take(within: &Path) -> Result<Self, ScratchError> {
        let within = std::path::absolute(within).map_err(ScratchError::at(within))?;
        let path =
            (1..).map(|number| within.join(format!("room-{number}"))).find(|path| locked(&TAKEN).insert(path.clone()));
        let room = Self(path.expect("numbers do not end"));
        for folder in room.folders() {
            make(&folder).map_err(ScratchError::at(&folder))?;
        }
        Ok(room)
    }

    pub fn work(&self) -> PathBuf {
        self.0.join("work")
    }

    pub fn temporary(&self) -> PathBuf {
        self.0.join("tmp")
    }

    pub fn folders(&self) -> [PathBuf; 2] {
        [self.work(), self.temporary()]
    }
}

impl Drop for Room {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
        locked(&TAKEN).remove(&self.0);
    }
}

/// Makes a folder of a room, and the room. What a room stands in is not made: where it is gone, a signal is ending the run, and
/// nothing may come back.
fn make(folder: &Path) -> io::Result<()> {
    let room = folder.parent();
    for path in room.into_iter().chain([folder]) {
        match fs::create_dir(path) {
            Err(error) if error.kind() == io::ErrorKind::AlreadyExists => {}
            made => made?,
        }
    }
    Ok(())
}

/// Empties a folder, whatever a point has left there. What cannot be removed stays. Where no folder stands any more, or one that
/// nobody may write to, it is made anew: a link leads to what is not the FMU's.
pub fn clear(folder: &Path) -> io::Result<()> {
    let found = fs::symlink_metadata(folder);
    if !found.is_ok_and(|found| found.is_dir() && !found.permissions().readonly()) {
        let _ = remove(folder);
        return make(folder);
    }
    fs::read_dir(folder)?.flatten().for_each(|entry| drop(remove(&entry.path())));
    Ok(())
}

/// Removes a folder with all that is in it, or anything else; of a link, the link alone.
fn remove(path: &Path) -> io::Result<()> {
    fs::remove_dir(path).or_else(|_| fs::remove_file(path)).or_else(|_| fs::remove_dir_all(path))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rooms_are_numbered_from_the_first_free_one() {
        let place = tempfile::tempdir().unwrap();
        let [one, two] = [(); 2].map(|()| Room::take(place.path()).unwrap());
        let first = one.work();
        assert_ne!(first, two.work());
        fs::write(first.join("left"), "x").unwrap();
        fs::create_dir(first.join("folder")).unwrap();
        clear(&first).unwrap();
        assert_eq!(fs::read_dir(&first).unwrap().count(), 0);
        drop(one);
        assert!(!first.exists());
        assert_eq!(Room::take(place.path()).unwrap().work(), first);
        // A point may remove its room; what the room stands in does not come back.
        clear(&first).unwrap();
        assert!(first.is_dir());
        #[cfg(unix)]
        {
            // A point may put a link in its place.
            let other = tempfile::tempdir().unwrap();
            fs::write(other.path().join("kept"), "x").unwrap();
            fs::remove_dir(&first).unwrap();
            std::os::unix::fs::symlink(other.path(), &first).unwrap();
            clear(&first).unwrap();
            assert!(fs::symlink_metadata(&first).unwrap().is_dir() && other.path().join("kept").exists());
        }
        fs::remove_dir_all(place.path()).unwrap();
        assert!(clear(&first).is_err() && !place.path().exists());
    }
}
