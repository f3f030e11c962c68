//! The lines of a journal, checked.

use crate::{Error, Result, header::Header};
use std::{
    fs::File,
    io::{self, BufRead, BufReader, Seek, SeekFrom},
    path::{Path, PathBuf},
};

/// The journal's place in an output folder.
pub fn path_in(folder: &Path) -> PathBuf {
    folder.join("journal.txt")
}

/// Which study, FMU and points the journal of a folder belongs to.
///
/// # Errors
/// When there is none, and when no copy of its header is left.
pub fn header(folder: &Path) -> Result<Header> {
    Ok(open(folder)?.1)
}

/// Opens the journal of a folder and reads its header: the first line, or a copy of it further on.
pub(crate) fn open(folder: &Path) -> Result<(Lines, Header)> {
    let path = path_in(folder);
    let file = File::open(&path).map_err(|error| match error.kind() {
        io::ErrorKind::NotFound => Error::Missing(folder.to_owned()),
        _ => Error::io(&path)(error),
    })?;
    let mut lines = Lines::new(file);
    let header = loop {
        match lines.next_line().map_err(Error::io(&path))? {
            Line::Sound(text) if text.starts_with('{') => {
                break serde_json::from_str(text).ok();
            }
            Line::Sound(_) | Line::Damaged => {}
            Line::End => break None,
        }
    };
    let damaged = "the line that says which study this is is damaged, and so are its copies; begin again with --force";
    let header = header.ok_or_else(|| Error::content(&path, damaged))?;
    lines.seek(0).map_err(Error::io(&path))?;
    Ok((lines, header))
}

/// A line of the file.
pub(crate) enum Line<'a> {
    /// Its checksum is right; this is what stands behind it.
    Sound(&'a str),
    /// Its checksum is wrong.
    Damaged,
    /// There is none, or one that was not written to its end.
    End,
}

/// Lines, one after the other.
pub(crate) struct Lines {
    reader: BufReader<File>,
    line: Vec<u8>,
    /// Position at which the next line begins.
    place: u64,
}

impl Lines {
    pub fn new(file: File) -> Self {
        Self { reader: BufReader::with_capacity(1 << 16, file), line: Vec::new(), place: 0 }
    }

    /// Position at which the next line begins.
    pub fn place(&self) -> u64 {
        self.place
    }

    pub fn seek(&mut self, place: u64) -> io::Result<()> {
        match i64::try_from(i128::from(place) - i128::from(self.place)) {
            // Stays in the buffer where that holds the place.
            Ok(distance) => self.reader.seek_relative(distance)?,
            Err(_) => self.reader.seek(SeekFrom::Start(place)).map(drop)?,
        }
        self.place = place;
        Ok(())
    }

    /// The next line without its checksum.
    pub fn next_line(&mut self) -> io::Result<Line<'_>> {
        self.line.clear();
        let length = self.reader.read_until(b'\n', &mut self.line)? as u64;
        let Some(line) = self.line.strip_suffix(b"\n") else {
            self.reader.seek_relative(-i64::try_from(length).unwrap_or(i64::MAX))?;
            return Ok(Line::End);
        };
        self.place += length;
        Ok(checked(line).map_or(Line::Damaged, Line::Sound))
    }
}

/// The text of a line whose checksum is right.
fn checked(line: &[u8]) -> Option<&str> {
    let (sum, text) = std::str::from_utf8(line).ok()?.split_once(' ')?;
    (u32::from_str_radix(sum, 16).ok()? == crc32fast::hash(text.as_bytes())).then_some(text)
}
