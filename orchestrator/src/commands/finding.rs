//! What a command has found out about a study: into its folder, onto its page, to the terminal.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use serde::Serialize;

use super::{CommandError, output};
use crate::report::Report;
use crate::results::{ResultsError, write_atomically};

/// Where a study's results lie unless the user says otherwise.
pub(super) fn folder_of(study: &Path) -> PathBuf {
    Path::new("results").join(study.file_stem().unwrap_or("study".as_ref()))
}

/// Writes a finding; a finished study in the same folder shows it on its page.
pub(super) fn tell(
    finding: &impl Serialize,
    text: &str,
    folder: &Path,
    file: &str,
) -> Result<ExitCode, CommandError> {
    std::fs::create_dir_all(folder).map_err(ResultsError::io(folder))?;
    write_atomically(&folder.join(file), |out| {
        serde_json::to_writer_pretty(&mut *out, finding)?;
        writeln!(out)
    })?;
    if folder.join("summary.json").exists() {
        Report::from_folder(folder)?.write(folder)?;
    }
    output::print(&format!("{text}\nresults in {}\n", folder.display()));
    Ok(ExitCode::SUCCESS)
}
