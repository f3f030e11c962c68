//! Rows of a table, in whatever format it stands.

use std::borrow::Cow;

use crate::files::Result;

/// A table that is read row by row.
pub trait Rows {
    /// The names of the columns.
    fn names(&self) -> &[String];

    /// Goes to the next row; false behind the last one.
    ///
    /// # Errors
    /// When it cannot be read.
    fn advance(&mut self) -> Result<bool>;

    /// A cell of this row as a number.
    fn number(&self, place: usize) -> Option<f64>;

    /// A cell of this row as a count.
    fn whole(&self, place: usize) -> Option<u64>;

    /// What has two readings in a column, where the rows so far do not tell which is right, and its line.
    fn unclear(&self, _place: usize) -> Option<(u64, String)> {
        None
    }

    /// The lines between rows that are blank or comments and were left out.
    fn skipped(&self) -> &[usize] {
        &[]
    }

    /// A cell of this row as it is written; empty where there is no value.
    fn text(&self, place: usize) -> Cow<'_, str>;

    /// The line of this row, or its number from 1 where the format has no lines.
    fn line(&self) -> u64;
}
