//! The folder in which a run keeps what it has computed.

use std::fs;
use std::path::Path;
use std::thread::sleep;
use std::time::Duration;

use tempfile::TempDir;

use crate::results::finished::Finished;
use crate::results::{Header, Journal, ResultsError, lines};

/// A folder that is taken for a run.
#[derive(Debug)]
pub struct RunFolder {
    /// Takes what is computed.
    pub journal: Journal,
    /// The points of earlier runs.
    pub finished: Option<Finished>,
    /// For what is needed while points run.
    pub scratch: TempDir,
}

impl RunFolder {
    /// Takes a folder: with a new journal, or with `resume` with the one that is there. A run that is complete, or
    /// has no point yet, is simply done again.
    ///
    /// # Errors
    /// When the folder holds something else, and when the system says no.
    pub fn open(
        folder: &Path,
        header: &Header,
        resume: bool,
        complete: bool,
    ) -> Result<Self, ResultsError> {
        let (journal, finished) = journal(folder, header, resume, complete)?;
        Ok(Self {
            journal,
            finished,
            scratch: scratch(folder)?,
        })
    }
}

fn journal(
    folder: &Path,
    header: &Header,
    resume: bool,
    complete: bool,
) -> Result<(Journal, Option<Finished>), ResultsError> {
    if lines::path_in(folder).exists() {
        if resume {
            let (journal, finished) = Journal::resume(folder, header)?;
            return Ok((journal, Some(finished)));
        }
        // A run whose FMU could not be loaded has no points, so nothing is lost.
        let over = |finished: Finished| finished.ended || finished.count == 0;
        if complete || Finished::read(folder).is_ok_and(over) {
            Journal::remove(folder)?;
        }
    }
    Ok((Journal::create(folder, header)?, None))
}

/// A folder within `folder` for what is needed while points run. Those of runs that were killed
/// are removed; the journal's lock says that they are not in use.
///
/// # Errors
/// When the system says no.
fn scratch(folder: &Path) -> Result<TempDir, ResultsError> {
    const PREFIX: &str = ".running-";
    const LEFT_OVERS: [&str; 3] = [PREFIX, ".points-", ".writing-"];
    for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
        let name = entry.file_name();
        if LEFT_OVERS
            .iter()
            .any(|prefix| name.to_string_lossy().starts_with(prefix))
        {
            remove(&entry.path());
        }
    }
    let scratch = tempfile::Builder::new().prefix(PREFIX).tempdir_in(folder);
    scratch.map_err(ResultsError::io(folder))
}

/// Removes a folder or a file, if it can. One that stays only takes up room.
fn remove(path: &Path) {
    // The processes of a run that was killed end on their own, and may still write for a moment.
    const TRIES: u32 = 50;
    for _ in 0..TRIES {
        let removed = fs::remove_dir_all(path).or_else(|_| fs::remove_file(path));
        if removed.is_ok() || !path.exists() {
            return;
        }
        sleep(Duration::from_millis(10));
    }
}
