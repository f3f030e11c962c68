//! The journal: finished points, durable at once.
//!
//! A text file to which lines are only ever appended, in the order in which points finish. The
//! first line says what the study is. Every line carries a checksum, so that a line that was cut
//! off by a power loss or damaged by a bad disk is recognised and its point computed again. Lines on which others depend
//! come again from time to time:
//!
//! ```text
//! 5d41402a {"orchestrator":...,"points":50}
//! 7b502c3a 3 ok 4.802e1 8.155e1
//! 2b7c9f13 6 ok 4.795e1 8.158e1 {"warnings":2,"first_warning":"the oil is warm"}
//! 9a0b11c2 4 failed {"Error":"film rupture (fmi2DoStep)"}
//! 0d1e2f3a note {"Conduct":{"isolation":"fresh",...}}
//! ```
//!
//! A line that is written is final: nothing takes back what it says. What the FMU said beside the results, or before it failed,
//! stands behind them ([`Notices`]). An analysis that asks for several sets of points notes what tells each set from others,
//! `set 0 600 5d41402a`, and at last `end`. Where a set takes the place of another one, what followed that one counts no more.

use std::{
    fmt::Write as _,
    fs::{File, OpenOptions},
    io::{self, Write},
    path::{Path, PathBuf},
};

use tempfile::NamedTempFile;

use crate::{
    Error, PointOutcome, Result,
    files::{draft, keep, make_output},
    finished::Finished,
    header::Header,
    lines::{self, Line, open, path_in},
    note::{Note, PASSED, SAME_SET, SET},
};
use fmu_points::{notices::Notices, tell::one_line};

/// A journal that is being written.
#[derive(Debug)]
pub struct Journal {
    path: PathBuf,
    file: File,
    line: String,
    buffer: Vec<u8>,
    /// Lines on which others depend.
    header: String,
    set: Option<String>,
}

impl Journal {
    /// Begins a journal. It appears with its first line in place, or not at all.
    ///
    /// # Errors
    /// When there is one already, and when the system says no.
    pub fn create(folder: &Path, header: &Header) -> Result<Self> {
        let (draft, journal) = Self::draft(folder, header)?;
        draft.persist_noclobber(&journal.path).map_err(|error| match error.error.kind() {
            io::ErrorKind::AlreadyExists => Error::Begun(folder.to_owned()),
            _ => Error::io(&journal.path)(error.error),
        })?;
        Ok(journal)
    }

    /// Writes the journal of a folder anew, with another header and without damaged lines. It is replaced as a whole, or
    /// stays as it is.
    ///
    /// # Errors
    /// When the system says no.
    pub fn rewrite(folder: &Path, header: &Header) -> Result {
        let (draft, mut anew) = Self::draft(folder, header)?;
        anew.copy_lines(folder, |line, _| !line.starts_with('{'))?;
        anew.sync()?;
        Ok(keep(draft, &path_in(folder))?)
    }

    /// A journal with its first line, which is not yet in its place.
    fn draft(folder: &Path, header: &Header) -> Result<(NamedTempFile, Self)> {
        make_output(folder)?;
        let draft = draft(folder).map_err(Error::io(folder))?;
        let mut journal = Self::open(folder, draft.path(), header)?;
        journal.append_header();
        // Lines on which others depend are there twice from the beginning, so that no single damage costs more than its line.
        journal.append_header();
        journal.flush()?;
        Ok((draft, journal))
    }

    /// Continues a journal. A last line that was not written to its end is cut off; other damaged lines are told.
    ///
    /// # Errors
    /// When there is none, when it belongs to something else, and when the system says no.
    pub fn resume(folder: &Path, header: &Header) -> Result<(Self, Finished)> {
        header.check(&lines::header(folder)?, folder)?;
        let path = path_in(folder);
        let mut finished = Finished::read(folder)?;
        if let Some(what) = damage(finished.damaged) {
            let path = path.display();
            fmu_points::tell::line!("note: {what} of {path}: those points run again");
            Self::rewrite(folder, header)?;
            finished = Finished::read(folder)?;
        }
        let journal = Self::open(folder, &path, header)?;
        journal.file.set_len(finished.end).map_err(Error::io(&path))?;
        Ok((journal, finished))
    }

    /// Opens a file to append the lines of a folder's journal to it.
    fn open(folder: &Path, file: &Path, header: &Header) -> Result<Self> {
        let path = path_in(folder);
        let opened = OpenOptions::new().append(true).open(file);
        Ok(Self {
            file: opened.map_err(Error::io(&path))?,
            path,
            line: String::new(),
            buffer: Vec::new(),
            header: serde_json::to_string(header).expect("a header is texts and whole numbers"),
            set: None,
        })
    }

    /// The folder that it is in.
    pub fn folder(&self) -> &Path {
        self.path.parent().expect("a journal is a file in a folder")
    }

