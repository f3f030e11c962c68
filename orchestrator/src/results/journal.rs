//! The journal: finished points, durable at once.
//!
//! A text file to which lines are only ever appended, in the order in which points finish. The
//! first line says what the study is. Every line carries a checksum, so that a line that was cut
//! off by a power loss or a full disk is recognised and its point computed again:
//!
//! ```text
//! 5d41402a {"orchestrator":...,"points":50}
//! 7b502c3a 3 ok 4.802e1 8.155e1
//! 1c0de5a7 5 used 4.799e1 8.161e1
//! 2b7c9f13 6 ok 4.795e1 8.158e1 {"warnings":2,"first_warning":"the oil is warm"}
//! 9a0b11c2 4 failed {"Error":"film rupture (fmi2DoStep)"}
//! 0d1e2f3a note {"Void":"Used"}
//! ```
//!
//! `apart`, `ok`, `forked` and `used` tell in what process a point was computed ([`Separation`]): a note may say that some of
//! these do not count any more. What the FMU said beside the results, or before it failed, stands behind them ([`Notices`]).
//! An analysis that asks for several sets of points notes what tells each set from others, `set 0 600 5d41402a`,
//! and at last `end`. Where a set takes the place of another one, what followed that one counts no more.

use std::fmt::Write as _;
use std::fs::{self, File, OpenOptions, TryLockError};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::thread::sleep;
use std::time::{Duration, Instant};

use tempfile::NamedTempFile;

use super::finished::Finished;
use super::header::Header;
use super::lines::{self, open, path_in};
use super::note::{Note, word};
use super::{Outcome, ResultsError};
use crate::engine::Separation;
use crate::notices::Notices;

/// How long to wait for the lock. When a run is killed while it starts a worker, the new process holds a copy of the lock
/// until it becomes the worker's program.
const PATIENCE: Duration = Duration::from_secs(2);

fn lock(file: &File) -> Result<(), TryLockError> {
    let begun = Instant::now();
    loop {
        match file.try_lock() {
            Err(TryLockError::WouldBlock) if begun.elapsed() < PATIENCE => {
                sleep(Duration::from_millis(10));
            }
            result => return result,
        }
    }
}

/// A journal that is being written.
#[derive(Debug)]
pub struct Journal {
    path: PathBuf,
    file: File,
    line: String,
    buffer: Vec<u8>,
}

impl Journal {
    /// Begins a journal. It appears with its first line in place, or not at all.
    ///
    /// # Errors
    /// When there is one already, and when the system says no.
    pub fn create(folder: &Path, header: &Header) -> Result<Self, ResultsError> {
        let (draft, journal) = Self::draft(folder, header)?;
        draft
            .persist_noclobber(&journal.path)
            .map_err(|error| match error.error.kind() {
                io::ErrorKind::AlreadyExists => ResultsError::Begun(folder.to_owned()),
                _ => ResultsError::io(&journal.path)(error.error),
            })?;
        Ok(journal)
    }

    /// Makes the journal of a folder one of a run with more points, whose first points are those that it has. It is
    /// replaced as a whole, or stays as it is.
    ///
    /// # Errors
    /// When another run writes it, and when the system says no.
    pub fn extend(folder: &Path, header: &Header) -> Result<(), ResultsError> {
        let path = path_in(folder);
        let file = OpenOptions::new().append(true).open(&path);
        let _lock = Self::new(folder, path.clone(), file.map_err(ResultsError::io(&path))?)?;
        let (draft, mut longer) = Self::draft(folder, header)?;
        let (mut lines, _) = open(folder)?;
        while let Some(line) = lines.next_line().map_err(ResultsError::io(&path))? {
            longer.line.push_str(line);
            longer.finish_line();
            longer.flush_when_full()?;
        }
        longer.sync()?;
        let placed = draft.persist(&path);
        placed
            .map(drop)
            .map_err(|error| ResultsError::io(&path)(error.error))
    }

    /// A journal with its first line, which is not yet in its place.
    fn draft(folder: &Path, header: &Header) -> Result<(NamedTempFile, Self), ResultsError> {
        let path = path_in(folder);
        fs::create_dir_all(folder).map_err(ResultsError::io(folder))?;
        let draft = tempfile::Builder::new()
            .prefix(".writing-")
            .tempfile_in(folder);
        let draft = draft.map_err(ResultsError::io(folder))?;
        let file = OpenOptions::new().append(true).open(draft.path());
        let file = file.map_err(ResultsError::io(&path))?;
        let mut journal = Self::new(folder, path, file)?;
        let header = serde_json::to_string(header).map_err(|error| ResultsError::Content {
            path: journal.path.clone(),
            message: error.to_string(),
        })?;
        journal.line.push_str(&header);
        journal.finish_line();
        journal.flush()?;
        Ok((draft, journal))
    }

