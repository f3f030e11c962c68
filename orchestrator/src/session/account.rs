//! What one command has of the budget of a folder.

use serde::{Deserialize, Serialize};

use crate::error::Error;

/// What one command has of a folder's budget.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct Account {
    /// The most runs of all commands together.
    pub runs: u64,
    /// Those of the other commands.
    pub(super) others: u64,
    /// Those of this one, once it has ended.
    pub(super) own: Option<u64>,
    /// How often `verify` has begun anew in the folder: what others made of earlier points is of no use, and does not count.
    pub(super) series: u64,
    /// Another command that has not ended, whose runs are held for it.
    #[serde(skip)]
    pub(super) unfinished: Option<&'static str>,
    /// Runs that it takes for each point, and beside all points.
    #[serde(skip)]
    pub(super) cost: [u64; 2],
}

impl Account {
    /// The runs that others have left.
    pub fn left(&self) -> u64 {
        self.runs.saturating_sub(self.others)
    }

    /// The budget that leaves so many runs.
    pub fn with_others(&self, own: u64) -> u64 {
        own.saturating_add(self.others)
    }

    /// The points that these pay for.
    pub fn points(&self) -> u64 {
        let [each, beside] = self.cost;
        self.left().saturating_sub(beside) / each
    }

    /// The runs of so many points.
    pub fn of(&self, points: u64) -> u64 {
        let [each, beside] = self.cost;
        if points > 0 { points * each + beside } else { 0 }
    }

    /// The account of the command when it has ended, after so many points.
    pub fn after(&self, points: u64) -> Self {
        Self { own: Some(self.of(points)), ..self.clone() }
    }

    /// What others have run, for the end of a message.
    pub fn told(&self) -> String {
        match (self.others, self.unfinished) {
            (0, _) => String::new(),
            (others, None) => format!("; other commands have made {others} runs in this folder, which count"),
            (others, Some(name)) => format!(
                "; other commands have made {others} runs in this folder, or hold them: `{name}` has not ended, which \
                 --resume does"
            ),
        }
    }

    /// Refuses a budget that leaves fewer runs than a command needs.
    pub fn too_few(&self, least: u64, what: &str) -> Error {
        let least = self.with_others(least);
        let message = format!("{} runs: give {least} or more{what}{}", self.runs, self.told());
        Error::option("budget", message)
    }
}
