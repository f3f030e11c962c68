//! `--budget N` counts the runs of all commands that had a budget in the same folder of results.

use std::path::Path;

use super::{Request, Session, account::Account};
use crate::error::{Error, Result};

/// The folders of the commands that may have a budget. `verify` keeps its journal in the folder of the results itself.
const COMMANDS: [&str; 5] = ["", "identify", "rare", "robustness", "tolerances"];

/// Runs of each case that tell nothing: the first point runs twice, and one runs once more at the end.
const BESIDE: u64 = 2;

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
}
