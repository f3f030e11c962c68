//! The central directory of a zip archive, read for names that come twice: the crate `zip` keeps the last of them.

use std::collections::HashSet;
use std::fs::File;
use std::io::{self, BufReader, Read, Seek, SeekFrom};
use std::path::Path;

/// An entry of the directory: its mark, and how many bytes stand before its name.
const MARK: [u8; 4] = *b"PK\x01\x02";
const HEAD: usize = 46;

/// The names that more than one entry of the directory has, each once.
pub(crate) fn names_twice(path: &Path, start: u64) -> io::Result<Vec<String>> {
    let mut file = BufReader::new(File::open(path)?);
    file.seek(SeekFrom::Start(start))?;
    let (mut seen, mut twice) = (HashSet::new(), Vec::new());
    while let Some(name) = next_name(&mut file)? {
        if let Some(name) = seen.replace(name)
            && !twice.contains(&name)
        {
            twice.push(name);
        }
    }
    let text = |name: Vec<u8>| String::from_utf8_lossy(&name).into_owned();
    Ok(twice.into_iter().map(text).collect())
}

/// The name of the next entry, or none after the last one.
fn next_name(file: &mut BufReader<File>) -> io::Result<Option<Vec<u8>>> {
    let mut head = [0; HEAD];
    match file.read_exact(&mut head) {
        Err(error) if error.kind() == io::ErrorKind::UnexpectedEof => return Ok(None),
        read => read?,
    }
    if !head.starts_with(&MARK) {
        return Ok(None);
    }
    let length = |at: usize| u16::from_le_bytes([head[at], head[at + 1]]);
    let mut name = vec![0; length(28).into()];
    file.read_exact(&mut name)?;
    file.seek_relative(i64::from(length(30)) + i64::from(length(32)))?;
    Ok(Some(name))
}
