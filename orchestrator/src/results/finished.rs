//! The journal, read again.

use std::fs::File;
use std::io::{self, BufRead, BufReader, Seek, SeekFrom};
use std::path::{Path, PathBuf};

use super::journal::{Header, Journal, Note, separation};
use super::{Outcome, ResultsError};
use crate::engine::{Conduct, Isolation, Separation};

/// Opens the journal of a folder and reads its first line.
pub(super) fn open(folder: &Path) -> Result<(Lines, Header), ResultsError> {
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

/// What a journal holds: where the line of each finished point is.
#[derive(Debug)]
pub struct Finished {
    /// What the journal belongs to.
    pub header: Header,
    path: PathBuf,
    /// A place in the file for each point, with its separation in the bits above [`SEPARATION`]; [`NOWHERE`] when it is
    /// not finished.
    places: Vec<u64>,
    /// How the points were computed, where that is noted.
    pub conduct: Option<Conduct>,
    /// How many points are finished.
    pub count: u64,
    /// The length of the sound part of the file.
    pub(super) sound: u64,
}

const NOWHERE: u64 = u64::MAX;
/// Files are shorter than 2^62 bytes.
const SEPARATION: u32 = 62;

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
            conduct: None,
        };
        loop {
            let place = lines.sound;
            let line = lines
                .next_line()
                .map_err(ResultsError::io(&finished.path))?;
            let Some(line) = line else { break };
            let (first, rest) = line.split_once(' ').unwrap_or((line, ""));
            let index = first.parse::<usize>().ok();
            if let Some(slot) = index.and_then(|index| finished.places.get_mut(index)) {
                finished.count += u64::from(*slot == NOWHERE);
                let word = rest.split(' ').next().unwrap_or("");
                let separation = separation(word).unwrap_or(Separation::New);
                *slot = place | (separation as u64) << SEPARATION;
            } else if first == "note" {
                let note = serde_json::from_str(rest);
                note.into_iter().for_each(|note| finished.heed(note));
            }
        }
        finished.sound = lines.sound;
        Ok(finished)
    }

    fn heed(&mut self, note: Note) {
        match note {
            Note::Conduct(new) => {
                self.conduct = Some(self.conduct.map_or(new, |old| old.and(new)));
            }
            Note::Void(separation) => {
                for slot in &mut self.places {
                    if *slot != NOWHERE && *slot >> SEPARATION >= separation as u64 {
                        *slot = NOWHERE;
                        self.count -= 1;
                    }
                }
                if let Some(conduct) = &mut self.conduct {
                    conduct.isolation = Isolation::Fresh;
                }
            }
        }
    }

    /// Whether a line at this place is that of a finished point, and not of one that was computed again.
    pub(super) fn counts(&self, line: &str, place: u64) -> bool {
        let index = line.split(' ').next().and_then(|text| text.parse().ok());
        index.is_some_and(|index| self.place(index) == Some(place))
    }

    /// The finished points that were computed in such processes, or in less strictly separated ones.
    pub fn of(&self, separation: Separation) -> Vec<u64> {
        let slots = (0..).zip(&self.places);
        let wanted = |slot: u64| slot != NOWHERE && slot >> SEPARATION >= separation as u64;
        slots
            .filter(|(_, slot)| wanted(**slot))
            .map(|(index, _)| index)
            .collect()
    }

    /// Where the line of a finished point is.
    fn place(&self, index: u64) -> Option<u64> {
        let slot = *self.places.get(usize::try_from(index).ok()?)?;
        (slot != NOWHERE).then_some(slot & ((1 << SEPARATION) - 1))
    }

    /// Whether a point is finished.
    pub fn has(&self, index: u64) -> bool {
        self.place(index).is_some()
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
        let Some(place) = self.finished.place(index) else {
            return Ok(None);
        };
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
        word if separation(word).is_some() => {
            let values = rest.split_ascii_whitespace().map(|text| text.parse().ok());
            Some(Ok(values.collect::<Option<_>>()?))
        }
        "failed" => Some(Err(serde_json::from_str(rest).ok()?)),
        _ => None,
    }
}

/// Lines whose checksums are right.
#[derive(Debug)]
pub(super) struct Lines {
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

    /// Where the next line begins.
    pub(super) fn place(&self) -> u64 {
        self.sound
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
    pub(super) fn next_line(&mut self) -> io::Result<Option<&str>> {
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
