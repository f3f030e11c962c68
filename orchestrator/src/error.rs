//! Why something cannot be done, as the user reads it.

use std::{
    io,
    path::{Path, PathBuf},
};

use fmu_import::FmuError;
use fmu_points::{RunError, failure::Failure, scratch::ScratchError};
use number_tables::files::FileError;
use point_journal::going_on;
use study::{OpenError, unusable};

/// What is done, or why it cannot be.
pub type Result<T = (), E = Error> = std::result::Result<T, E>;

/// Why something cannot be done.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The FMU cannot be used.
    #[error("{}", unusable(.0))]
    Fmu(#[from] FmuError),
    /// A file cannot be read or written, or says what cannot be used.
    #[error(transparent)]
    File(#[from] FileError),
    /// The folder's journal cannot be used, another run has the folder, or not all points could be run.
    #[error(transparent)]
    Journal(#[from] point_journal::Error),
    /// There is no room for the files of a run.
    #[error(transparent)]
    Scratch(#[from] ScratchError),
    /// There is nothing to resume or to read in the folder.
    #[error("{0} holds no study; run `verify` into it first")]
    Missing(PathBuf),
    /// Points are missing in the folder.
    #[error("{path}: {missing} of {points} points are not computed yet; continue with --resume")]
    Incomplete {
        /// The folder.
        path: PathBuf,
        /// How many are missing.
        missing: u64,
        /// How many there should be.
        points: u64,
    },
    /// The points cannot be run.
    #[error("{0}{way}", way = going_on(.0))]
    Engine(#[from] RunError),
    /// A single simulation failed.
    #[error("the simulation failed: {0}")]
    Simulation(#[from] Failure),
    /// The FMU refused a step of a size that it has not suggested.
    #[error("the simulation failed: {failure}: the step is {step} s, as the FMU suggests none; set another by --step")]
    Step {
        /// The FMU's remarks.
        failure: Failure,
        /// The step, s.
        step: f64,
    },
    /// A search found nothing.
    #[error("the search failed: {0}")]
    Search(String),
    /// The page could not be put together.
    #[error("cannot put the report together: {0}")]
    Page(#[from] minijinja::Error),
    /// The data in the page could not be put together.
    #[error("cannot embed the points in the report: {0}")]
    Data(#[from] serde_json::Error),
    /// An option's value cannot be used.
    #[error("--{option}: {message}")]
    Option {
        /// The option.
        option: &'static str,
        /// The problem.
        message: String,
    },
    /// A run would replace what is there.
    #[error("{what}; {remedy}")]
    Taken {
        /// What is there.
        what: String,
        /// What to do.
        remedy: &'static str,
    },
    /// The request does not fit to what is there.
    #[error("{0}")]
    Refused(String),
}

impl Error {
    /// The value of an option cannot be used.
    pub fn option(option: &'static str, message: impl Into<String>) -> Self {
        Self::Option { option, message: message.into() }
    }

    /// What is wrong with a file's content.
    pub fn content(path: &Path, message: impl ToString) -> Self {
        FileError::new(path, message.to_string()).into()
    }

    /// Turns an error of the system into one that names the file.
    pub fn io(path: &Path) -> impl FnOnce(io::Error) -> Self {
        let path = path.to_owned();
        move |source| FileError::system(&path, source).into()
    }
}

impl From<OpenError> for Error {
    fn from(error: OpenError) -> Self {
        match error {
            OpenError::Fmu(error) => error.into(),
            OpenError::File(error) => error.into(),
        }
    }
}
