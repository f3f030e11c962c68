//! The files of a study: the journal while it runs, `points.csv` and `summary.json` when
//! it is done.
//!
//! The final files are a function of the study, the FMU and the journal's content alone, so they
//! are the same, byte for byte, however the points were computed; only [`Summary::run`] and [`Summary::conduct`] tell how that
//! was, and a verdict by a rule knows of those that were drawn before ([`Looked`]).

pub mod asides;
pub mod choice;
pub mod concerns;
mod failed;
pub mod finished;
pub mod header;
pub mod improvement;
pub mod journal;
pub mod lines;
pub mod lock;
pub mod looked;
pub mod note;
pub mod origin;
pub mod parquet;
pub mod points;
mod probable;
mod resampled;
pub mod settled;
pub mod summary;
pub mod survey;
pub mod table;
pub mod tally;
pub mod traceability;
pub mod validity;
pub mod words;

use std::io;
use std::path::Path;

use serde::Serialize;
use tempfile::NamedTempFile;

use crate::error::Error;
use fmu_points::failure::Failure;
use fmu_points::tell::visible;

pub use header::Header;
pub use journal::Journal;
pub use looked::Looked;
pub use settled::MOST_EXTRA_RUNS;
pub use summary::Summary;

/// A point's values of the criteria, in the study's units, or why there are none.
pub type Outcome = Result<Vec<f64>, Failure>;

/// A point's parameters, and its values of the criteria where it has any.
type Row = (Vec<f64>, Option<Vec<f64>>);

/// Makes the folder for results, where it is not there.
///
/// # Errors
/// When the system says no.
pub fn make_folder(path: &Path) -> Result<(), Error> {
    std::fs::create_dir_all(path).map_err(|error| match error.kind() {
        io::ErrorKind::NotFound => {
            Error::content(path, "no folder can be made here; choose another --output")
        }
        _ => Error::io(path)(error),
    })
}

/// Writes a file all at once: it is either as before or complete.
///
/// # Errors
/// When the system says no.
pub fn write_atomically(
    path: &Path,
    write: impl FnOnce(&mut dyn io::Write) -> io::Result<()>,
) -> Result<(), Error> {
    let folder = path.parent().unwrap_or(Path::new("."));
    let attempt = || {
        let mut file = draft(folder)?;
        let mut buffered = io::BufWriter::new(&mut file);
        write(&mut buffered)?;
        io::Write::flush(&mut buffered)?;
        drop(buffered);
        Ok(file)
    };
    keep(attempt().map_err(Error::io(path))?, path)
}

/// Writes a value as JSON, all at once, with hidden characters as `\u202e`.
///
/// # Errors
/// When the system says no.
pub fn write_json(path: &Path, value: &impl Serialize) -> Result<(), Error> {
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
pub fn keep(file: NamedTempFile, path: &Path) -> Result<(), Error> {
    file.persist(path)
        .map(drop)
        .map_err(|error| Error::io(path)(error.error))
}
