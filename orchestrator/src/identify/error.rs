//! Why a study cannot be used for identification.

use crate::study::StudyError;
use crate::table::TableError;

/// Why a study cannot be used for identification.
#[derive(Debug, thiserror::Error)]
pub enum BindError {
    /// The study does not fit.
    #[error(transparent)]
    Study(#[from] StudyError),
    /// The table does not fit.
    #[error(transparent)]
    Table(#[from] TableError),
}
