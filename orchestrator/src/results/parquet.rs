//! `points.parquet`: the rows of `points.csv` with types.

use std::path::Path;

use super::Summary;
use crate::error::Error;
use number_tables::typed::{self, Kind};
use point_journal::files::{draft, keep};

/// Writes `points.parquet` beside `points.csv`: the same rows, with types. It is either as before or complete.
///
/// # Errors
/// When the table cannot be read or the file not be written.
pub fn convert(folder: &Path, summary: &Summary) -> Result<(), Error> {
    let path = folder.join("points.parquet");
    let draft = draft(folder).map_err(Error::io(folder))?;
    // The point, parameters, values, passes, verified, status.
    let numbers = summary.parameters.len() + summary.criteria.len();
    let kind = |place: usize, width: usize| match place {
        0 => Kind::Count,
        place if place <= numbers => Kind::Number,
        place if place + 1 < width => Kind::Flag,
        _ => Kind::Text,
    };
    let file = draft.reopen();
    let written = file.and_then(|file| typed::convert(&folder.join("points.csv"), file, kind));
    written.map_err(Error::io(&path))?;
    Ok(keep(draft, &path)?)
}
