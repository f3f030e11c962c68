//! Why the FMU of a study cannot be opened.

use fmu_import::{ArchiveError, FmuError, FmuFault};
use number_tables::files::{FileError, missing};

/// Why an FMU cannot be used, with a remedy.
pub fn unusable(error: &FmuError) -> String {
    match error {
        FmuError { path, fault: FmuFault::Archive(ArchiveError::Missing) } => {
            format!("{}: {}", path.display(), missing(path))
        }
        FmuError { path, fault: FmuFault::Archive(ArchiveError::NotZip) }
            if path.extension().is_some_and(|it| it == "toml") =>
        {
            format!("{}: a study, where an FMU is needed; name the FMU, or run the study by `verify`", path.display())
        }
        FmuError { path, fault: FmuFault::Archive(ArchiveError::System) } => {
            let way = "python -m fmu_orchestrator system";
            format!("{error}: `{way} {} --step 0.001 --output system.fmu` makes one of it", path.display())
        }
        other => other.to_string(),
    }
}

/// Why the FMU of a study cannot be opened.
#[derive(Debug, thiserror::Error)]
pub enum OpenError {
    /// It cannot be used.
    #[error("{}", unusable(.0))]
    Fmu(#[from] FmuError),
    /// The study names a file that is not there.
    #[error(transparent)]
    File(#[from] FileError),
}
