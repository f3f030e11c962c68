//! Errors of a study, with file, line and column.

use std::{ops::Range, path::Path};

use fmu_points::names::{did_you_mean, nearest};
use number_tables::files::FileError;
use toml::{
    Spanned,
    de::{DeTable, DeValue},
};

/// A text of which errors say line and column.
pub struct SourceText<'a> {
    pub path: &'a Path,
    pub text: &'a str,
}

impl SourceText<'_> {
    /// An error at a byte of the text.
    pub fn error_at(&self, offset: usize, message: String) -> FileError {
        let before = self.text.get(..offset).unwrap_or(self.text);
        let line_start = before.rfind('\n').map_or(0, |index| index + 1);
        FileError::new(self.path, message)
            .at_line(before.matches('\n').count() + 1)
            .at_column(before[line_start..].chars().count() + 1)
    }

    /// An error at the first of these keys that the section has, at the section where it has none of them, and without a place
    /// where the section is not written.
    pub fn error_under(&self, section: &str, keys: &[&str], message: String) -> FileError {
        match DeTable::parse(self.text).ok().and_then(|study| offset_of(study.get_ref(), section, keys)) {
            Some(offset) => self.error_at(offset, message),
            None => FileError::new(self.path, message),
        }
    }

    /// The TOML reader's message on one line, with a remedy.
    pub fn toml(&self, error: &toml::de::Error) -> FileError {
        let message = suggest(error.message());
        match error.span() {
            Some(span) => self.error_at(span.start, Slip::of(self.text, span.start, &message).explained(message)),
            None => FileError::new(self.path, message),
        }
    }
}

fn offset_of(study: &DeTable, section: &str, keys: &[&str]) -> Option<usize> {
    let (name, content) = study.get_key_value(section)?;
    let content = content.get_ref().as_table();
    let key = content.and_then(|content| keys.iter().find_map(|key| content.get_key_value(*key)));
    Some(key.map_or(name, |(key, _)| key).span().start)
}

/// What is wrong with the text of a study, beside what the reader says of it.
enum Slip<'a> {
    /// It breaks the rules of TOML.
    Broken,
    /// The heading of a section stands in the brackets of a list, and there is only one of this section.
    Single(&'a str),
    /// The name of a section lacks its quotes: what stands before the name, and the name.
    Unquoted(&'a str, &'a str),
    /// The reader has said all.
    Other,
}

impl<'a> Slip<'a> {
    /// What is wrong at this byte, of which the reader says this.
    fn of(text: &'a str, offset: usize, message: &str) -> Self {
        let Ok(study) = DeTable::parse(text) else {
            return if message.starts_with("duplicate key") { Self::Other } else { Self::Broken };
        };
        if let Some(heading) = single_section(study.get_ref(), offset) {
            return Self::Single(&text[heading]);
        }
        let unquoted = message.starts_with("unknown field").then(|| unquoted(text, offset)).flatten();
        unquoted.map_or(Self::Other, |(before, name)| Self::Unquoted(before, name))
    }

    fn explained(self, message: String) -> String {
        match self {
            Self::Broken => format!("{message}; {RULES}"),
            Self::Single(heading) => format!(
                "there is only one of this section: write {} instead of {heading}",
                heading.replace("[[", "[").replace("]]", "]")
            ),
            Self::Unquoted(before, name) => {
                format!("a name with a point in it needs quotes: [{before}.\"{name}\"]")
            }
            Self::Other => message,
        }
    }
}

/// The heading, in the brackets of a list, of the section with the key or value that begins at this byte, unless there is a list
/// of such sections. A key that nobody knows is no section in wrong brackets.
fn single_section(table: &DeTable, offset: usize) -> Option<Range<usize>> {
    const LISTS: [&str; 4] = ["cases", "correlations", "uncertainty-correlations", "except"];
    table.iter().filter(|(key, _)| !LISTS.contains(&key.get_ref().as_ref())).find_map(|(key, value)| {
        // The value that a heading begins is the heading, and so begins before its key.
        let is_heading = value.get_ref().is_array() && value.span().start < key.span().start;
        if is_heading && begins_in(value, offset) {
            return Some(value.span());
        }
        single_section(value.get_ref().as_table()?, offset)
    })
}

/// Whether the value, or a key or value in it, begins at this byte.
fn begins_in(value: &Spanned<DeValue>, offset: usize) -> bool {
    value.span().start == offset
        || match value.get_ref() {
            DeValue::Array(items) => items.iter().any(|item| begins_in(item, offset)),
            DeValue::Table(table) => {
                table.iter().any(|(key, value)| key.span().start == offset || begins_in(value, offset))
            }
            _ => false,
        }
}

/// Where a heading has a key that its section does not know at this byte: what stands before the name to which the key belongs,
/// and that name without the quotes that it needs.
fn unquoted(text: &str, offset: usize) -> Option<(&str, &str)> {
    let line = text.get(..offset)?.rfind('\n').map_or(0, |end| end + 1);
    let inner = text[line..].trim_start().strip_prefix('[')?.trim_start_matches('[');
    let heading = inner.split([']', '\n']).next()?;
    let before = offset.checked_sub(text.len() - inner.len())?;
    let (section, _) = heading.get(..before)?.strip_suffix('.')?.rsplit_once('.')?;
    let name = &heading[section.len() + 1..];
    (!name.contains(['"', '\''])).then_some((section, name))
}

