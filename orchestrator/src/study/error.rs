//! Errors of a study, with file, line and column.

use std::io;
use std::path::{Path, PathBuf};

use thiserror::Error;

use crate::files::reason;
use crate::names::{did_you_mean, nearest};

/// Why a study cannot be used.
#[derive(Debug, Error)]
pub enum StudyError {
    /// The file cannot be read.
    #[error("{path}: {}", reason(path, .source))]
    Read {
        /// The study.
        path: PathBuf,
        /// The operating system's message.
        source: io::Error,
    },
    /// Something at a place is wrong.
    #[error("{path}:{line}:{column}: {message}")]
    At {
        /// The study.
        path: PathBuf,
        /// The line, from 1.
        line: usize,
        /// The column, from 1.
        column: usize,
        /// The problem and its remedy.
        message: String,
    },
    /// Something is missing.
    #[error("{path}: {message}")]
    Whole {
        /// The study.
        path: PathBuf,
        /// The problem and its remedy.
        message: String,
    },
}

/// A text in which errors have a place.
pub(super) struct Place<'a> {
    pub(super) path: &'a Path,
    pub(super) text: &'a str,
}

impl Place<'_> {
    pub(super) fn error(&self, offset: usize, message: String) -> StudyError {
        let before = self.text.get(..offset).unwrap_or(self.text);
        let line_start = before.rfind('\n').map_or(0, |index| index + 1);
        StudyError::At {
            path: self.path.to_owned(),
            line: before.matches('\n').count() + 1,
            column: before[line_start..].chars().count() + 1,
            message,
        }
    }

    /// The TOML reader's message on one line, with a suggestion for a mistyped name.
    pub(super) fn toml(&self, error: &toml::de::Error) -> StudyError {
        let message = suggest(error.message());
        match error.span() {
            Some(span) => self.error(span.start, message),
            None => StudyError::Whole {
                path: self.path.to_owned(),
                message,
            },
        }
    }
}

/// Keys with which one would give a criterion one limit only.
const LIMITS: [&str; 6] = ["min", "max", "lower", "upper", "below", "above"];

/// The remedy where a tolerance is not the same to both sides.
pub const BOTH_SIDES: &str = "a tolerance is the same to both sides: for limits a and b state nominal = (a + b) / 2 and \
                              tolerance = (b - a) / 2, where only one limit counts with the other one beyond what the model \
                              can reach; an uncertainty given as a percentage must be given as a value then";

/// Shortens "unknown field `x`, expected one of `a`, `b`, ..." to the nearest name.
fn suggest(message: &str) -> String {
    let message = message
        .split('\n')
        .map(str::trim)
        .collect::<Vec<_>>()
        .join("; ");
    let message = plain(&message);
    let mut names = message.split('`').skip(1).step_by(2);
    let unknown = message.starts_with("unknown field") || message.starts_with("unknown variant");
    match names.next() {
        Some(wrong) if unknown && LIMITS.contains(&wrong) && message.contains("`nominal`") => {
            let start = message.split(',').next().unwrap_or_default();
            format!("{start}; {BOTH_SIDES}")
        }
        Some(wrong) if unknown => match nearest(wrong, names) {
            Some(right) => {
                let start = message.split(',').next().unwrap_or_default();
                format!("{start}{}", did_you_mean(Some(right)))
            }
            None => message,
        },
        _ => message,
    }
}

/// Says what is expected in words of the study, not in those of the program.
fn plain(message: &str) -> String {
    const WORDS: [(&str, &str); 7] = [
        ("expected f64", "expected a number"),
        ("expected u64", "expected a whole number, not negative"),
        ("expected usize", "expected a whole number, not negative"),
        ("expected a string", "expected a text in quotes"),
        ("expected path string", "expected a path in quotes"),
        ("expected a boolean", "expected true or false"),
        ("floating point `", "number `"),
    ];
    let replaced = |text: String, (from, to): &(&str, &str)| text.replace(from, to);
    let message = WORDS.iter().fold(message.to_owned(), replaced);
    // The name of a struct says something to us alone.
    match message.split_once("expected struct ") {
        Some((before, _)) => format!("{before}expected a section with keys, or {{ key = value }}"),
        None => message,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn types_have_plain_names() {
        assert_eq!(
            suggest("invalid type: string \"1 min\", expected f64"),
            "invalid type: string \"1 min\", expected a number"
        );
        assert_eq!(
            suggest("invalid type: floating point `4.0`, expected u64"),
            "invalid type: number `4.0`, expected a whole number, not negative"
        );
        assert_eq!(
            suggest("invalid type: integer `3`, expected struct Simulation"),
            "invalid type: integer `3`, expected a section with keys, or { key = value }"
        );
    }
}
