//! The formats in which a table may stand. A new one is a file with its [`Rows`] and a line in [`FORMATS`].

use std::borrow::Cow;
use std::path::Path;

use crate::files::FileError;
use crate::{csv_file, parquet};

/// A table that is read row by row.
pub trait Rows {
    /// The names of the columns.
    fn names(&self) -> &[String];

    /// Goes to the next row; false behind the last one.
    ///
    /// # Errors
    /// When it cannot be read.
    fn advance(&mut self) -> Result<bool, FileError>;

    /// A cell of this row as a number.
    fn number(&self, place: usize) -> Option<f64>;

    /// A cell of this row as a count.
    fn whole(&self, place: usize) -> Option<u64>;

    /// A cell of this row as it is written; empty where there is no value.
    fn text(&self, place: usize) -> Cow<'_, str>;

    /// The line of this row, or its number from 1 where the format has no lines.
    fn line(&self) -> u64;
}

/// How a table is read.
#[derive(Clone, Copy, Debug, Default)]
pub struct How {
    /// Lines that begin with `#` are left out.
    pub comments: bool,
    /// An empty cell is a missing value, and so is a blank line of a table with one column.
    pub gaps: bool,
}

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
