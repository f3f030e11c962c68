//! Which working directory the FMU has.
//!
//! What one point leaves in the working directory, such as a log, the next one may read. So each process has an empty
//! one. But a study may name a file by a relative path, which the FMU then looks for where the user is: there points
//! keep the user's own working directory.

use std::path::Path;

use crate::task::Task;
use fmu_import::{Description, Kind, Value};

/// The folder within which working directories are made for the points of a study; none where points keep the user's.
pub fn home<'a>(scratch: &'a Path, fmu: &Description, task: &Task) -> Option<&'a Path> {
    (!named_by(fmu) && !named_in(task)).then_some(scratch)
}

/// Whether a text that the study sets is the relative path of something that exists.
pub(super) fn named_in(task: &Task) -> bool {
    task.fixed.iter().any(|(_, value)| match value {
        Value::String(text) => is_here(text),
        _ => false,
    })
}

/// Whether the start value of a text is the relative path of something that exists.
pub(super) fn named_by(description: &Description) -> bool {
    let mut variables = description.variables.values();
    variables.any(|variable| match &variable.kind {
        Kind::String { start: Some(text) } => is_here(text),
        _ => false,
    })
}

fn is_here(text: &str) -> bool {
    let path = Path::new(text);
    !text.is_empty() && path.is_relative() && path.exists()
}