/// How each line of a study is written, for one that breaks the rules of TOML.
const RULES: &str = "each line of a study is `key = value` or `[section]`: a text stands between straight quotes (one with a backslash \
                     between '), a number has a point, a comment begins with #, and a part of a name with a point in it needs quotes, too";

/// Keys with which one would give a criterion one limit only.
const LIMITS: [&str; 6] = ["min", "max", "lower", "upper", "below", "above"];

/// The remedy where a tolerance is not the same to both sides.
pub const BOTH_SIDES: &str = "a single limit is `at-most` or `at-least`, without `nominal` and `tolerance`; a tolerance that is not \
                              the same to both sides is tolerance = { minus = \"1 degC\", plus = \"2 degC\" }";

/// Shortens "unknown field `x`, expected one of `a`, `b`, ..." to the nearest name.
fn suggest(message: &str) -> String {
    let message = message.split('\n').map(str::trim).collect::<Vec<_>>().join("; ");
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
    // A line a word of the program: that, and the study's.
    let words = include_str!("plain_words.txt").lines().filter_map(|line| line.split_once(" | "));
    let message = words.fold(message.to_owned(), |text, (from, to)| text.replace(from, to));
    // The name of a struct says something to us alone.
    match message.split_once("expected struct ") {
        Some((before, _)) => format!("{before}expected a section with keys, or {{ key = value }}"),
        None => message,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Study;

    #[test]
    fn every_slip_of_the_pen_has_its_place_and_remedy() {
        const STUDY: &str = "fmu = \"lag.fmu\"\n[design]\npoints = 8\n[parameters.\"lag.rate\"]\n\
                             distribution = \"normal\"\nmean = 1\ndeviation = 0.1\n";
        for (from, to, message) in [
            ("mean = 1", "mean = 1\nmean = 2", "7:1: duplicate key"),
            ("[design]", "[design]\n[design]", "3:2: duplicate key"),
            (
                "[design]",
                "[cases]\n[design]",
                "2:1: invalid type: map, expected a list: a section in two brackets, [[NAME]]",
            ),
            ("\"lag.rate\"]", "lag.rate]", "4:17: a name with a point in it needs quotes: [parameters.\"lag.rate\"]"),
            ("\"normal\"", "\"gauss\"", "did you mean `normal`?"),
            ("[design]", "[[desing]]", "did you mean `design`?"),
            ("[design]", "[[design]]", "there is only one of this section: write [design] instead of [[design]]"),
            (
                "[parameters.\"lag.rate\"]",
                "[[parameters.\"lag.rate\"]]",
                "4:1: there is only one of this section: write [parameters.\"lag.rate\"]",
            ),
            (
                "[design]",
                "[[cases]]\nname = \"a\"\nconcerns = [\n[[1, 2]]\n]\n[design]",
                "5:1: invalid type: sequence, expected a text in quotes",
            ),
            ("[design]", "[[design]] # [[1]]", "write [design] instead of [[design]]"),
            (
                "\"lag.rate\"]",
                "lag.rate.of.change] # [x]",
                "4:17: a name with a point in it needs quotes: [parameters.\"lag.rate.of.change\"]",
            ),
            (
                "[design]",
                "[identify.free.lag.rate]\n[design]",
                "2:20: a name with a point in it needs quotes: [identify.free.\"lag.rate\"]",
            ),
            ("\"normal\"", "\"rectangular\"", "did you mean `uniform`?"),
            ("deviation", "sigma", "did you mean `deviation`?"),
            ("distribution = \"normal\"\n", "", "4:1: this key is missing: `distribution`"),
            ("\"normal\"", "3", "5:16: expected a text in quotes"),
            ("points = 8", "method = \"lhs\"", "did you mean `latin-hypercube`?"),
        ] {
            assert!(STUDY.contains(from), "{from}");
            let error = Study::parse("s.toml".as_ref(), STUDY.replace(from, to)).unwrap_err();
            assert!(error.to_string().contains(message), "{to}: {error}");
        }
        for (from, to, line) in [
            ("mean = 1", "mean = 0,020", 6),
            ("mean = 1", "mean = 1 mm # wide", 6),
            ("\"lag.fmu\"", "lag.fmu", 1),
            ("\"normal\"", "\u{201c}normal\u{201d}", 5),
            ("\"lag.fmu\"", "\"C:\\Users\\me\\lag.fmu\"", 1),
            ("mean = 1", "mean: 1", 6),
            ("[design]", "[design", 2),
            ("\"normal\"", "\"normal", 5),
            ("[design]", "[the design]", 2),
            ("mean = 1", "mean = 1;", 6),
            ("mean = 1", "mean = # ?", 6),
        ] {
            let error = Study::parse("s.toml".as_ref(), STUDY.replace(from, to)).unwrap_err().to_string();
            assert!(error.starts_with(&format!("s.toml:{line}:")) && error.ends_with(RULES), "{to}: {error}");
        }
    }

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
