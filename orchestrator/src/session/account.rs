//! `--budget N` counts the runs of all commands that had a budget in the same folder of results.

use std::{fs, io, path::Path};

use serde::{Deserialize, Serialize};

use crate::error::{Error, Result};
use point_journal::files::write_json;
use study::Study;

/// The account's file, in the folder of the command's journal.
const FILE: &str = "budget.json";
/// The folders of the commands that may have one. `verify` keeps its journal in the folder of the results itself.
const COMMANDS: [&str; 5] = ["", "identify", "rare", "robustness", "tolerances"];

/// What one command has of a folder's budget.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct Account {
    /// The most runs of all commands together.
    pub runs: u64,
    /// Those of the other commands.
    others: u64,
    /// Those of this one, once it has ended.
    own: Option<u64>,
    /// Runs that it takes for each point, and beside all points.
    #[serde(skip)]
    cost: [u64; 2],
}

impl Account {
    /// The account of a command, of so many runs. A command that is resumed with as many as before has what it had then: others
    /// may have run since, and its points are to be the same.
    ///
    /// # Errors
    /// When the account of a command in the folder cannot be read.
    pub fn open(
        folder: &Path,
        (command, resumed): (&str, bool),
        runs: u64,
        study: &Study,
        cost: [u64; 2],
    ) -> Result<Self> {
        let then = Self::read(&folder.join(command))?;
        if let Some(then) = then.filter(|then| resumed && then.runs == runs) {
            return Ok(Self { cost, ..then });
        }
        let mut others = 0;
        for other in COMMANDS.iter().filter(|other| **other != command) {
            let state = folder.join(other);
            // Results of what the study said before are replaced.
            let is_of_study = fs::read_to_string(state.join("study.toml")).is_ok_and(|text| text == study.text());
            if let Some(other) = Self::read(&state)?.filter(|_| is_of_study) {
                others += other.own.unwrap_or(other.left());
            }
        }
        Ok(Self { runs, others, own: None, cost })
    }

    /// The account in the folder of a command's journal.
    ///
    /// # Errors
    /// When it cannot be read.
    pub fn read(state: &Path) -> Result<Option<Self>> {
        let path = state.join(FILE);
        match fs::read(&path) {
            Ok(text) => serde_json::from_slice(&text).map(Some).map_err(|error| Error::content(&path, error)),
            Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(None),
            Err(error) => Err(Error::io(&path)(error)),
        }
    }

    /// The runs that others have left.
    pub fn left(&self) -> u64 {
        self.runs.saturating_sub(self.others)
    }

    /// The points that these pay for.
    pub fn points(&self) -> u64 {
        let [each, beside] = self.cost;
        self.left().saturating_sub(beside) / each
    }

    /// What others have run, for the end of a message.
    pub fn told(&self) -> String {
        match self.others {
            0 => String::new(),
            others => format!("; other commands have made {others} runs in this folder, which count"),
        }
    }

    /// Refuses a budget that leaves fewer runs than a command needs.
    pub fn too_few(&self, least: u64, what: &str) -> Error {
        let message = format!("{} runs: give {} or more{what}{}", self.runs, self.others + least, self.told());
        Error::option("budget", message)
    }

    /// Notes the account, before the first run.
    ///
    /// # Errors
    /// When the system says no.
    pub fn begin(&self, state: &Path) -> Result {
        Ok(write_json(&state.join(FILE), self)?)
    }

    /// Notes that the command has ended, after so many runs.
    ///
    /// # Errors
    /// When the system says no.
    pub fn end(&self, state: &Path, own: u64) -> Result {
        Self { own: Some(own), ..self.clone() }.begin(state)
    }

    /// The same after so many points.
    ///
    /// # Errors
    /// When the system says no.
    pub fn end_after(&self, state: &Path, points: u64) -> Result {
        let [each, beside] = self.cost;
        self.end(state, if points > 0 { points * each + beside } else { 0 })
    }
}
