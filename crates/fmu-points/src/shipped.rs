//! An FMU that was sent to this machine. All workers here have one file together, which the last one removes.

use std::fs::{self, File, OpenOptions, TryLockError};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::thread::sleep;
use std::time::Duration;

use crate::{scratch, system};

/// The FMU's file, while somebody here uses it.
#[derive(Debug)]
pub(crate) struct Shipped {
    folder: PathBuf,
    /// Shared by all who use the file.
    lock: File,
}

/// The FMU in its folder.
const FILE: &str = "shipped.fmu";

impl Shipped {
    /// The file with this digest; `source` gives its bytes, the last part empty, where nobody here has them yet.
    pub(crate) fn take(digest: &str, source: &mut dyn FnMut() -> io::Result<Vec<u8>>) -> io::Result<Self> {
        const PAUSE: Duration = Duration::from_millis(50);
        let folder = std::env::temp_dir().join(scratch::shared_name(digest));
        let at = |error: io::Error| io::Error::new(error.kind(), format!("{}: {error}", folder.display()));
        #[cfg_attr(not(unix), allow(unused_mut))]
        let mut builder = fs::DirBuilder::new();
        // Nobody else may change what is run here.
        #[cfg(unix)]
        std::os::unix::fs::DirBuilderExt::mode(&mut builder, 0o700);
        loop {
            match builder.create(&folder) {
                Err(error) if error.kind() != io::ErrorKind::AlreadyExists => {
                    return Err(at(error));
                }
                _ => {}
            }
            match fs::symlink_metadata(&folder) {
                // Its last user has just removed it.
                Err(error) if error.kind() == io::ErrorKind::NotFound => continue,
                Ok(known) if !system::is_mine(&known) => {
                    let others = "another user made it, or others may write there; remove it";
                    return Err(at(io::Error::other(others)));
                }
                Err(error) => return Err(at(error)),
                Ok(_) => {}
            }
            let path = folder.join(scratch::LOCK);
            let lock = OpenOptions::new().create(true).append(true).read(true).open(&path);
            let lock = match lock {
                // Or just now.
                Err(error) if error.kind() == io::ErrorKind::NotFound => continue,
                opened => opened.map_err(at)?,
            };
            match lock.try_lock() {
                Ok(()) => {
                    let file = folder.join(FILE);
                    if !file.exists() {
                        receive(&file, source).map_err(at)?;
                    }
                    // Whoever comes in between finds the file.
                    lock.unlock()?;
                }
                Err(TryLockError::WouldBlock) => {}
                Err(TryLockError::Error(error)) => return Err(error),
            }
            if lock.try_lock_shared().is_ok() && folder.join(FILE).exists() {
                return Ok(Self { folder, lock });
            }
            sleep(PAUSE);
        }
    }

    /// Where it is.
    pub(crate) fn path(&self) -> PathBuf {
        self.folder.join(FILE)
    }
}

impl Drop for Shipped {
    fn drop(&mut self) {
        let _ = self.lock.unlock();
        if self.lock.try_lock().is_ok() {
            // What stays is removed with the next worker's end, or by the next command here.
            let _ = fs::remove_dir_all(&self.folder);
        }
    }
}

fn receive(file: &Path, source: &mut dyn FnMut() -> io::Result<Vec<u8>>) -> io::Result<()> {
    let part = file.with_extension("part");
    let received = (|| {
        let mut to = File::create(&part)?;
        loop {
            let bytes = source()?;
            if bytes.is_empty() {
                return fs::rename(&part, file);
            }
            to.write_all(&bytes)?;
        }
    })();
    if received.is_err() {
        // A full disk would stay full.
        let _ = fs::remove_file(part);
    }
    received
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bytes_come_once_and_go_with_the_last_user() {
        let digest = format!("test-of-shipped-{}", std::process::id());
        let mut parts = vec![b"two".to_vec(), b"one ".to_vec()];
        let mut asked = 0;
        let mut source = || {
            asked += 1;
            Ok(parts.pop().unwrap_or_default())
        };
        let first = Shipped::take(&digest, &mut source).unwrap();
        let second = Shipped::take(&digest, &mut source).unwrap();
        assert_eq!(asked, 3);
        assert_eq!(fs::read(second.path()).unwrap(), b"one two");
        drop(first);
        assert!(second.path().exists());
        let path = second.path();
        drop(second);
        assert!(!path.exists() && !path.parent().unwrap().exists());
        // A source that breaks off leaves no file that would be taken for whole.
        let mut broken = || Err(io::Error::other("cut"));
        assert!(Shipped::take(&digest, &mut broken).is_err());
        let folder = path.parent().unwrap();
        assert!(!path.exists());
        fs::remove_dir_all(folder).unwrap();
    }

    /// Such as a disk without room: nobody waits for what will not be.
    #[test]
    fn a_lock_that_cannot_be_made_is_an_error() {
        let digest = format!("test-of-locks-{}", std::process::id());
        let folder = std::env::temp_dir().join(scratch::shared_name(&digest));
        fs::create_dir_all(folder.join(scratch::LOCK)).unwrap();
        assert!(Shipped::take(&digest, &mut || Ok(Vec::new())).is_err());
        fs::remove_dir_all(folder).unwrap();
    }
}
