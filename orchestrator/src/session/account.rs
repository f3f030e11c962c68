//! `--budget N` counts the runs of all commands that had a budget in the same folder of results.

use std::{fs, path::Path};

use serde::{Deserialize, Serialize};

use super::{Request, Session};
use crate::error::{Error, Result};
use study::Study;

/// The folders of the commands that may have a budget. `verify` keeps its journal in the folder of the results itself.
const COMMANDS: [&str; 5] = ["", "identify", "rare", "robustness", "tolerances"];

/// Runs of each case that tell nothing: the first point runs twice, and one runs once more at the end.
const BESIDE: u64 = 2;

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

impl Session {
    /// Opens the account of a command whose points have all cases of the study.
    ///
    /// # Errors
    /// Those of [`Account::open`].
    pub fn account(&mut self, folder: &Path, command: (&str, bool), runs: u64) -> Result<Account> {
        let cases = self.plan.cases.len().max(1) as u64;
        let account = Account::open(folder, command, runs, &self.study, [cases, BESIDE * cases])?;
        self.request.account = Some(account.clone());
        Ok(account)
    }
}

impl Account {
    /// The account of a command, of so many runs. A command that is resumed with as many as before has what it had then: others
    /// may have run since, and its points are to be the same.
    ///
    /// # Errors
    /// When a request in the folder cannot be read.
    pub fn open(
        folder: &Path,
        (command, resumed): (&str, bool),
        runs: u64,
        study: &Study,
        cost: [u64; 2],
    ) -> Result<Self> {
        let mut others = 0;
        for name in COMMANDS {
            let state = folder.join(name);
            let then = if Request::is_in(&state) { Request::read(&state)? } else { continue };
            let Some(account) = then.account else { continue };
            if name == command {
                if resumed && account.runs == runs {
                    return Ok(Self { cost, ..account });
                }
            // What the study said before is to be replaced.
            } else if fs::read_to_string(then.study).is_ok_and(|text| text == study.text()) {
                others += account.own.unwrap_or(account.left());
            }
        }
        Ok(Self { runs, others, own: None, cost })
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
}
