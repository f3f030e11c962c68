//! Delivers the result of an analysis: to its file, to the page of the study, to the terminal.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use serde::Serialize;

use super::{CommandError, output};
use crate::analysis::from_results;
use crate::files;
use crate::report::Report;
use crate::results::origin::Origin;
use crate::results::{ResultsError, Summary, make_folder, write_json};
use crate::study::Study;
use parameter_regions::table::PointTable;

/// Where a study's results lie unless the user says otherwise.
pub(super) fn folder_of(study: &Path) -> PathBuf {
    Path::new("results").join(study.file_stem().unwrap_or("study".as_ref()))
}

/// The points of a finished study, for an analysis of `study`.
pub(super) fn points_of(
    folder: &Path,
    study: &Study,
) -> Result<(Summary, PointTable), CommandError> {
    let (summary, table) = from_results::read(folder)?;
    belongs(&summary, folder, study)?;
    Ok((summary, table))
}

/// The same with all values that failed points have.
pub(super) fn every_value_of(
    folder: &Path,
    study: &Study,
) -> Result<(Summary, PointTable), CommandError> {
    let (summary, table) = from_results::read_every_value(folder)?;
    belongs(&summary, folder, study)?;
    Ok((summary, table))
}

/// Refuses points of another study.
fn belongs(summary: &Summary, folder: &Path, study: &Study) -> Result<(), CommandError> {
    if study.digest() != summary.provenance.study_sha256 {
        return Err(CommandError::Option {
            option: "from",
            message: format!(
                "the points in {} are not of {} as it is now; verify it again, or name the folder \
                 of its points",
                folder.display(),
                study.path().display()
            ),
        });
    }
    Ok(())
}

/// A digest that identifies the points of a finished study.
pub(super) fn digest_of(folder: &Path) -> Result<String, CommandError> {
    let path = folder.join("points.csv");
    let digest = files::digest(&path).map_err(|error| match error.kind() {
        std::io::ErrorKind::NotFound => ResultsError::Missing(folder.to_owned()),
        _ => ResultsError::io(&path)(error),
    });
    Ok(digest?)
}

/// The result of an analysis.
pub(super) struct AnalysisResult {
    /// Which study, FMU and points it came from.
    pub(super) origin: Origin,
    /// The same for people.
    pub(super) text: String,
    /// The name of its file.
    pub(super) file: &'static str,
    /// What it says of the model; 0 unless it is a verdict.
    pub(super) code: ExitCode,
    result: serde_json::Value,
}

/// A finding with what it belongs to.
#[derive(Serialize)]
struct Told<'a> {
    origin: &'a Origin,
    #[serde(flatten)]
    finding: &'a serde_json::Value,
}

impl AnalysisResult {
    /// A result that becomes the content of `file`.
    pub(super) fn new(
        result: &impl Serialize,
        origin: Origin,
        text: String,
        file: &'static str,
    ) -> Result<Self, CommandError> {
        let result = serde_json::to_value(result).map_err(|error| ResultsError::Content {
            path: file.into(),
            message: error.to_string(),
        })?;
        Ok(Self {
            origin,
            text,
            file,
            code: ExitCode::SUCCESS,
            result,
        })
    }

    /// Writes the finding; a finished study in the same folder shows it on its page, where it belongs to
    /// that study.
    pub(super) fn tell(&self, folder: &Path) -> Result<ExitCode, CommandError> {
        let told = Told {
            origin: &self.origin,
            finding: &self.result,
        };
        make_folder(folder)?;
        write_json(&folder.join(self.file), &told)?;
        if folder.join("summary.json").exists() {
            Report::from_folder(folder)?.write(folder)?;
            if !self.origin.fits(&from_results::read(folder)?.0) {
                let page = folder.join("report.html");
                fmu_points::tell::line!(
                    "note: {} tells of another study or its earlier text, so it does not show this",
                    page.display()
                );
            }
        }
        let text = &self.text;
        output::print(&format!("{text}\nresults in {}\n", folder.display()));
        Ok(self.code)
    }
}
