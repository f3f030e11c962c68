//! Files that are either as before or complete, whatever happens while they are written.

use std::{
    io::{self, Write},
    path::Path,
};

use number_tables::{csv_file, files::FileError};
use serde::Serialize;
use tempfile::NamedTempFile;

use fmu_points::tell::visible;

/// Makes the folder for results, where it is not there.
///
/// # Errors
/// When the system says no.
pub fn make_folder(path: &Path) -> Result<(), FileError> {
    std::fs::create_dir_all(path).map_err(|error| match error.kind() {
        io::ErrorKind::NotFound => FileError::new(path, "no folder can be made here; choose another --output"),
        _ => FileError::read(path, error),
    })
}

/// Writes a file all at once: it is either as before or complete.
///
/// # Errors
/// When the system says no.
pub fn write_atomically(path: &Path, write: impl FnOnce(&mut dyn Write) -> io::Result<()>) -> Result<(), FileError> {
    let folder = path.parent().unwrap_or(Path::new("."));
    let attempt = || {
        let mut file = draft(folder)?;
        let mut buffered = io::BufWriter::new(&mut file);
        write(&mut buffered)?;
        buffered.flush()?;
        drop(buffered);
        Ok(file)
    };
    let file = attempt().map_err(|error| FileError::read(path, error))?;
    keep(file, path)
}

/// Writes a text, all at once.
///
/// # Errors
/// When the system says no.
pub fn write_text(path: &Path, text: impl AsRef<[u8]>) -> Result<(), FileError> {
    write_atomically(path, |out| out.write_all(text.as_ref()))
}

/// Writes a csv table, all at once: its head, and the rows that `rows` adds.
///
/// # Errors
/// When the system says no.
pub fn write_table<T: AsRef<str>>(
    path: &Path,
    head: impl IntoIterator<Item = T>,
    rows: impl FnOnce(&mut csv::Writer<&mut dyn Write>) -> io::Result<()>,
) -> Result<(), FileError> {
    write_atomically(path, |out| {
        let mut table = csv::Writer::from_writer(out);
        table.write_record(head.into_iter().map(|text| csv_file::cell(text.as_ref()).into_owned()))?;
        rows(&mut table)?;
        table.flush()
    })
}

/// Writes a value as JSON, all at once, with hidden characters as `\u202e`.
///
/// # Errors
/// When the system says no.
pub fn write_json(path: &Path, value: &impl Serialize) -> Result<(), FileError> {
    write_atomically(path, |out| {
        let text = serde_json::to_string_pretty(value)?;
        writeln!(out, "{}", visible(&text))
    })
}

/// The names of files that are being written begin so.
pub const DRAFT: &str = ".writing-";

/// A file in a folder that [`keep`] gives its name when it is complete. It may be read by whom the user's umask lets read,
/// as any other file; temporary files are private otherwise.
///
/// # Errors
/// When the system says no.
pub fn draft(folder: &Path) -> io::Result<NamedTempFile> {
    let mut builder = tempfile::Builder::new();
    builder.prefix(DRAFT);
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    builder.tempfile_in(folder)
}

/// Gives a finished file its name. What has that name is replaced: a link, too, and not the file that it leads to.
///
/// # Errors
/// When the system says no.
pub fn keep(file: NamedTempFile, path: &Path) -> Result<(), FileError> {
    file.persist(path).map(drop).map_err(|error| FileError::read(path, error.error))
}
