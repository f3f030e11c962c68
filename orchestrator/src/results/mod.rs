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
pub mod words;

use std::io;
use std::path::{Path, PathBuf};

use serde::Serialize;
use tempfile::NamedTempFile;
use thiserror::Error;

use crate::files::reason;
use fmu_points::failure::Failure;
use fmu_points::scratch::ScratchError;
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

/// Why results cannot be written or read.
#[derive(Debug, Error)]
pub enum ResultsError {
    /// The system says no.
    #[error("{path}: {}", reason(path, .source))]
    Io {
        /// The file or folder.
        path: PathBuf,
        /// The operating system's message.
        source: io::Error,
    },
    /// There is a study in the folder already.
    #[error(
        "{0} holds a study that has begun already; continue it with --resume, replace it with --force, or choose another \
         --output"
    )]
    Begun(PathBuf),
    /// Another run is at work in the folder.
    #[error(
        "{0}: another run is writing its results here; wait for it, or choose another --output"
    )]
    Busy(PathBuf),
    /// There is nothing to resume or to read.
    #[error("{0} holds no study; run `verify` into it first")]
    Missing(PathBuf),
    /// The folder holds another study's run, which cannot be resumed.
    #[error(
        "{path} was made with another {what} ({then} then, {now} now); choose another --output, or begin again with --force \
         instead of --resume"
    )]
    Changed {
        /// The folder.
        path: PathBuf,
        /// The setting that differs.
        what: &'static str,
        /// Its value in the earlier run.
        then: String,
        /// Its value now.
        now: String,
    },
    /// The folder holds results of something else.
    #[error(
        "{path} holds results of {what}, {then}; choose another --output, or replace them with --force"
    )]
    Foreign {
        /// The folder.
        path: PathBuf,
        /// The part that is another one.
        what: &'static str,
        /// The file that it was made of.
        then: PathBuf,
    },
    /// The folder holds a file of somebody else that results would replace.
    #[error(
        "{0} was there before any run wrote into this folder, and would be replaced; choose another --output, or replace it \
         with --force"
    )]
    Precious(PathBuf),
    /// The folder of a run is there no more.
    #[error(
        "{0}: this folder, or the journal in it, was removed or moved while points ran; run the command again"
    )]
    Gone(PathBuf),
    /// Points are missing.
    #[error("{path}: {missing} of {points} points are not computed yet; continue with --resume")]
    Incomplete {
        /// The folder.
        path: PathBuf,
        /// How many are missing.
        missing: u64,
        /// How many there should be.
        points: u64,
    },
    /// A file's content is not what this program writes.
    #[error("{path}: {message}")]
    Content {
        /// The file.
        path: PathBuf,
        /// The problem.
        message: String,
    },
}

impl From<ScratchError> for ResultsError {
    fn from(ScratchError { path, source }: ScratchError) -> Self {
        Self::Io { path, source }
    }
}

impl ResultsError {
    /// The fault of a file's content.
    pub fn content(path: &Path, message: impl ToString) -> Self {
        Self::Content {
            path: path.to_owned(),
            message: message.to_string(),
        }
    }

    /// Turns an error of the system into one that names the file.
    pub fn io(path: &Path) -> impl FnOnce(io::Error) -> Self {
        let path = path.to_owned();
        move |source| Self::Io {
            path,
            source: of_the_system(source),
        }
    }
}

/// Makes the folder for results, where it is not there.
///
/// # Errors
/// When the system says no.
pub fn make_folder(path: &Path) -> Result<(), ResultsError> {
    std::fs::create_dir_all(path).map_err(|error| match error.kind() {
        io::ErrorKind::NotFound => {
            ResultsError::content(path, "no folder can be made here; choose another --output")
        }
        _ => ResultsError::io(path)(error),
    })
}

/// The operating system's error inside the csv writer's: its kind decides which remedy we name.
pub fn of_the_system(error: io::Error) -> io::Error {
    match error.downcast::<csv::Error>() {
        Ok(wrapped) if wrapped.is_io_error() => match wrapped.into_kind() {
            csv::ErrorKind::Io(error) => error,
            other => io::Error::other(format!("{other:?}")),
        },
        Ok(wrapped) => io::Error::other(wrapped),
        Err(error) => error,
    }
}

/// Writes a file all at once: it is either as before or complete.
///
/// # Errors
/// When the system says no.
pub fn write_atomically(
    path: &Path,
    write: impl FnOnce(&mut dyn io::Write) -> io::Result<()>,
) -> Result<(), ResultsError> {
    let folder = path.parent().unwrap_or(Path::new("."));
    let attempt = || {
        let mut file = draft(folder)?;
        let mut buffered = io::BufWriter::new(&mut file);
        write(&mut buffered)?;
        io::Write::flush(&mut buffered)?;
        drop(buffered);
        Ok(file)
    };
    keep(attempt().map_err(ResultsError::io(path))?, path)
}

/// Writes a value as JSON, all at once, with hidden characters as `\u202e`.
///
/// # Errors
/// When the system says no.
pub fn write_json(path: &Path, value: &impl Serialize) -> Result<(), ResultsError> {
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
pub fn keep(file: NamedTempFile, path: &Path) -> Result<(), ResultsError> {
    file.persist(path)
        .map(drop)
        .map_err(|error| ResultsError::io(path)(error.error))
}
