//! The folder in which a run keeps what it has computed.

use std::{fs, path::Path};

use crate::{Error, Finished, Header, Journal, Lock, Result, files::DRAFT, lines};
use fmu_points::{
    scratch::{self, Scratch},
    stop,
};

/// A folder that is taken for a run.
pub struct RunFolder {
    /// Takes what is computed.
    pub journal: Journal,
    /// The points of earlier runs.
    pub finished: Option<Finished>,
    /// What keeps the folder for this run.
    pub kept: Kept,
}

/// Keeps a folder for a run as long as this is there.
pub struct Kept {
    /// For what is needed while points run.
    pub scratch: Scratch,
    _lock: Lock,
}

/// The treatment of a run that a folder holds already.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Earlier {
    /// It goes on.
    Resumed,
    /// It is replaced if it is complete.
    Complete,
    /// It is replaced.
    Replaced,
}

impl RunFolder {
    /// Takes a folder of which this process has the lock: with a new journal, or with the one that is there. A run that is
    /// complete, or has no point yet, is simply done again; `complete` says that it is, where the journal does not.
    ///
    /// # Errors
    /// When the folder holds something else, and when the system says no.
    pub fn open(lock: Lock, folder: &Path, header: &Header, earlier: Earlier, complete: bool) -> Result<Self> {
        // What killed runs left: nobody else is at work here.
        scratch::remove_starting_with(folder, &[DRAFT]);
        let (journal, finished) = journal(folder, header, earlier, complete)?;
        Ok(Self { journal, finished, kept: Kept { scratch: stop::scratch()?, _lock: lock } })
    }
}

fn journal(folder: &Path, header: &Header, earlier: Earlier, complete: bool) -> Result<(Journal, Option<Finished>)> {
    let path = lines::path_in(folder);
    if path.exists() {
        if earlier == Earlier::Resumed {
            let (journal, finished) = Journal::resume(folder, header)?;
            return Ok((journal, Some(finished)));
        }
        // A run whose FMU could not be loaded has no points, so nothing is lost.
        let over = |finished: Finished| finished.ended || finished.count == 0;
        let replaced = earlier == Earlier::Replaced || complete;
        if replaced || Finished::read(folder).is_ok_and(over) {
            tell_of_another(folder, header);
            let summary = folder.join("summary.json");
            // Else the new run would count as complete, and be replaced itself where it was interrupted.
            for file in [path, summary] {
                if file.exists() {
                    fs::remove_file(&file).map_err(Error::io(&file))?;
                }
            }
        }
    }
    Ok((Journal::create(folder, header)?, None))
}

/// Says what is different about the run that takes the place of another one.
fn tell_of_another(folder: &Path, header: &Header) {
    let then = lines::header(folder).ok();
    if let Some((what, then, now)) = then.and_then(|then| header.difference(&then)) {
        fmu_points::tell::line!(
            "note: the results in {} came from another {what} ({then} then, {now} now); they are replaced",
            folder.display()
        );
    }
}
