//! The report: one self-contained page, and its plots as files.

mod best;
pub(crate) mod counted;
mod counts;
pub mod figures;
mod from_results;
pub(crate) mod history;
pub mod judgement;
pub(crate) mod outlook;
mod overlay;
mod page;
mod payload;
mod planes;
pub(crate) mod recording;
pub(crate) mod whatif;

use crate::{
    error::{Error, Result},
    results::{Summary, answer::Answer},
};
use base64::{Engine, engine::general_purpose::STANDARD};
use figures::Series;
use flate2::{Compression, write::GzEncoder};
use fmu_points::tell::visible;
use judgement::Judgement;
use parameter_regions::table::PointTable;
use point_journal::files::write_text;
use result_document::{Document, svg};
use std::{
    io::Write,
    path::{Path, PathBuf},
};

/// Contents of a report.
#[derive(Clone, Debug, Default)]
pub struct Report {
    /// What came out of the study.
    pub summary: Summary,
    /// The points, or some of them where there are very many.
    pub table: PointTable,
    /// The verdict and its risks.
    pub judgement: Judgement,
    /// The first screen.
    pub answer: Answer,
    /// The trajectory of the best point, if it was recorded.
    pub history: Vec<Series>,
    /// The model's own error, and what the methods told.
    pub documents: Vec<Document>,
    /// The study to be changed in the page, where its points can be judged there.
    pub whatif: Option<whatif::WhatIf>,
    /// The command that reproduces the result.
    pub command: String,
    /// The study as a file, to be kept with the result.
    pub study_text: String,
}

impl Report {
    /// How many points there are, those included that the table leaves out, and how many of them are accepted.
    fn counts(&self) -> [usize; 2] {
        let Summary { points, verified, .. } = self.summary;
        let required = self.judgement.required();
        [points as usize, required.map_or(verified as usize, |(_, accepted)| accepted)]
    }

    /// The criteria that have pictures, where they are too many for all to have some.
    fn pictured(&self) -> Option<Vec<usize>> {
        Some(self.summary.pictured()).filter(|shown| shown.len() < self.summary.criteria.len())
    }

    /// Writes `report.html` and `plots/*.svg` into a folder, and returns the page's path.
    pub fn write(&self, folder: &Path) -> Result<PathBuf> {
        let (html, pictures) = page::render(self)?;
        let plots = folder.join("plots");
        // As files are: a link is replaced, never written through.
        if plots.is_symlink() {
            std::fs::remove_file(&plots).map_err(Error::io(&plots))?;
        }
        std::fs::create_dir_all(&plots).map_err(Error::io(&plots))?;
        // A picture that cannot be written costs itself: the page has it all the same.
        let failed: Vec<Error> = pictures
            .into_iter()
            .map(|(name, plot)| write_file(&plots.join(format!("{name}.svg")), &svg::standalone(&plot)))
            .filter_map(Result::err)
            .collect();
        if let Some(first) = failed.first() {
            fmu_points::tell::line!("note: {} plots have no file; the first: {first}", failed.len());
        }
        let path = folder.join("report.html");
        write_file(&path, &html)?;
        Ok(path)
    }
}

fn write_file(path: &Path, text: &str) -> Result {
    Ok(write_text(path, &*visible(text))?)
}

/// The text that the page unpacks.
fn packed(bytes: &[u8]) -> std::io::Result<String> {
    let mut packer = GzEncoder::new(Vec::new(), Compression::best());
    packer.write_all(bytes)?;
    Ok(STANDARD.encode(packer.finish()?))
}
