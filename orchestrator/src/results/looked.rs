//! The verdicts that were drawn from points of a study, which a folder keeps beside them.
//!
//! Who judges a growing study again and again and stops when it suits is wrong far more often than the confidence says. So
//! every verdict after the first needs to know of those before it.

use std::fs;
use std::io::ErrorKind;
use std::path::Path;

use serde::{Deserialize, Serialize};

use crate::error::Error;
use conformity::looks::History;
use point_journal::Header;
use point_journal::files::write_json;

/// The verdicts of a study.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Looked {
    /// The study, whatever the number of its points.
    pub study: Header,
    /// The verdicts.
    #[serde(flatten)]
    pub history: History,
}

const FILE: &str = "looks.json";

impl Looked {
    /// The verdicts of a study that a folder keeps; those of another study do not count.
    ///
    /// # Errors
    /// When they are there and cannot be read.
    pub fn read(folder: &Path, study: &Header) -> Result<Self, Error> {
        let none = || Self { study: study.clone(), history: History::default() };
        let path = folder.join(FILE);
        let text = match fs::read(&path) {
            Ok(text) => text,
            Err(error) if error.kind() == ErrorKind::NotFound => return Ok(none()),
            Err(error) => return Err(Error::io(&path)(error)),
        };
        let kept: Self = serde_json::from_slice(&text).map_err(|error| Error::content(&path, error))?;
        Ok(if kept.study == *study { kept } else { none() })
    }

    /// Keeps them in a folder.
    ///
    /// # Errors
    /// When the system says no.
    pub fn write(&self, folder: &Path) -> Result<(), Error> {
        Ok(write_json(&folder.join(FILE), self)?)
    }
}
