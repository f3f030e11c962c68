//! A copy of an FMU with further files: what was there stays as it is, byte for byte.

use std::io::{Seek, Write};

use zip::write::{SimpleFileOptions, ZipWriter};

use super::{Archive, ArchiveError};

impl Archive {
    /// Writes a copy without the entries that `leave_out`, and with these files.
    pub fn copy_with(
        &mut self,
        into: impl Write + Seek,
        leave_out: impl Fn(&str) -> bool,
        files: &[(String, Vec<u8>)],
    ) -> Result<(), ArchiveError> {
        let zip = match self {
            Self::Folder(path) => return Err(ArchiveError::Folder(path.clone())),
            Self::Zip { twice, .. } if !twice.is_empty() => {
                return Err(ArchiveError::Twice(twice[0].clone()));
            }
            Self::Zip { zip, .. } => zip,
        };
        let mut copy = ZipWriter::new(into);
        let whole = |error| ArchiveError::of_entry("the archive", error);
        copy.set_raw_comment(zip.comment().into()).map_err(whole)?;
        for index in 0..zip.len() {
            let entry = zip.by_index_raw(index).map_err(whole)?;
            let name = entry.name().map(|name| name.into_owned()).unwrap_or_default();
            if leave_out(&name) || files.iter().any(|(file, _)| *file == name) {
                continue;
            }
            copy.raw_copy_file(entry).map_err(|error| ArchiveError::of_entry(&name, error))?;
        }
        for (name, content) in files {
            let wrong = |error| ArchiveError::of_entry(name, error);
            // The same files make the same archive: no time of the day.
            copy.start_file(name.as_str(), SimpleFileOptions::default()).map_err(wrong)?;
            copy.write_all(content)?;
        }
        copy.finish().map_err(whole)?;
        Ok(())
    }
}
