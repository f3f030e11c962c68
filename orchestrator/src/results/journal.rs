//! The journal: finished points, durable at once.
//!
//! A text file to which lines are only ever appended, in the order in which points finish. The
//! first line says what the study is. Every line carries a checksum, so that a line that was cut
//! off by a power loss or a full disk is recognised and its point computed again:
//!
//! ```text
//! 5d41402a {"orchestrator":...,"points":50}
//! 7b502c3a 3 ok 4.802e1 8.155e1
//! 9a0b11c2 4 failed {"Error":"film rupture (fmi2DoStep)"}
//! ```

use std::fmt::Write as _;
use std::fs::{self, File, OpenOptions, TryLockError};
use std::io::{self, BufRead, BufReader, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use super::{Outcome, ResultsError};

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
        for ((what, now), (_, then)) in texts(self).into_iter().zip(texts(then)) {
            if now != then {
                let path = path.to_owned();
                return Err(ResultsError::Changed {
                    path,
                    what,
                    then,
                    now,
                });
            }
        }
        Ok(())
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
    pub fn append(&mut self, index: u64, outcome: &Outcome) -> Result<(), ResultsError> {
        // Writing to a String cannot fail.
        match outcome {
            Ok(values) => {
                let _ = write!(self.line, "{index} ok");
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

/// Opens the journal of a folder and reads its first line.
fn open(folder: &Path) -> Result<(Lines, Header), ResultsError> {
    let path = Journal::path_in(folder);
    let file = File::open(&path).map_err(|error| match error.kind() {
        io::ErrorKind::NotFound => ResultsError::Missing(folder.to_owned()),
        _ => ResultsError::io(&path)(error),
    })?;
    let mut lines = Lines::new(file);
    let header = lines.next_line().map_err(ResultsError::io(&path))?;
    let header = header.and_then(|line| serde_json::from_str(line).ok());
    let header = header.ok_or_else(|| ResultsError::Content {
        path,
        message: "the first line is damaged; delete the folder and begin again".to_owned(),
    })?;
    Ok((lines, header))
}

/// Appends all points of a folder's journal to another one.
///
/// # Errors
/// When either cannot be read or written.
pub fn copy(folder: &Path, into: &mut Journal) -> Result<(), ResultsError> {
    let (mut lines, _) = open(folder)?;
    let path = Journal::path_in(folder);
    while let Some(line) = lines.next_line().map_err(ResultsError::io(&path))? {
        into.line.push_str(line);
        into.finish_line();
        into.flush_when_full()?;
    }
    into.flush()
}

/// What a journal holds: where the line of each finished point is.
#[derive(Debug)]
pub struct Finished {
    /// What the journal belongs to.
    pub header: Header,
    path: PathBuf,
    /// A place in the file for each point; [`NOWHERE`] when it is not finished.
    places: Vec<u64>,
    /// How many points are finished.
    pub count: u64,
    /// The length of the sound part of the file.
    sound: u64,
}

const NOWHERE: u64 = u64::MAX;

/// As many places as points: 8 bytes each.
fn places(folder: &Path, points: u64) -> Result<Vec<u64>, ResultsError> {
    let mut places = Vec::new();
    let count = usize::try_from(points).unwrap_or(usize::MAX);
    let room = places.try_reserve_exact(count);
    room.map_err(|_| ResultsError::Content {
        path: Journal::path_in(folder),
        message: format!("{points} points do not fit into the memory; use --shard"),
    })?;
    places.resize(count, NOWHERE);
    Ok(places)
}

impl Finished {
    /// Reads the journal of a folder.
    ///
    /// # Errors
    /// When there is none, when its first line is damaged, and when the system says no.
    pub fn read(folder: &Path) -> Result<Self, ResultsError> {
        let (mut lines, header) = open(folder)?;
        let mut finished = Self {
            places: places(folder, header.points)?,
            header,
            path: Journal::path_in(folder),
            count: 0,
            sound: lines.sound,
        };
        loop {
            let place = lines.sound;
            let line = lines
                .next_line()
                .map_err(ResultsError::io(&finished.path))?;
            let Some(line) = line else { break };
            let index = line
                .split(' ')
                .next()
                .and_then(|text| text.parse::<usize>().ok());
            if let Some(slot) = index.and_then(|index| finished.places.get_mut(index)) {
                finished.count += u64::from(*slot == NOWHERE);
                *slot = place;
            }
        }
        finished.sound = lines.sound;
        Ok(finished)
    }

    /// Whether a point is finished.
    pub fn has(&self, index: u64) -> bool {
        let place = usize::try_from(index)
            .ok()
            .and_then(|index| self.places.get(index));
        place.is_some_and(|&place| place != NOWHERE)
    }

    /// Reads outcomes, in whatever order they are asked for.
    ///
    /// # Errors
    /// When the journal cannot be opened.
    pub fn outcomes(&self) -> Result<Outcomes<'_>, ResultsError> {
        let file = File::open(&self.path).map_err(ResultsError::io(&self.path))?;
        Ok(Outcomes {
            finished: self,
            lines: Lines::new(file),
        })
    }
}

/// Reads outcomes from a journal.
#[derive(Debug)]
pub struct Outcomes<'a> {
    finished: &'a Finished,
    lines: Lines,
}

impl Outcomes<'_> {
    /// The outcome of a point, if it is finished.
    ///
    /// # Errors
    /// When the journal cannot be read any more.
    pub fn get(&mut self, index: u64) -> Result<Option<Outcome>, ResultsError> {
        let path = &self.finished.path;
        if !self.finished.has(index) {
            return Ok(None);
        }
        // `has` has checked the index.
        let place = usize::try_from(index).map_or(NOWHERE, |index| self.finished.places[index]);
        self.lines.seek(place).map_err(ResultsError::io(path))?;
        let line = self.lines.next_line().map_err(ResultsError::io(path))?;
        let outcome = line.and_then(parse).ok_or_else(|| ResultsError::Content {
            path: path.clone(),
            message: format!("the line of point {} is damaged", index + 1),
        })?;
        Ok(Some(outcome))
    }
}

fn parse(line: &str) -> Option<Outcome> {
    let mut parts = line.splitn(3, ' ');
    let (_, word) = (parts.next()?, parts.next()?);
    let rest = parts.next().unwrap_or("");
    match word {
        "ok" => {
            let values = rest.split_ascii_whitespace().map(|text| text.parse().ok());
            Some(Ok(values.collect::<Option<_>>()?))
        }
        "failed" => Some(Err(serde_json::from_str(rest).ok()?)),
        _ => None,
    }
}

/// Lines whose checksums are right.
#[derive(Debug)]
struct Lines {
    reader: BufReader<File>,
    line: Vec<u8>,
    /// Where the sound lines end.
    sound: u64,
}

impl Lines {
    fn new(file: File) -> Self {
        Self {
            reader: BufReader::with_capacity(1 << 16, file),
            line: Vec::new(),
            sound: 0,
        }
    }

    fn seek(&mut self, place: u64) -> io::Result<()> {
        match i64::try_from(i128::from(place) - i128::from(self.sound)) {
            // Stays in the buffer where that holds the place.
            Ok(distance) => self.reader.seek_relative(distance)?,
            Err(_) => self.reader.seek(SeekFrom::Start(place)).map(drop)?,
        }
        self.sound = place;
        Ok(())
    }

    /// The next sound line without its checksum; `None` at the end, or where damage begins.
    fn next_line(&mut self) -> io::Result<Option<&str>> {
        self.line.clear();
        let length = self.reader.read_until(b'\n', &mut self.line)?;
        let Some(line) = self.line.strip_suffix(b"\n") else {
            return Ok(None);
        };
        let Some((sum, text)) = std::str::from_utf8(line)
            .ok()
            .and_then(|line| line.split_once(' '))
        else {
            return Ok(None);
        };
        if u32::from_str_radix(sum, 16).ok() != Some(crc32fast::hash(text.as_bytes())) {
            return Ok(None);
        }
        self.sound += length as u64;
        Ok(Some(text))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::failure::Failure;

    fn header() -> Header {
        Header {
            orchestrator: "1".to_owned(),
            study: "s".to_owned(),
            fmu: "f".to_owned(),
            table: None,
            seed: 1,
            points: 5,
            shard: None,
        }
    }

    fn written() -> (tempfile::TempDir, Vec<Outcome>) {
        let folder = tempfile::tempdir().unwrap();
        let outcomes = vec![
            Ok(vec![1.0 / 3.0, -2e-300]),
            Err(Failure::Error("it \"broke\"\nbadly".to_owned())),
            Ok(vec![0.1, 82.0]),
        ];
        let mut journal = Journal::create(folder.path(), &header()).unwrap();
        for (index, outcome) in [(3, 0), (0, 1), (1, 2)] {
            journal.append(index, &outcomes[outcome]).unwrap();
        }
        journal.sync().unwrap();
        (folder, outcomes)
    }

    #[test]
    fn what_was_written_comes_back_exactly() {
        let (folder, outcomes) = written();
        let finished = Finished::read(folder.path()).unwrap();
        assert_eq!(finished.count, 3);
        let mut reader = finished.outcomes().unwrap();
        for (index, outcome) in [(0, 1), (1, 2), (3, 0)] {
            assert_eq!(
                reader.get(index).unwrap().as_ref(),
                Some(&outcomes[outcome])
            );
        }
        assert_eq!(reader.get(2).unwrap(), None);
    }

    #[test]
    fn a_damaged_end_is_cut_off_wherever_it_begins() {
        let (folder, _) = written();
        let path = Journal::path_in(folder.path());
        let whole = fs::read(&path).unwrap();
        let header_end = whole.iter().position(|&byte| byte == b'\n').unwrap() + 1;
        for end in header_end..=whole.len() {
            fs::write(&path, &whole[..end]).unwrap();
            let (mut journal, finished) = Journal::resume(folder.path(), &header()).unwrap();
            let complete = whole[header_end..end]
                .iter()
                .filter(|&&byte| byte == b'\n')
                .count();
            assert_eq!(finished.count, complete as u64);
            journal.append(4, &Ok(vec![1.0])).unwrap();
            journal.flush().unwrap();
            let again = Finished::read(folder.path()).unwrap();
            assert_eq!(again.count, complete as u64 + 1);
        }
    }

    #[test]
    fn a_changed_study_is_refused_with_what_differs() {
        let (folder, _) = written();
        let now = Header {
            seed: 2,
            ..header()
        };
        let error = Journal::resume(folder.path(), &now).unwrap_err();
        assert!(
            error.to_string().contains("another seed (1 then, 2 now)"),
            "{error}"
        );
        let error = Journal::create(folder.path(), &header()).unwrap_err();
        assert!(matches!(error, ResultsError::Begun(_)));
    }
}
