//! The format of a table, by the ending of its name.

use std::path::Path;

use crate::FORMATS;
use crate::files::FileError;
use crate::rows::{How, Rows};

/// Opens a table.
pub(crate) type Open = fn(&Path, How) -> Result<Box<dyn Rows>, FileError>;

/// Its place in [`FORMATS`].
fn place(path: &Path) -> Option<usize> {
    let ending = path.extension()?.to_ascii_lowercase();
    FORMATS.iter().position(|(known, _)| ending == *known)
}

/// Whether a file's name ends as that of a table.
pub fn is_table(path: &Path) -> bool {
    place(path).is_some()
}

/// Who reads a table whose ending names another format than text.
pub(crate) fn no_text(path: &Path) -> Option<Open> {
    place(path)
        .filter(|place| *place > 0)
        .map(|place| FORMATS[place].1)
}

/// Opens a table in the format that its ending names, in csv otherwise.
///
/// # Errors
/// When it cannot be read.
pub fn open(path: &Path, how: How) -> Result<Box<dyn Rows>, FileError> {
    let (_, open) = FORMATS[place(path).unwrap_or(0)];
    open(path, how)
}
