//! Faults of a recording and its settings.

use std::path::PathBuf;

use thiserror::Error;

use crate::table::csv_file::reason;
use rig_signals::signal::SignalError;

/// Why a recording cannot be used.
#[derive(Debug, Error)]
pub enum SettingsError {
    /// A file cannot be read.
    #[error("{path}: {}", crate::files::reason(path, .source))]
    Io {
        /// The file.
        path: PathBuf,
        /// The operating system's message.
        source: std::io::Error,
    },
    /// The settings are no TOML, or not these settings.
    #[error("{path}: {message}")]
    Toml {
        /// The file.
        path: PathBuf,
        /// The problem, with line and column.
        message: String,
    },
    /// The recording is no table.
    #[error("{path}: {}", reason(path, .source))]
    Csv {
        /// The file.
        path: PathBuf,
        /// The problem.
        source: csv::Error,
    },
    /// A column, a unit or a number does not fit.
    #[error("{path}: {message}")]
    Content {
        /// The file.
        path: PathBuf,
        /// The problem.
        message: String,
    },
    /// The signals cannot be used.
    #[error("{path}: {source}")]
    Signal {
        /// The recording.
        path: PathBuf,
        /// The problem.
        source: SignalError,
    },
}
