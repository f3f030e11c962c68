//! Files that are either as before or complete, however the program ends; not after a power failure, since nothing here waits for the
//! disk. Results follow from the journal, which does.

use std::{
    io::{self, Write},
    path::Path,
};

use number_tables::{
    csv_file,
    files::{FileError, Result},
};
use serde::Serialize;
use tempfile::NamedTempFile;

use fmu_points::tell::visible;

/// Makes a folder, where it is not there.
///
/// # Errors
/// When it cannot be made; those around it that could are there.
pub fn make_folder(path: &Path) -> Result {
    make(path, "no folder can be made here")
}

/// The same of the folder that `--output` names, which the error names, too.
///
/// # Errors
/// As [`make_folder`].
pub fn make_output(path: &Path) -> Result {
    make(path, "no folder can be made here; choose another --output")
}

fn make(path: &Path, none_here: &str) -> Result {
    std::fs::create_dir_all(path).map_err(|error| match error.kind() {
        io::ErrorKind::NotFound => FileError::new(path, none_here),
        _ => FileError::system(path, error),
    })
}

/// How the names of files begin that are being written: who takes a folder of results removes those that a killed run has left.
pub const DRAFT: &str = ".writing-";

/// Writes a file all at once: it is either as before or complete.
///
/// # Errors
/// When it cannot be written; it is as before then.
pub fn write_atomically(path: &Path, write: impl FnOnce(&mut dyn Write) -> io::Result<()>) -> Result {
    let attempt = || {
        // The folder of a bare name is empty, which is the working directory.
        let mut file = draft(path.parent().unwrap_or(path))?;
        let mut buffered = io::BufWriter::new(&mut file);
        write(&mut buffered)?;
        buffered.flush()?;
        drop(buffered);
        Ok(file)
    };
    let file = attempt().map_err(|error| FileError::system(path, error))?;
    keep(file, path)
}

/// Writes a text, all at once.
///
/// # Errors
/// As [`write_atomically`].
pub fn write_text(path: &Path, text: impl AsRef<[u8]>) -> Result {
    write_atomically(path, |out| out.write_all(text.as_ref()))
}

/// Writes a csv table, all at once: its head, and the rows that `rows` adds.
///
/// # Errors
/// As [`write_atomically`].
pub fn write_table<T: AsRef<str>>(
    path: &Path,
    head: impl IntoIterator<Item = T>,
    rows: impl FnOnce(&mut csv::Writer<&mut dyn Write>) -> io::Result<()>,
) -> Result {
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
/// As [`write_atomically`], and when the value is none of JSON.
pub fn write_json(path: &Path, value: &impl Serialize) -> Result {
    write_atomically(path, |out| {
        let text = serde_json::to_string_pretty(value)?;
        writeln!(out, "{}", visible(&text))
    })
}

/// A file in a folder that [`keep`] gives its name when it is complete. It may be read by whom the user's umask lets read,
/// as any other file; temporary files are private otherwise.
///
/// # Errors
/// When the folder takes no file.
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
/// When that cannot be replaced; the finished file is gone then.
pub fn keep(file: NamedTempFile, path: &Path) -> Result {
    file.persist(path).map(drop).map_err(|error| FileError::system(path, error.error))
}
