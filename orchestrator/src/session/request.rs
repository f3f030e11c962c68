//! What was asked for, kept beside the results so that a point can be run again and shards
//! be joined.

use std::fmt;
use std::fs;
use std::mem;
use std::path::{Path, PathBuf};
use std::str::FromStr;

use serde::{Deserialize, Serialize};

use crate::results::{ResultsError, write_atomically};
use crate::study::Study;

/// What was asked for.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct Request {
    /// The study file.
    pub study: PathBuf,
    /// Another FMU than the study's.
    pub fmu: Option<PathBuf>,
    /// Another number of points than the study's.
    pub points: Option<u64>,
    /// Another seed than the study's.
    pub seed: Option<u64>,
    /// A table of points instead of a design.
    pub points_from: Option<PathBuf>,
    /// A part of the points.
    pub shard: Option<Shard>,
    /// The folder of the files that the study names, where that is not its own.
    #[serde(skip)]
    pub base: Option<PathBuf>,
    /// Where the study stood when it was run, if what is read now is the text that was kept.
    #[serde(skip)]
    pub original: Option<PathBuf>,
}

/// One of several equal parts of the points: those with index `number - 1`, `number - 1 + of`, ...
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Shard {
    /// Which part, from 1.
    pub number: u64,
    /// How many parts there are.
    pub of: u64,
}

impl FromStr for Shard {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let parts = text.split_once('/');
        let numbers = parts.and_then(|(a, b)| Some((a.parse().ok()?, b.parse().ok()?)));
        match numbers {
            Some((number, of)) if (1..=of).contains(&number) => Ok(Self { number, of }),
            _ => Err(format!("`{text}` is not a part such as 2/8")),
        }
    }
}

impl fmt::Display for Shard {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}/{}", self.number, self.of)
    }
}

const FILE: &str = "request.json";
const STUDY: &str = "study.toml";

impl Request {
    /// Keeps the request in a folder, and the study's text beside it.
    ///
    /// # Errors
    /// When the system says no.
    pub fn write(&self, folder: &Path, study: &Study) -> Result<(), ResultsError> {
        let absolute = |path: &Path| std::path::absolute(path).unwrap_or_else(|_| path.to_owned());
        let fmu = self.fmu.clone().unwrap_or_else(|| study.fmu_path());
        let kept = Self {
            study: absolute(self.own_study()),
            fmu: Some(absolute(&fmu)),
            points_from: self.points_from.as_deref().map(absolute),
            ..self.clone()
        };
        write_atomically(&folder.join(FILE), |out| {
            serde_json::to_writer_pretty(&mut *out, &kept)?;
            writeln!(out)
        })?;
        write_atomically(&folder.join(STUDY), |out| {
            out.write_all(study.text().as_bytes())
        })
    }

    /// The request of a folder. The study is the one that was kept there.
    ///
    /// # Errors
    /// When there is none.
    pub fn read(folder: &Path) -> Result<Self, ResultsError> {
        let path = folder.join(FILE);
        let text = fs::read(&path).map_err(|_| ResultsError::Missing(folder.to_owned()))?;
        let mut request: Self =
            serde_json::from_slice(&text).map_err(|error| ResultsError::Content {
                path,
                message: error.to_string(),
            })?;
        request.base = request.study.parent().map(Path::to_owned);
        request.original = Some(mem::replace(&mut request.study, folder.join(STUDY)));
        Ok(request)
    }

    /// The study as the user called it.
    pub fn own_study(&self) -> &Path {
        self.original.as_deref().unwrap_or(&self.study)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shards() {
        assert_eq!("2/8".parse(), Ok(Shard { number: 2, of: 8 }));
        for wrong in ["0/8", "9/8", "2", "a/b", "1/0"] {
            assert!(wrong.parse::<Shard>().is_err(), "{wrong}");
        }
    }
}
