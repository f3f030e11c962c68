//! The lines of a journal, checked.

use std::fs::File;
use std::io::{self, BufRead, BufReader, Seek, SeekFrom};
use std::path::{Path, PathBuf};

use super::ResultsError;
use super::header::Header;

/// The journal's place in an output folder.
pub fn path_in(folder: &Path) -> PathBuf {
    folder.join("journal.txt")
}

/// Which study, FMU and points the journal of a folder belongs to.
///
/// # Errors
/// When there is none, and when its first line is damaged.
pub fn header(folder: &Path) -> Result<Header, ResultsError> {
    Ok(open(folder)?.1)
}

/// Opens the journal of a folder and reads its first line.
pub(super) fn open(folder: &Path) -> Result<(Lines, Header), ResultsError> {
    let path = path_in(folder);
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

/// Lines whose checksums are right.
#[derive(Debug)]
pub(super) struct Lines {
    reader: BufReader<File>,
    line: Vec<u8>,
    /// Position at which the intact lines end.
    pub(super) sound: u64,
}

impl Lines {
    pub(super) fn new(file: File) -> Self {
        Self {
            reader: BufReader::with_capacity(1 << 16, file),
            line: Vec::new(),
            sound: 0,
        }
    }

    /// Position at which the next line begins.
    pub(super) fn place(&self) -> u64 {
        self.sound
    }

    pub(super) fn seek(&mut self, place: u64) -> io::Result<()> {
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
