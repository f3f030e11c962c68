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
//! 9a0b11c2 4 failed {"Error":"film rupture (fmi2DoStep)"}
//! 0d1e2f3a note {"Void":"Used"}
//! ```
//!
//! `ok`, `forked` and `used` tell in what process a point was computed ([`Separation`]): a note may say that some of
//! these do not count any more.

use std::fmt::Write as _;
use std::fs::{self, File, OpenOptions, TryLockError};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use super::finished::open;
use super::{Outcome, ResultsError};
use crate::engine::{Conduct, Separation};

pub use super::finished::Finished;

/// What a journal belongs to. Points of different headers must not be mixed.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Header {
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
    /// How many points the whole study has.
    pub points: u64,
    /// Which part of the points this is, such as `2/8`.
    pub shard: Option<String>,
}

impl Header {
    /// What the journal of a folder belongs to.
    ///
    /// # Errors
    /// When there is none, and when its first line is damaged.
    pub fn read(folder: &Path) -> Result<Self, ResultsError> {
        Ok(open(folder)?.1)
    }

    /// Refuses points that were computed for something else.
    ///
    /// # Errors
    /// Names what differs.
    pub fn check(&self, then: &Self, path: &Path) -> Result<(), ResultsError> {
        match self.difference(then) {
            None => Ok(()),
            Some((what, then, now)) => Err(ResultsError::Changed {
                path: path.to_owned(),
                what,
                then,
                now,
            }),
        }
    }

    /// What differs first, as it is in the other header and in this one.
    pub fn difference(&self, then: &Self) -> Option<(&'static str, String, String)> {
        let texts = |header: &Self| {
            [
                ("orchestrator", header.orchestrator.clone()),
                ("study", short(&header.study)),
                ("FMU", short(&header.fmu)),
                (
                    "table of points",
                    header.table.as_deref().map_or_else(String::new, short),
                ),
                ("seed", header.seed.to_string()),
                ("number of points", header.points.to_string()),
                (
                    "shard",
                    header.shard.clone().unwrap_or_else(|| "none".to_owned()),
                ),
            ]
        };
        let pairs = texts(self).into_iter().zip(texts(then));
        pairs
            .filter(|(now, then)| now != then)
            .map(|((what, now), (_, then))| (what, then, now))
            .next()
    }
}

/// The first digits of a digest, for people.
fn short(digest: &str) -> String {
    digest.chars().take(12).collect()
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
    /// The journal's place in an output folder.
    pub fn path_in(folder: &Path) -> PathBuf {
        folder.join("journal.txt")
    }

    /// Begins a journal. It appears with its first line in place, or not at all.
    ///
    /// # Errors
    /// When there is one already, and when the system says no.
    pub fn create(folder: &Path, header: &Header) -> Result<Self, ResultsError> {
        let path = Self::path_in(folder);
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
        draft
            .persist_noclobber(&journal.path)
            .map_err(|error| match error.error.kind() {
                io::ErrorKind::AlreadyExists => ResultsError::Begun(folder.to_owned()),
                _ => ResultsError::io(&journal.path)(error.error),
            })?;
        Ok(journal)
    }

    /// Continues a journal; a damaged end is cut off.
    ///
    /// # Errors
    /// When there is none, when it belongs to something else, and when the system says no.
    pub fn resume(folder: &Path, header: &Header) -> Result<(Self, Finished), ResultsError> {
        let finished = Finished::read(folder)?;
        header.check(&finished.header, folder)?;
        let path = Self::path_in(folder);
        let file = OpenOptions::new().append(true).open(&path);
        let file = file.map_err(ResultsError::io(&path))?;
        let journal = Self::new(folder, path, file)?;
        // Read again under the lock: another run may just have ended.
        let finished = Finished::read(folder)?;
        let cut = journal.file.set_len(finished.sound);
        cut.map_err(ResultsError::io(&journal.path))?;
        Ok((journal, finished))
    }

    /// Takes the file for this run alone; the lock ends with the process, however it ends.
    fn new(folder: &Path, path: PathBuf, file: File) -> Result<Self, ResultsError> {
        match file.try_lock() {
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
    ) -> Result<(), ResultsError> {
        // Writing to a String cannot fail.
        match outcome {
            Ok(values) => {
                let _ = write!(self.line, "{index} {}", word(separation));
                for value in values {
                    let _ = write!(self.line, " {value:e}");
                }
            }
            Err(failure) => {
                let text = serde_json::to_string(failure).unwrap_or_default();
                let _ = write!(self.line, "{index} failed {text}");
            }
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
        let path = Self::path_in(folder);
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

/// What concerns many points.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Note {
    /// How points were computed since the last such note.
    Conduct(Conduct),
    /// The points so far that were computed in such processes, or in less strictly separated ones, do not count.
    Void(Separation),
}

/// How a line names the process of a point that has results.
fn word(separation: Separation) -> &'static str {
    match separation {
        Separation::New => "ok",
        Separation::Forked => "forked",
        Separation::Used => "used",
    }
}

/// The process that a line names.
pub(super) fn separation(word: &str) -> Option<Separation> {
    let all = [Separation::New, Separation::Forked, Separation::Used];
    all.into_iter()
        .find(|separation| self::word(*separation) == word)
}

/// Appends all points of a folder's journal that count to another one.
///
/// # Errors
/// When either cannot be read or written.
pub fn copy(folder: &Path, into: &mut Journal) -> Result<(), ResultsError> {
    let finished = Finished::read(folder)?;
    let (mut lines, _) = open(folder)?;
    let path = Journal::path_in(folder);
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
    if let Some(conduct) = finished.conduct {
        into.note(&Note::Conduct(conduct))?;
    }
    into.flush()
}

#[cfg(test)]
#[path = "journal_tests.rs"]
mod tests;
