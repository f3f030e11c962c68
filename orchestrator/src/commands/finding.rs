//! What a command has found out about a study: into its folder, onto its page, to the terminal.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use serde::Serialize;

use super::{CommandError, output};
use crate::analysis::from_results;
use crate::analysis::table::PointTable;
use crate::report::Report;
use crate::results::origin::Origin;
use crate::results::{ResultsError, Summary, write_atomically};
use crate::study::Study;

/// Where a study's results lie unless the user says otherwise.
pub(super) fn folder_of(study: &Path) -> PathBuf {
    Path::new("results").join(study.file_stem().unwrap_or("study".as_ref()))
}

/// The points of a finished study, for an analysis of `study`.
pub(super) fn points_of(
    folder: &Path,
    study: &Path,
) -> Result<(Summary, PointTable), CommandError> {
    let (summary, table) = from_results::read(folder)?;
    if Study::read(study)?.digest() != summary.provenance.study_sha256 {
        return Err(CommandError::Option {
            option: "from",
            message: format!(
                "the points in {} are not of {} as it is now; verify it again, or name the folder \
                 of its points",
                folder.display(),
                study.display()
            ),
        });
    }
    Ok((summary, table))
}

/// A finding with what it belongs to.
#[derive(Serialize)]
struct Told<'a, T> {
    origin: &'a Origin,
    #[serde(flatten)]
    finding: &'a T,
}

/// Writes a finding; a finished study in the same folder shows it on its page, where it belongs to
/// that study.
pub(super) fn tell(
    finding: &impl Serialize,
    origin: &Origin,
    text: &str,
    folder: &Path,
    file: &str,
) -> Result<ExitCode, CommandError> {
    std::fs::create_dir_all(folder).map_err(ResultsError::io(folder))?;
    write_atomically(&folder.join(file), |out| {
        serde_json::to_writer_pretty(&mut *out, &Told { origin, finding })?;
        writeln!(out)
    })?;
    if folder.join("summary.json").exists() {
        Report::from_folder(folder)?.write(folder)?;
        if !origin.fits(&from_results::read(folder)?.0) {
            let page = folder.join("report.html");
            eprintln!(
                "note: {} tells of another study or its earlier text, so it does not show this",
                page.display()
            );
        }
    }
    output::print(&format!("{text}\nresults in {}\n", folder.display()));
    Ok(ExitCode::SUCCESS)
}
