//! The lock of a folder of results: one run at a time writes there.
//!
//! It is a lock of the operating system on the file `run.lock`, so that it ends with the process that holds it, however
//! that ends. The file stays: to remove it would let two runs lock two files of the same name.

use std::{
    fs::{File, OpenOptions, TryLockError},
    io::ErrorKind,
    path::Path,
    thread::sleep,
    time::{Duration, Instant},
};

use crate::{Error, Result, files::make_output};

const FILE: &str = "run.lock";
/// How long to wait for the lock. When a run is killed while it starts a worker, the new process holds a copy of the lock
/// until it becomes the worker's program.
const PATIENCE: Duration = Duration::from_secs(2);

/// Holds a folder of results for one run.
pub struct Lock(#[allow(dead_code)] File);

impl Lock {
    /// Takes a folder, which is made if it is not there.
    ///
    /// # Errors
    /// When another run has it, and when the system says no.
    pub fn take(folder: &Path) -> Result<Self> {
        make_output(folder)?;
        let path = folder.join(FILE);
        // A network file system locks only files that are open for writing.
        let file = OpenOptions::new().write(true).create(true).truncate(false).open(&path).map_err(Error::io(&path))?;
        let begun = Instant::now();
        loop {
            match file.try_lock() {
                Ok(()) => return Ok(Self(file)),
                Err(TryLockError::WouldBlock) if begun.elapsed() < PATIENCE => {
                    sleep(Duration::from_millis(10));
                }
                Err(TryLockError::WouldBlock) => {
                    return Err(Error::Refused(format!(
                        "{}: another run is writing its results here; wait for it, or choose another --output",
                        folder.display()
                    )));
                }
                Err(TryLockError::Error(error)) if error.kind() == ErrorKind::Unsupported => {
                    fmu_points::tell::line!(
                        "note: the file system of {} has no locks; see that no other run writes there",
                        folder.display()
                    );
                    return Ok(Self(file));
                }
                Err(TryLockError::Error(error)) => return Err(Error::io(&path)(error)),
            }
        }
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    #[test]
    fn a_lock_that_is_released_soon_is_waited_for() {
        let folder = tempfile::tempdir().unwrap();
        let first = Lock::take(folder.path()).unwrap();
        let busy = Lock::take(folder.path());
        assert!(matches!(busy, Err(Error::Refused(_))));
        let released = std::thread::spawn(move || {
            sleep(Duration::from_millis(100));
            drop(first);
        });
        assert!(Lock::take(folder.path()).is_ok());
        released.join().unwrap();
    }
}
