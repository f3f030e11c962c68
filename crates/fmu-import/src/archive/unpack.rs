//! Copies what a simulation needs out of an archive or a folder, none of which is trusted.

use std::{
    fs::{self, File},
    io::{self, BufWriter, Read, Write},
    path::{Path, PathBuf},
};

use zip::ZipArchive;

use super::{ArchiveError, MAX_ENTRIES, MAX_UNPACKED, open};

/// Whether a simulation on this platform may need the entry.
fn needed(name: &Path, platform: &str) -> bool {
    let mut parts = name.components().map(|part| part.as_os_str().to_string_lossy());
    match parts.next().as_deref() {
        Some("binaries") => parts.next().is_some_and(|part| part == platform),
        Some("documentation" | "sources") => false,
        _ => true,
    }
}

/// The amount that has been copied from a folder: links may lead around in circles, and to what has no end.
#[derive(Default)]
pub struct Copy {
    entries: usize,
    bytes: u64,
}

impl Copy {
    /// Copies what a simulation on this platform may need.
    pub fn needed(&mut self, from: &Path, platform: &str, into: &Path) -> Result<(), ArchiveError> {
        for entry in fs::read_dir(from)? {
            let entry = entry?;
            let name = PathBuf::from(entry.file_name());
            if name == Path::new("binaries") {
                let name = name.join(platform);
                self.all(&from.join(&name), &into.join(&name))?;
            } else if needed(&name, platform) {
                self.all(&entry.path(), &into.join(name))?;
            }
        }
        Ok(())
    }

    /// Copies a file, or a folder with all that is in it.
    fn all(&mut self, from: &Path, into: &Path) -> Result<(), ArchiveError> {
        self.entries += 1;
        if self.entries > MAX_ENTRIES {
            return Err(ArchiveError::TooLarge);
        }
        if from.is_dir() {
            fs::create_dir_all(into)?;
            for entry in fs::read_dir(from)? {
                let entry = entry?;
                self.all(&entry.path(), &into.join(entry.file_name()))?;
            }
        } else {
            self.bytes += open(from)?.metadata()?.len();
            if self.bytes > MAX_UNPACKED {
                return Err(ArchiveError::TooLarge);
            }
            fs::copy(from, into)?;
        }
        Ok(())
    }
}

/// Unpacks what a simulation on this platform may need.
pub fn unpack(zip: &mut ZipArchive<File>, platform: &str, target: &Path) -> Result<(), ArchiveError> {
    let mut room = MAX_UNPACKED;
    // Known beforehand, unless the archive lies.
    if zip.decompressed_size().is_some_and(|size| size > MAX_UNPACKED.into()) {
        return Err(ArchiveError::TooLarge);
    }
    for index in 0..zip.len() {
        let label = zip.name_for_index(index).and_then(Result::ok).unwrap_or_default().into_owned();
        let wrong = |error: io::Error| ArchiveError::of_entry(&label, error.into());
        let mut entry = zip.by_index(index).map_err(|error| ArchiveError::of_entry(&label, error))?;
        let name = entry.enclosed_name().filter(|_| !entry.is_symlink());
        let Some(name) = name else {
            return Err(ArchiveError::Unsafe(String::from_utf8_lossy(entry.name_raw()).into()));
        };
        if !needed(&name, platform) {
            continue;
        }
        let path = target.join(name);
        if entry.is_dir() {
            fs::create_dir_all(&path).map_err(wrong)?;
            continue;
        }
        if let Some(parent) = path.parent() {
            fs::create_dir_all(parent).map_err(wrong)?;
        }
        // The size in the directory may lie: count what really comes out.
        let mut file = BufWriter::with_capacity(1 << 17, File::create(&path).map_err(wrong)?);
        let written = io::copy(&mut entry.by_ref().take(room + 1), &mut file).map_err(wrong)?;
        file.flush()?;
        room = room.checked_sub(written).ok_or(ArchiveError::TooLarge)?;
    }
    Ok(())
}