    /// Notes a finished point; [`flush`](Self::flush) hands it to the system.
    ///
    /// # Errors
    /// When the outcome cannot be written as text.
    pub fn append(&mut self, index: u64, outcome: &PointOutcome, notices: Option<&Notices>) -> Result {
        // Writing to a String cannot fail.
        let _ = match outcome {
            Ok(values) => {
                let _ = write!(self.line, "{index} {PASSED}");
                values.iter().try_for_each(|value| write!(self.line, " {value:e}"))
            }
            Err(failure) => {
                let text = serde_json::to_string(failure).expect("a failure is texts and numbers");
                write!(self.line, "{index} failed {text}")
            }
        };
        if let Some(notices) = notices {
            let text = serde_json::to_string(notices).expect("notices are texts and numbers");
            let _ = write!(self.line, " {text}");
        }
        self.finish_line();
        self.flush_when_full()
    }

    /// Notes what concerns many points.
    ///
    /// # Errors
    /// When the system says no.
    pub fn note(&mut self, note: &Note) -> Result {
        let text = serde_json::to_string(note).expect("a note is texts and numbers");
        self.append_line(&format!("note {text}"));
        self.flush_when_full()
    }

    /// Notes a set of points by what tells it from others; `first` is the index of its first point.
    ///
    /// # Errors
    /// When the system says no.
    pub fn append_set(&mut self, first: u64, sum: &str) -> Result {
        // That of the set before is in the journal twice then, also where that was a matter of a moment.
        self.append_same_set();
        self.append_line(&format!("{SET} {first} {sum}"));
        self.hold_set(first, sum);
        self.flush_when_full()
    }

    /// Knows the set to which the points that follow belong, when it is in the journal already.
    pub fn hold_set(&mut self, first: u64, sum: &str) {
        self.set = Some(format!("{SAME_SET} {first} {sum}"));
    }

    fn append_same_set(&mut self) {
        if let Some(set) = self.set.clone() {
            self.append_line(&set);
        }
    }

    fn append_header(&mut self) {
        self.append_line(&self.header.clone());
    }

    /// Notes that no further points are needed.
    pub fn append_end(&mut self) {
        self.append_line("end");
    }

    fn append_line(&mut self, line: &str) {
        self.line.push_str(line);
        self.finish_line();
    }

    fn flush_when_full(&mut self) -> Result {
        const FULL: usize = 1 << 16;
        if self.buffer.len() > FULL { self.flush() } else { Ok(()) }
    }

    /// Appends the sound lines of a folder's journal that `counts` takes, by their text and their place.
    fn copy_lines(&mut self, folder: &Path, counts: impl Fn(&str, u64) -> bool) -> Result {
        let (mut lines, _) = open(folder)?;
        loop {
            let place = lines.place();
            match lines.next_line().map_err(Error::io(&path_in(folder)))? {
                Line::Sound(line) if counts(line, place) => {
                    self.append_line(line);
                    self.flush_when_full()?;
                }
                Line::Sound(_) | Line::Damaged => {}
                Line::End => return Ok(()),
            }
        }
    }

    fn finish_line(&mut self) {
        let line = one_line(&self.line);
        let sum = crc32fast::hash(line.as_bytes());
        // Writing to a Vec cannot fail.
        let _ = writeln!(self.buffer, "{sum:08x} {line}");
        self.line.clear();
    }

    /// Hands everything to the operating system: from here on it survives the end of this process.
    ///
    /// # Errors
    /// When the system says no, such as on a full disk.
    pub fn flush(&mut self) -> Result {
        let result = self.file.write_all(&self.buffer);
        self.buffer.clear();
        result.map_err(Error::io(&self.path))
    }

    /// Waits until everything is on the disk: from here on it survives a power loss. Lines on which others depend come
    /// once more before, so that no single damage costs more than its line.
    ///
    /// # Errors
    /// When the system says no.
    pub fn sync(&mut self) -> Result {
        self.append_header();
        self.append_same_set();
        self.flush()?;
        self.file.sync_data().map_err(Error::io(&self.path))
    }
}

/// So many damaged lines, if there are any.
fn damage(lines: u64) -> Option<String> {
    let plural = if lines == 1 { "" } else { "s" };
    (lines > 0).then(|| format!("{lines} damaged line{plural}"))
}

/// Appends all points of a folder's journal that count to another one.
///
/// # Errors
/// When either cannot be read or written.
pub fn copy(folder: &Path, into: &mut Journal) -> Result {
    let finished = Finished::read(folder)?;
    if let Some(what) = damage(finished.damaged) {
        let path = path_in(folder);
        let path = path.display();
        fmu_points::tell::line!(
            "note: {what} of {path}: points that stood there are missing; run that part again with --resume"
        );
    }
    let mut sets: Vec<_> = finished.sets.iter().collect();
    sets.sort();
    for (first, sum) in sets {
        into.append_set(*first, sum)?;
    }
    into.copy_lines(folder, |line, place| finished.counts(line, place))?;
    // A part may be joined again, such as one that has grown.
    let name = finished.header.shard.clone().unwrap_or_else(|| folder.display().to_string());
    into.note(&Note::Part(name, finished.conduct()))?;
    into.flush()
}

#[cfg(test)]
#[path = "journal_tests.rs"]
mod tests;
