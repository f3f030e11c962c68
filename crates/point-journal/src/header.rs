//! Which study, FMU and points a journal belongs to.

use crate::{Error, Result};
use std::path::Path;

use serde::{Deserialize, Serialize};

/// The form of a journal's lines: results whose lines are of another form are not read.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Form(u32);

impl Form {
    /// That of journals before there was a number.
    fn first() -> Self {
        Self(0)
    }
}

impl Default for Form {
    fn default() -> Self {
        Self(3)
    }
}

/// Identity of a run: study, FMU, seed, versions. Points of different runs must not be mixed.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Header {
    /// The form of the lines that follow.
    #[serde(default = "Form::first")]
    pub form: Form,
    /// The version of this program.
    pub orchestrator: String,
    /// The digest of the study's text.
    pub study: String,
    /// The digest of the FMU.
    pub fmu: String,
    /// The digest of the table of points, where points were given.
    pub table: Option<String>,
    /// The seed of the design.
    pub seed: u64,
    /// How many points there are, where that is known beforehand.
    pub points: Option<u64>,
    /// Which part of the points this is, such as `2/8`.
    pub shard: Option<String>,
    /// The analysis that asks for the points, where that is another one than `verify`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub analysis: Option<String>,
}

impl Header {
    /// Refuses a journal whose lines another version has written otherwise.
    ///
    /// # Errors
    /// Says so.
    pub fn check_form(&self, path: &Path) -> Result {
        if self.form == Form::default() {
            Ok(())
        } else {
            Err(Error::Refused(format!(
                "{} was written by another version of this program; run the study anew with --force, or choose another --output",
                path.display()
            )))
        }
    }

    /// Refuses points that were computed for something else.
    ///
    /// # Errors
    /// Names what differs.
    pub fn check(&self, then: &Self, path: &Path) -> Result {
        then.check_form(path)?;
        match self.difference(then) {
            None => Ok(()),
            Some((what, then, now)) => Err(Error::Refused(format!(
                "{} was made with another {what} ({then} then, {now} now); choose another --output, or begin again with \
                 --force instead of --resume",
                path.display()
            ))),
        }
    }

    /// Whether this is the same run with more points than `then`.
    pub fn extends(&self, then: &Self) -> bool {
        let same = Self { points: then.points, ..self.clone() };
        same == *then && self.points > then.points && then.points.is_some()
    }

    /// The first difference between two headers: its name, the other's value, this one's.
    pub fn difference(&self, then: &Self) -> Option<(&'static str, String, String)> {
        let or = |text: &Option<String>, otherwise: &str| text.clone().unwrap_or_else(|| otherwise.to_owned());
        let texts = |header: &Self| {
            let table = header.table.as_deref().map(short);
            let points = header.points.map(|points| points.to_string());
            [
                ("analysis", or(&header.analysis, "verify")),
                ("orchestrator", header.orchestrator.clone()),
                ("study", short(&header.study)),
                ("FMU", short(&header.fmu)),
                ("table of points", or(&table, "")),
                ("seed", header.seed.to_string()),
                ("number of points", or(&points, "open")),
                ("shard", or(&header.shard, "none")),
            ]
        };
        let mut pairs = texts(self).into_iter().zip(texts(then));
        let ((what, now), (_, then)) = pairs.find(|(now, then)| now != then)?;
        Some((what, then, now))
    }
}

/// The first digits of a digest, for people.
fn short(digest: &str) -> String {
    digest.chars().take(12).collect()
}
