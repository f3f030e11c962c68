//! The verdicts that were drawn from points of a study, which a folder keeps beside them.
//!
//! Who judges a growing study again and again and stops when it suits is wrong far more often than the confidence says. So
//! every verdict after the first needs to know of those before it.

use std::{fs, io::ErrorKind, path::Path};

use serde::{Deserialize, Serialize};

use crate::error::{Error, Result};
use conformity::looks::History;
use point_journal::{Header, files::write_json};

/// The verdicts of a study.
#[derive(Serialize, Deserialize)]
pub struct Looked {
    /// The study, whatever the number of its points.
    pub study: Header,
    /// The verdicts.
    #[serde(flatten)]
    pub history: History,
    /// Those of other studies in this folder, such as of another seed: each goes on where it was.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    others: Vec<Other>,
}

/// The verdicts of another study.
#[derive(Serialize, Deserialize)]
struct Other {
    study: Header,
    #[serde(flatten)]
    history: History,
}

const FILE: &str = "looks.json";

impl Looked {
    /// The verdicts of a study that a folder keeps; those of another study do not count, and are kept.
    ///
    /// # Errors
    /// When they are there and cannot be read.
    pub fn read(folder: &Path, study: &Header) -> Result<Self> {
        let none = || Self { study: study.clone(), history: History::default(), others: Vec::new() };
        let path = folder.join(FILE);
        let text = match fs::read(&path) {
            Ok(text) => text,
            Err(error) if error.kind() == ErrorKind::NotFound => return Ok(none()),
            Err(error) => return Err(Error::io(&path)(error)),
        };
        let Self { study: last, history, mut others } =
            serde_json::from_slice(&text).map_err(|error| Error::content(&path, error))?;
        others.push(Other { study: last, history });
        let own = others.iter().position(|other| other.study == *study);
        let history = own.map_or_else(History::default, |own| others.remove(own).history);
        Ok(Self { study: study.clone(), history, others })
    }

    /// Keeps them in a folder.
    ///
    /// # Errors
    /// When the system says no.
    pub fn write(&self, folder: &Path) -> Result {
        Ok(write_json(&folder.join(FILE), self)?)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use conformity::looks::{Look, Way};

    #[test]
    fn looks_survive_a_run_with_another_seed() {
        let folder = tempfile::tempdir().unwrap();
        let study = |seed| Header { seed, ..Header::default() };
        for (seed, points) in [(1, 50), (2, 60), (3, 70), (1, 80)] {
            let mut looked = Looked::read(folder.path(), &study(seed)).unwrap();
            looked.history.note(Look { points, way: Way::Once, awaited: false });
            looked.write(folder.path()).unwrap();
        }
        let points = |seed| -> Vec<u64> {
            let looked = Looked::read(folder.path(), &study(seed)).unwrap();
            looked.history.looks.iter().map(|look| look.points).collect()
        };
        assert_eq!([1, 2, 3, 4].map(points), [vec![50, 80], vec![60], vec![70], vec![]]);
    }
}
