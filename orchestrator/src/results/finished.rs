//! The journal, read again.

use std::collections::HashMap;
use std::fs::File;
use std::path::{Path, PathBuf};

use super::header::Header;
use super::lines::{Lines, open, path_in};
use super::{Outcome, ResultsError};

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
    /// What tells the sets of points from others, by the index of their first point.
    pub sets: HashMap<u64, String>,
    /// Whether the analysis needed no further points.
    pub ended: bool,
    /// The length of the sound part of the file.
    pub(super) sound: u64,
}

const NOWHERE: u64 = u64::MAX;

/// As many places as points: 8 bytes each.
fn places(folder: &Path, points: u64) -> Result<Vec<u64>, ResultsError> {
    let mut places = Vec::new();
    let count = usize::try_from(points).unwrap_or(usize::MAX);
    let room = places.try_reserve_exact(count);
    room.map_err(|_| ResultsError::Content {
        path: path_in(folder),
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
            places: places(folder, header.points.unwrap_or(0))?,
            header,
            path: path_in(folder),
            count: 0,
            sets: HashMap::new(),
            ended: false,
            sound: lines.sound,
        };
        loop {
            let place = lines.sound;
            let line = lines
                .next_line()
                .map_err(ResultsError::io(&finished.path))?;
            let Some(line) = line else { break };
            match line.split_once(' ') {
                Some(("set", set)) => {
                    let (first, sum) = set.split_once(' ').unwrap_or((set, ""));
                    if let Ok(first) = first.parse() {
                        finished.begin_set(first, sum);
                    }
                }
                Some((index, _)) => finished.note(index.parse().ok(), place),
                None => finished.ended |= line == "end",
            }
        }
        finished.sound = lines.sound;
        Ok(finished)
    }

    /// A set that differs from the one that began here makes an end of all that followed that.
    fn begin_set(&mut self, first: u64, sum: &str) {
        if self.sets.get(&first).is_some_and(|then| then != sum) {
            self.forget_from(first);
        }
        self.sets.insert(first, sum.to_owned());
    }

    /// Forgets all points from an index on.
    pub fn forget_from(&mut self, first: u64) {
        self.sets.retain(|&other, _| other < first);
        let first = usize::try_from(first).unwrap_or(usize::MAX);
        for slot in self.places.iter_mut().skip(first) {
            self.count -= u64::from(*slot != NOWHERE);
            *slot = NOWHERE;
        }
    }

    fn note(&mut self, index: Option<usize>, place: u64) {
        let Some(index) = index else { return };
        if self.header.points.is_none() && index >= self.places.len() {
            self.places.resize(index + 1, NOWHERE);
        }
        if let Some(slot) = self.places.get_mut(index) {
            self.count += u64::from(*slot == NOWHERE);
            *slot = place;
        }
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
