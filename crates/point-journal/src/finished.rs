//! The journal, read again.

use std::{
    collections::{BTreeMap, HashMap},
    fs::File,
    path::{Path, PathBuf},
};

use serde::Deserialize;

use crate::{
    Error, PointOutcome, Result,
    header::Header,
    lines::{Line, Lines, open, path_in},
    note::{Note, PASSED, SAME_SET, SET},
};
use fmu_points::{Conduct, failure::Failure, notices::Notices};

/// Index of a journal: the position of each finished point's line.
#[derive(Clone, Debug, Default)]
pub struct Finished {
    /// Identity of the run.
    pub header: Header,
    path: PathBuf,
    /// A place in the file for each point; [`NOWHERE`] when it is not finished.
    places: Vec<u64>,
    /// How the points were computed, as far as that is noted.
    noted: Option<Conduct>,
    /// The same of parts that were joined, by their names.
    parts: BTreeMap<String, Conduct>,
    /// How many points are finished.
    pub count: u64,
    /// Checksums of the sets of points, by the index of their first point.
    pub sets: HashMap<u64, String>,
    /// Whether the analysis needed no further points.
    pub ended: bool,
    /// Lines whose checksum is wrong, from a flipped bit or a bad block: their points are open.
    pub(crate) damaged: u64,
    /// The length of the file without a last line that was not written to its end.
    pub(crate) end: u64,
}

const NOWHERE: u64 = u64::MAX;

/// One position per point, 8 bytes each.
fn places(folder: &Path, points: u64) -> Result<Vec<u64>> {
    let mut places = Vec::new();
    let count = usize::try_from(points).unwrap_or(usize::MAX);
    places.try_reserve_exact(count).map_err(|_| {
        Error::content(&path_in(folder), format!("{points} points do not fit into the memory; use --shard"))
    })?;
    places.resize(count, NOWHERE);
    Ok(places)
}

impl Finished {
    /// Reads the journal of a folder.
    ///
    /// # Errors
    /// When there is none, when its header is lost, and when the system says no.
    pub fn read(folder: &Path) -> Result<Self> {
        let (mut lines, header) = open(folder)?;
        header.check_form(folder)?;
        let mut finished = Self {
            places: places(folder, header.points.unwrap_or(0))?,
            header,
            path: path_in(folder),
            ..Self::default()
        };
        loop {
            let place = lines.place();
            let line = lines.next_line();
            match line.map_err(Error::io(&finished.path))? {
                Line::Sound(line) => finished.take(line, place),
                Line::Damaged => finished.damaged += 1,
                Line::End => break,
            }
        }
        finished.end = lines.place();
        Ok(finished)
    }

    /// Notes what a line at this place says.
    fn take(&mut self, line: &str, place: u64) {
        match line.split_once(' ') {
            Some((word @ (SET | SAME_SET), set)) => {
                let (first, sum) = set.split_once(' ').unwrap_or((set, ""));
                let Ok(first) = first.parse() else { return };
                // The line at which the set began may be damaged; its points are no others for that.
                if word == SAME_SET && !self.sets.contains_key(&first) {
                    self.sets.insert(first, sum.to_owned());
                } else {
                    self.begin_set(first, sum);
                }
            }
            Some(("note", note)) => {
                let note = serde_json::from_str(note);
                note.into_iter().for_each(|note| self.heed(note));
            }
            Some((index, _)) => self.note(index.parse().ok(), place),
            None => self.ended |= line == "end",
        }
    }

    fn heed(&mut self, note: Note) {
        match note {
            Note::Conduct(new) => {
                let known = self.noted.take();
                self.noted = Some(known.map_or_else(|| new.clone(), |known| known.and(new.clone())));
            }
            Note::Part(name, conduct) => {
                self.parts.insert(name, conduct);
            }
        }
    }

    /// How the points were computed.
    pub fn conduct(&self) -> Conduct {
        self.parts.values().chain(&self.noted).cloned().reduce(Conduct::and).unwrap_or_default()
    }

    /// The file that the FMU changes in its own folder, where that was found.
    pub fn changed_file(&self) -> Option<&str> {
        let mut notes = self.parts.values().chain(&self.noted);
        notes.find_map(|noted| noted.changed_file.as_deref())
    }

