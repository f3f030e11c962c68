//! Reads the folder of a finished study for an analysis of it, and checks whether it is of that study.

use std::path::{Path, PathBuf};

use crate::{
    error::{Error, Result},
    options::folder_of,
    results::{Summary, answer::Names, origin::Origin, table},
    session::{Request, absolute},
};
use number_tables::files;
use parameter_regions::table::PointTable;
use serde::{Deserialize, de::DeserializeOwned};
use study::Study;

/// The folder of the finished study that the user names, the one for the results where a study is in it, or the usual one.
pub fn from(named: Option<&Path>, output: Option<&Path>, study: &Path) -> PathBuf {
    let output = output.filter(|folder| folder.join("summary.json").exists());
    named.or(output).map_or_else(|| folder_of(study), Path::to_owned)
}

/// The points of a finished study, for an analysis of `study`.
pub fn points_of(folder: &Path, study: &Study) -> Result<(Summary, PointTable)> {
    let (summary, table) = table::read(folder)?;
    if study.digest() != summary.provenance.study_sha256 {
        return Err(Error::option(
            "from",
            format!(
                "the points in {} are not of {} as it is now; verify it again, or name the folder of its points",
                folder.display(),
                study.path().display()
            ),
        ));
    }
    if table.parameters.is_empty() {
        return Err(Error::option(
            "from",
            format!(
                "the points in {} have no parameters, so nothing can be said of these; `judge` writes none, `verify` does",
                folder.display()
            ),
        ));
    }
    Ok((summary, table))
}

/// The rows of a finished study's points that are a sample of the space; those that `--budget` chose near limits are not.
pub fn sample_of(folder: &Path, summary: &Summary, rows: usize) -> Result<Vec<usize>> {
    if summary.surrogate.is_none() {
        return Ok((0..rows).collect());
    }
    let budget = Request::read(folder)?.budget.unwrap_or_default();
    if budget.places.len() != rows {
        return Err(Error::content(
            &folder.join("points.csv"),
            format!("{} rows, and request.json tells {} points", rows, budget.places.len()),
        ));
    }
    Ok(budget.plain().enumerate().filter_map(|(row, plain)| plain.then_some(row)).collect())
}

/// A digest that identifies the points of a finished study.
pub fn digest_of(folder: &Path) -> Result<String> {
    let path = folder.join("points.csv");
    files::digest(&path).map_err(|error| match error.kind() {
        std::io::ErrorKind::NotFound => Error::Missing(folder.to_owned()),
        _ => Error::io(&path)(error),
    })
}

/// The origin of the result in a file.
#[derive(Deserialize)]
struct Head {
    origin: Origin,
}

/// The folder of a finished study.
#[derive(Clone, Copy)]
pub struct Finished<'a> {
    /// The folder.
    pub folder: &'a Path,
    /// The results.
    pub summary: &'a Summary,
}

impl Finished<'_> {
    /// The names of study and folder, as seen from here; those of files elsewhere are whole. Of a table that was judged the study's
    /// name is known alone.
    pub fn names(&self) -> Names {
        let here = std::env::current_dir().unwrap_or_default();
        let shown = |path: &Path| {
            let text = path.strip_prefix(&here).unwrap_or(path).display().to_string();
            match text {
                text if text.is_empty() => ".".to_owned(),
                text if text.contains(char::is_whitespace) => format!("\"{text}\""),
                text => text,
            }
        };
        let folder = absolute(self.folder);
        let request = Request::read(self.folder).ok();
        let study = request.as_ref().map_or(Path::new(&self.summary.provenance.study), Request::own_study);
        let is_usual = absolute(&folder_of(study)) == folder;
        let folder = shown(&folder);
        let output = if is_usual { String::new() } else { format!(" --output {folder}") };
        Names { study: shown(study), output, folder }
    }

    /// The result of an analysis that the folder holds, if it belongs to the study that the folder holds.
    pub fn result<T: DeserializeOwned>(&self, file: &str) -> Option<T> {
        let text = std::fs::read_to_string(self.folder.join(file)).ok()?;
        let head: Head = serde_json::from_str(&text).ok()?;
        head.origin.fits(self.summary).then(|| serde_json::from_str(&text).ok()).flatten()
    }
}
