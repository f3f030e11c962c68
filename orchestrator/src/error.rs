//! Why a command cannot do what was asked for.

use thiserror::Error;

use crate::files::unusable;
use crate::pipeline::Halt;
use crate::recording::SettingsError;
use crate::results::ResultsError;
use crate::session::SessionError;
use crate::study::StudyError;
use crate::study::ssv::SsvError;
use crate::table::TableError;
use fmu_import::FmuError;
use fmu_points::RunError;
use fmu_points::failure::Failure;

/// Why a command cannot do what was asked for.
#[derive(Debug, Error)]
pub enum CommandError {
    /// The FMU cannot be used.
    #[error("{}", unusable(.0))]
    Fmu(#[from] FmuError),
    /// The study cannot be used.
    #[error(transparent)]
    Study(#[from] StudyError),
    /// A parameter set cannot be used.
    #[error(transparent)]
    Set(#[from] SsvError),
    /// A table cannot be used.
    #[error(transparent)]
    Table(#[from] TableError),
    /// The results cannot be written or read.
    #[error(transparent)]
    Results(#[from] ResultsError),
    /// A recording cannot be used.
    #[error(transparent)]
    Recording(#[from] SettingsError),
    /// The report cannot be written.
    #[error(transparent)]
    Report(#[from] ReportError),
    /// The points cannot be run.
    #[error(transparent)]
    Engine(#[from] RunError),
    /// The study cannot be run.
    #[error(transparent)]
    Session(#[from] SessionError),
    /// A single simulation failed.
    #[error("the simulation failed: {0}")]
    Simulation(#[from] Failure),
    /// The FMU refused a step of a size that it has not suggested.
    #[error(
        "the simulation failed: {failure}: the step is {step} s, as the FMU suggests none; set another by --step"
    )]
    Step {
        /// The FMU's remarks.
        failure: Failure,
        /// The step, s.
        step: f64,
    },
    /// A search found nothing.
    #[error("the search failed: {0}")]
    Search(String),
    /// Not every point has an outcome.
    #[error(transparent)]
    Halted(#[from] Halt),
    /// Shards cannot be joined.
    #[error("{0}")]
    Shards(String),
    /// An option's value cannot be used.
    #[error("--{option}: {message}")]
    Option {
        /// The option.
        option: &'static str,
        /// The problem.
        message: String,
    },
}

impl CommandError {
    /// The value of an option cannot be used.
    pub fn option(option: &'static str, message: impl Into<String>) -> Self {
        Self::Option {
            option,
            message: message.into(),
        }
    }
}

/// Why a report could not be written.
#[derive(Debug, Error)]
pub enum ReportError {
    /// There are no results to report, or a file could not be written.
    #[error(transparent)]
    Results(#[from] ResultsError),
    /// The page could not be put together.
    #[error("cannot put the report together: {0}")]
    Page(#[from] minijinja::Error),
    /// A plot could not be turned into pixels.
    #[error("cannot make PNG files: {0}")]
    Png(String),
    /// The embedded data could not be put together.
    #[error("cannot embed the points in the report: {0}")]
    Data(#[from] serde_json::Error),
}