    /// Whether a line at this place is that of a finished point, and not of one that was computed again.
    pub(crate) fn counts(&self, line: &str, place: u64) -> bool {
        let index = line.split(' ').next().and_then(|text| text.parse().ok());
        index.is_some_and(|index| self.place(index) == Some(place))
    }

    /// The finished points, in their order.
    pub fn points(&self) -> impl Iterator<Item = u64> + '_ {
        (0..).zip(&self.places).filter(|(_, place)| **place != NOWHERE).map(|(index, _)| index)
    }

    /// Where the line of a finished point is.
    fn place(&self, index: u64) -> Option<u64> {
        let place = *self.places.get(usize::try_from(index).ok()?)?;
        (place != NOWHERE).then_some(place)
    }

    /// A set that differs from the one that began here makes an end of all that followed that. So does one that is not
    /// known: nothing says that points which are there already are its own.
    pub fn begin_set(&mut self, first: u64, sum: &str) {
        if self.sets.get(&first).is_none_or(|then| then != sum) {
            self.forget_from(first);
        }
        self.sets.insert(first, sum.to_owned());
    }

    /// Forgets all points from an index on.
    fn forget_from(&mut self, first: u64) {
        self.sets.retain(|&other, _| other < first);
        (first..self.places.len() as u64).for_each(|index| self.forget(index));
    }

    /// Forgets a point.
    fn forget(&mut self, index: u64) {
        let slot = &mut self.places[index as usize];
        self.count -= u64::from(*slot != NOWHERE);
        *slot = NOWHERE;
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
        self.place(index).is_some()
    }

    /// Reads outcomes, in whatever order they are asked for.
    ///
    /// # Errors
    /// When the journal cannot be opened.
    pub fn outcomes(&self) -> Result<Outcomes<'_>> {
        let file = File::open(&self.path).map_err(Error::io(&self.path))?;
        Ok(Outcomes { finished: self, lines: Lines::new(file), width: None })
    }
}

/// An outcome, with what the FMU said beside its results if it said anything.
pub type Noted = (PointOutcome, Option<Notices>);

/// Reads outcomes from a journal.
pub struct Outcomes<'a> {
    finished: &'a Finished,
    lines: Lines,
    /// How many values a point has.
    width: Option<usize>,
}

impl Outcomes<'_> {
    /// The outcome of a point, if it is finished.
    ///
    /// # Errors
    /// When the journal cannot be read any more.
    pub fn get(&mut self, index: u64) -> Result<Option<PointOutcome>> {
        Ok(self.get_noted(index)?.map(|(outcome, _)| outcome))
    }

    /// The outcome of a point, if it is finished, and what the FMU said beside its results.
    ///
    /// # Errors
    /// When the journal cannot be read any more.
    pub fn get_noted(&mut self, index: u64) -> Result<Option<Noted>> {
        let path = &self.finished.path;
        let Some(place) = self.finished.place(index) else { return Ok(None) };
        self.lines.seek(place).map_err(Error::io(path))?;
        let noted = match self.lines.next_line().map_err(Error::io(path))? {
            Line::Sound(line) => parse(line),
            Line::Damaged | Line::End => None,
        };
        let damaged = || format!("the line of point {} is damaged", index + 1);
        // All points have as many values.
        let noted = noted
            .filter(|(outcome, _)| {
                let count = outcome.as_ref().ok().map(Vec::len);
                count.is_none_or(|count| *self.width.get_or_insert(count) == count)
            })
            .ok_or_else(|| Error::content(path, damaged()))?;
        Ok(Some(noted))
    }
}

fn parse(line: &str) -> Option<Noted> {
    let mut parts = line.splitn(3, ' ');
    let (_, word) = (parts.next()?, parts.next()?);
    let rest = parts.next().unwrap_or("");
    match word {
        PASSED => {
            let (values, notices) = rest.split_at(rest.find('{').unwrap_or(rest.len()));
            let values = values.split_ascii_whitespace().map(|text| text.parse().ok());
            let notices = match notices {
                "" => None,
                text => Some(serde_json::from_str(text).ok()?),
            };
            Some((Ok(values.collect::<Option<_>>()?), notices))
        }
        "failed" => {
            let mut texts = serde_json::Deserializer::from_str(rest);
            let failure = Failure::deserialize(&mut texts).ok()?;
            // Nothing follows where nothing was said.
            let notices = Notices::deserialize(&mut texts).ok();
            Some((Err(failure), notices))
        }
        _ => None,
    }
}
