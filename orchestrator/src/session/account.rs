//! `--budget N` counts the runs of all commands that had a budget in the same folder of results.

use std::path::Path;

use serde::{Deserialize, Serialize};

use super::{Request, Session};
use crate::error::{Error, Result};

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

impl Session {
    /// Opens the account of a command whose points have all cases of the study.
    ///
    /// # Errors
    /// Those of [`Account::open`].
    pub fn account(&mut self, folder: &Path, command: (&str, bool), runs: u64) -> Result<Account> {
        let cases = self.plan.cases.len().max(1) as u64;
        let account = Account::open(folder, command, runs, [cases, BESIDE * cases])?;
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
    pub fn open(folder: &Path, (command, resumed): (&str, bool), runs: u64, cost: [u64; 2]) -> Result<Self> {
        let read = |name: &str| -> Result<Option<Self>> {
            let state = folder.join(name);
            if !Request::is_in(&state) {
                return Ok(None);
            }
            let remedy = |error| Error::Refused(format!("{error}; remove that file, or choose another --output"));
            Ok(Request::read(&state).map_err(remedy)?.account)
        };
        if resumed && let Some(then) = read(command)?.filter(|then| then.runs == runs) {
            return Ok(Self { cost, ..then });
        }
        let mut account = Self { runs, cost, ..Self::default() };
        if let Some(of_verify) = read("")? {
            account.series = of_verify.series.wrapping_add(u64::from(command.is_empty() && !resumed));
        }
        for name in COMMANDS.into_iter().filter(|name| *name != command) {
            if let Some(other) = read(name)?.filter(|other| other.series == account.series) {
                account.others = account.others.saturating_add(other.own.unwrap_or(other.left()));
                if other.own.is_none() {
                    account.unfinished = Some(if name.is_empty() { "verify" } else { name });
                }
            }
        }
        Ok(account)
    }

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
