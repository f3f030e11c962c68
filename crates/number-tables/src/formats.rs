//! The formats in which a table may stand. A new one is a file with its [`crate::Rows`] and a line in [`FORMATS`].

use std::path::Path;

use crate::files::FileError;
use crate::rows::{How, Rows};
use crate::{csv_file, parquet};

type Open = fn(&Path, How) -> Result<Box<dyn Rows>, FileError>;

/// Endings of files' names in lower case, and who reads them. Other files are taken for the first one's.
const FORMATS: [(&[&str], Open); 2] = [(&["csv"], csv_file::rows), (&["parquet"], parquet::rows)];

fn format(path: &Path) -> Option<Open> {
    let ending = path.extension()?.to_ascii_lowercase();
    let known = |(endings, _): &&(&[&str], Open)| endings.iter().any(|known| ending == *known);
    FORMATS.iter().find(known).map(|(_, open)| *open)
}

/// Whether a file's name ends as that of a table.
pub fn is_table(path: &Path) -> bool {
    format(path).is_some()
}

/// Opens a table in the format that its ending names, in csv otherwise.
///
/// # Errors
/// When it cannot be read.
pub fn open(path: &Path, how: How) -> Result<Box<dyn Rows>, FileError> {
    format(path).unwrap_or(FORMATS[0].1)(path, how)
}
