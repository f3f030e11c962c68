//! Why a folder's journal cannot be written or read, or points cannot be run, as the user reads it.

use std::{
    io,
    path::{Path, PathBuf},
};

use fmu_points::{RunError, scratch::ScratchError};
use number_tables::files::FileError;

/// What is done, or why it cannot be.
pub type Result<T = (), E = Error> = std::result::Result<T, E>;

/// Why a folder's journal cannot be written or read, or points cannot be run.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// A file cannot be read or written, or says what cannot be used.
    #[error(transparent)]
    File(#[from] FileError),
    /// There is no room for the files of a run.
    #[error(transparent)]
    Scratch(#[from] ScratchError),
    /// There is a journal in the folder already.
    #[error(
        "{0} holds a study that has begun already; continue it with --resume, replace it with --force, or choose another \
         --output"
    )]
    Begun(PathBuf),
    /// There is nothing to resume or to read in the folder.
    #[error("{0} holds no study; run `verify` into it first")]
    Missing(PathBuf),
    /// The folder, or its journal, is that of another run.
    #[error("{0}")]
    Refused(String),
    /// The points cannot be run.
    #[error("{0}{way}", way = going_on(.0))]
    Run(#[from] RunError),
    /// Ctrl-C.
    #[error("interrupted: {} done; --resume goes on", share(*.done, *.of))]
    Interrupted {
        /// Points that are done.
        done: u64,
        /// How many there are, where that is known.
        of: Option<u64>,
    },
}

impl Error {
    /// What is wrong with a file's content.
    pub(crate) fn content(path: &Path, message: impl Into<String>) -> Self {
        FileError::new(path, message).into()
    }

    /// Turns an error of the system into one that names the file.
    pub(crate) fn io(path: &Path) -> impl FnOnce(io::Error) -> Self {
        move |source| FileError::system(path, source).into()
    }
}

/// How to go on after an error of the workers.
pub fn going_on(error: &RunError) -> &'static str {
    if matches!(error, RunError::NoWorker(_)) { "; --resume goes on" } else { "" }
}

fn share(done: u64, of: Option<u64>) -> String {
    match of {
        Some(of) => format!("{done} of {of} points are"),
        None => format!("{done} points are"),
    }
}
