//! The request, kept beside the results so that a point can be run again and shards
//! be joined.

use std::{
    fs, mem,
    path::{Path, PathBuf},
};

use serde::{Deserialize, Serialize};

use super::{account::Account, budget::Budget};
use crate::error::{Error, Result};
use point_journal::{
    files::{write_json, write_text},
    pipeline::{Shard, folder::Earlier},
};
use study::Study;

/// The request: all options of the command.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct Request {
    /// The study file.
    pub study: PathBuf,
    /// Another FMU than the study's.
    pub fmu: Option<PathBuf>,
    /// Another number of points than the study's.
    pub points: Option<u64>,
    /// The most points of a run that ends when enough is known, if its design can go on so far.
    #[serde(skip)]
    pub most: Option<u64>,
    /// Another seed than the study's.
    pub seed: Option<u64>,
    /// A table of points instead of a design.
    pub points_from: Option<PathBuf>,
    /// A part of the points.
    pub shard: Option<Shard>,
    /// A number of runs that chosen points share, instead of a design.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub budget: Option<Budget>,
    /// What the command has of the folder's budget.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub account: Option<Account>,
    /// The folder of the files that the study names, where that is not its own.
    #[serde(skip)]
    pub base: Option<PathBuf>,
    /// Where the study stood when it was run, if what is read now is the text that was kept.
    #[serde(skip)]
    pub original: Option<PathBuf>,
}

const FILE: &str = "request.json";
const STUDY: &str = "study.toml";

impl Request {
    /// Whether a folder holds a request.
    pub fn is_in(folder: &Path) -> bool {
        folder.join(FILE).exists()
    }

    /// Refuses a folder that holds the results of another study file, or of this one with another FMU, where these are not
    /// to be replaced. `analysis` keeps its request in a folder of its own there. Without `study` no FMU is run, and any
    /// will do.
    ///
    /// # Errors
    /// Names what the folder holds.
    pub fn check(&self, folder: &Path, analysis: Option<&str>, study: Option<&Study>, earlier: Earlier) -> Result {
        let inner = analysis.map(|name| folder.join(name));
        for place in [folder].into_iter().chain(inner.as_deref()) {
            if earlier == Earlier::Replaced || !Self::is_in(place) {
                continue;
            }
            let then = Self::read(place)?;
            let of = |what: &str, then: &Path| Error::Taken {
                what: format!("{} holds results of {what}, {}", folder.display(), then.display()),
                remedy: "choose another --output, or replace them with --force",
            };
            if !is_same(then.own_study(), self.own_study()) {
                return Err(of("another study file", then.own_study()));
            }
            let (Some(study), Some(fmu)) = (study, &then.fmu) else { continue };
            let now = self.fmu.clone().unwrap_or_else(|| study.fmu_path());
            if !is_same(fmu, &now) && (self.fmu.is_some() || then.has_another_fmu()) {
                return Err(of("another FMU", fmu));
            }
        }
        Ok(())
    }

    /// Refuses to replace files in a folder into which no run has written yet, but for the study itself.
    ///
    /// # Errors
    /// Names the first such file.
    pub fn check_files(&self, folder: &Path, earlier: Earlier) -> Result {
        if earlier == Earlier::Replaced || Self::is_in(folder) {
            return Ok(());
        }
        let files = [STUDY, "points.csv", "summary.json", "report.html"].map(|file| folder.join(file));
        let is_file = |file: &PathBuf| file.symlink_metadata().is_ok_and(|entry| !entry.is_dir());
        match files.into_iter().find(|file| is_file(file) && !is_same(file, self.own_study())) {
            Some(file) => Err(Error::Taken {
                what: format!(
                    "{} was there before any run wrote into this folder, and would be replaced",
                    file.display()
                ),
                remedy: "choose another --output, or replace it with --force",
            }),
            None => Ok(()),
        }
    }

    /// Whether the FMU of a request that was kept is another one than its study's.
    fn has_another_fmu(&self) -> bool {
        let (Ok(study), Some(fmu), Some(folder)) = (Study::read(&self.study), &self.fmu, &self.base) else {
            return false;
        };
        !is_same(fmu, &folder.join(study.fmu.as_ref()))
    }

    /// Keeps the request in a folder, and the study's text beside it.
    ///
    /// # Errors
    /// When the system says no.
    pub fn write(&self, folder: &Path, study: &Study) -> Result {
        let fmu = self.fmu.clone().unwrap_or_else(|| study.fmu_path());
        let kept = Self {
            study: absolute(self.own_study()),
            fmu: Some(absolute(&fmu)),
            points_from: self.points_from.as_deref().map(absolute),
            ..self.clone()
        };
        write_json(&folder.join(FILE), &kept)?;
        Ok(write_text(&folder.join(STUDY), study.text())?)
    }

    /// The request of a folder. The study is the one that was kept there.
    ///
    /// # Errors
    /// When there is none.
    pub fn read(folder: &Path) -> Result<Self> {
        let path = folder.join(FILE);
        let text = fs::read(&path).map_err(|_| Error::Missing(folder.to_owned()))?;
        let mut request: Self = serde_json::from_slice(&text).map_err(|error| Error::content(&path, error))?;
        request.base = request.study.parent().map(Path::to_owned);
        request.original = Some(mem::replace(&mut request.study, folder.join(STUDY)));
        Ok(request)
    }

    /// The study as the user called it.
    pub fn own_study(&self) -> &Path {
        self.original.as_deref().unwrap_or(&self.study)
    }
}

/// A path that means the same in every folder.
pub fn absolute(path: &Path) -> PathBuf {
    std::path::absolute(path).unwrap_or_else(|_| path.to_owned())
}

/// Whether two paths lead to the same file. One that is gone since the results were made may have moved.
fn is_same(then: &Path, now: &Path) -> bool {
    match (fs::canonicalize(then), fs::canonicalize(now)) {
        (Ok(then), Ok(now)) => then == now,
        (Err(_), _) => then.file_name() == now.file_name(),
        (Ok(_), Err(_)) => false,
    }
}