    /// Continues a journal; a damaged end is cut off.
    ///
    /// # Errors
    /// When there is none, when it belongs to something else, and when the system says no.
    pub fn resume(folder: &Path, header: &Header) -> Result<(Self, Finished), ResultsError> {
        header.check(&lines::header(folder)?, folder)?;
        let path = path_in(folder);
        let file = OpenOptions::new().append(true).open(&path);
        let file = file.map_err(ResultsError::io(&path))?;
        let journal = Self::new(folder, path, file)?;
        // Read under the lock: another run may just have ended.
        let finished = Finished::read(folder)?;
        let cut = journal.file.set_len(finished.sound);
        cut.map_err(ResultsError::io(&journal.path))?;
        Ok((journal, finished))
    }

    /// Takes the file for this run alone; the lock ends with the process, however it ends.
    fn new(folder: &Path, path: PathBuf, file: File) -> Result<Self, ResultsError> {
        match lock(&file) {
            Ok(()) => {}
            Err(TryLockError::WouldBlock) => return Err(ResultsError::Busy(folder.to_owned())),
            Err(TryLockError::Error(error)) => return Err(ResultsError::io(&path)(error)),
        }
        Ok(Self {
            path,
            file,
            line: String::new(),
            buffer: Vec::new(),
        })
    }

    /// Notes a finished point; [`flush`](Self::flush) hands it to the system.
    ///
    /// # Errors
    /// When the outcome cannot be written as text.
    pub fn append(
        &mut self,
        index: u64,
        outcome: &Outcome,
        separation: Separation,
        notices: Option<&Notices>,
    ) -> Result<(), ResultsError> {
        // Writing to a String cannot fail.
        let _ = match outcome {
            Ok(values) => {
                let _ = write!(self.line, "{index} {}", word(separation));
                values
                    .iter()
                    .try_for_each(|value| write!(self.line, " {value:e}"))
            }
            Err(failure) => {
                let text = serde_json::to_string(failure).unwrap_or_default();
                write!(self.line, "{index} failed {text}")
            }
        };
        if let Some(notices) = notices {
            let text = serde_json::to_string(notices).unwrap_or_default();
            let _ = write!(self.line, " {text}");
        }
        self.finish_line();
        self.flush_when_full()
    }

    /// Notes what concerns many points.
    ///
    /// # Errors
    /// When the system says no.
    pub fn note(&mut self, note: &Note) -> Result<(), ResultsError> {
        let text = serde_json::to_string(note).unwrap_or_default();
        let _ = write!(self.line, "note {text}");
        self.finish_line();
        self.flush_when_full()
    }

    /// Notes a set of points by what tells it from others; `first` is the index of its first point.
    ///
    /// # Errors
    /// When the system says no.
    pub fn append_set(&mut self, first: u64, sum: &str) -> Result<(), ResultsError> {
        // Writing to a String cannot fail.
        let _ = write!(self.line, "set {first} {sum}");
        self.finish_line();
        self.flush_when_full()
    }

    /// Notes that no further points are needed.
    pub fn append_end(&mut self) {
        self.line.push_str("end");
        self.finish_line();
    }

    fn flush_when_full(&mut self) -> Result<(), ResultsError> {
        const FULL: usize = 1 << 16;
        if self.buffer.len() > FULL {
            self.flush()
        } else {
            Ok(())
        }
    }

    /// Removes the journal of a folder.
    ///
    /// # Errors
    /// When another run writes it, and when the system says no.
    pub fn remove(folder: &Path) -> Result<(), ResultsError> {
        let path = path_in(folder);
        let file = OpenOptions::new().append(true).open(&path);
        let _lock = Self::new(folder, path.clone(), file.map_err(ResultsError::io(&path))?)?;
        fs::remove_file(&path).map_err(ResultsError::io(&path))
    }

    fn finish_line(&mut self) {
        let sum = crc32fast::hash(self.line.as_bytes());
        // Writing to a Vec cannot fail.
        let _ = writeln!(self.buffer, "{sum:08x} {}", self.line);
        self.line.clear();
    }

    /// Hands everything to the operating system: from here on it survives the end of this process.
    ///
    /// # Errors
    /// When the system says no, such as on a full disk.
    pub fn flush(&mut self) -> Result<(), ResultsError> {
        let result = self.file.write_all(&self.buffer);
        self.buffer.clear();
        result.map_err(ResultsError::io(&self.path))
    }

    /// Waits until everything is on the disk: from here on it survives a power loss.
    ///
    /// # Errors
    /// When the system says no.
    pub fn sync(&mut self) -> Result<(), ResultsError> {
        self.flush()?;
        self.file.sync_data().map_err(ResultsError::io(&self.path))
    }
}

/// Appends all points of a folder's journal that count to another one.
///
/// # Errors
/// When either cannot be read or written.
pub fn copy(folder: &Path, into: &mut Journal) -> Result<(), ResultsError> {
    let finished = Finished::read(folder)?;
    let (mut lines, _) = open(folder)?;
    let path = path_in(folder);
    loop {
        let place = lines.place();
        let line = lines.next_line().map_err(ResultsError::io(&path))?;
        let Some(line) = line else { break };
        if finished.counts(line, place) {
            into.line.push_str(line);
            into.finish_line();
            into.flush_when_full()?;
        }
    }
    into.note(&Note::Conduct(finished.conduct()))?;
    into.flush()
}

#[cfg(test)]
#[path = "journal_tests.rs"]
mod tests;
