//! Errors of a study, with file, line and column.

use std::path::Path;

use toml::de::DeTable;

use fmu_import::{ArchiveError, FmuError, FmuFault};
use fmu_points::names::{did_you_mean, nearest};
use number_tables::files::{FileError, missing};

/// Why an FMU cannot be used, with a remedy.
pub fn unusable(error: &FmuError) -> String {
    match error {
        FmuError { path, fault: FmuFault::Archive(ArchiveError::Missing) } => {
            format!("{}: {}", path.display(), missing(path))
        }
        FmuError { path, fault: FmuFault::Archive(ArchiveError::NotZip) }
            if path.extension().is_some_and(|it| it == "toml") =>
        {
            format!("{}: a study, where an FMU is needed; name the FMU, or run the study by `verify`", path.display())
        }
        FmuError { path, fault: FmuFault::Archive(ArchiveError::System) } => {
            let way = "python -m fmu_orchestrator system";
            format!("{error}: `{way} {} --step 0.001 --output system.fmu` makes one of it", path.display())
        }
        other => other.to_string(),
    }
}

/// Why the FMU of a study cannot be opened.
#[derive(Debug, thiserror::Error)]
pub enum OpenError {
    /// It cannot be used.
    #[error("{}", unusable(.0))]
    Fmu(#[from] FmuError),
    /// The study names a file that is not there.
    #[error(transparent)]
    File(#[from] FileError),
}

/// A text in which errors have a place.
pub struct Place<'a> {
    pub(super) path: &'a Path,
    pub(super) text: &'a str,
}

impl Place<'_> {
    pub fn error(&self, offset: usize, message: String) -> FileError {
        let before = self.text.get(..offset).unwrap_or(self.text);
        let line_start = before.rfind('\n').map_or(0, |index| index + 1);
        FileError::new(self.path, message)
            .at(before.matches('\n').count() + 1)
            .at(before[line_start..].chars().count() + 1)
    }

    /// The TOML reader's message on one line, with a remedy.
    pub fn toml(&self, error: &toml::de::Error) -> FileError {
        let message = suggest(error.message());
        match error.span() {
            Some(span) => {
                let is_broken = DeTable::parse(self.text).is_err();
                let line = self.text.get(..span.start).unwrap_or_default();
                let begin = line.rfind('\n').map_or(0, |end| end + 1);
                let line = self.text[begin..].lines().next().unwrap_or_default();
                let section =
                    self.text[..begin + line.len()].lines().rev().map(str::trim).find(|line| line.starts_with('['));
                let is_unknown = message.starts_with("unknown") && section == Some(line.trim());
                let message = match section {
                    Some(section) if !is_broken && is_single(section) && !is_unknown => format!(
                        "there is only one of this section: write {} instead of {section}",
                        section.replace("[[", "[").replace("]]", "]")
                    ),
                    _ if is_broken && !message.starts_with("duplicate key") => format!("{message}; {RULES}"),
                    _ => remedy(&message, line).unwrap_or(message),
                };
                self.error(span.start, message)
            }
            None => self.named(message),
        }
    }

    /// An error at the section that its message names in brackets, and there at the key that it names first.
    pub fn named(&self, message: String) -> FileError {
        match self.place_of(&message) {
            Some(offset) => self.error(offset, message),
            None => FileError::new(self.path, message),
        }
    }

    fn place_of(&self, message: &str) -> Option<usize> {
        let study = DeTable::parse(self.text).ok()?;
        let mut sections = message.split('[').filter_map(|part| part.split_once(']'));
        let (section, (name, content)) =
            sections.find_map(|(name, words)| Some((words, study.get_ref().get_key_value(name)?)))?;
        let mut words = section.split(|c: char| !(c.is_alphanumeric() || c == '-'));
        Some(
            content
                .get_ref()
                .as_table()
                .and_then(|keys| words.find_map(|word| keys.get_key_value(word).map(|(key, _)| key)))
                .unwrap_or(name)
                .span()
                .start,
        )
    }
}

/// How each line of a study is written, for one that breaks the rules of TOML.
const RULES: &str = "each line of a study is `key = value` or `[section]`: a text stands between straight quotes (one with a backslash \
                     between '), a number has a point, a comment begins with #, and a part of a name with a point in it needs quotes, too";

/// Keys with which one would give a criterion one limit only.
const LIMITS: [&str; 6] = ["min", "max", "lower", "upper", "below", "above"];

/// The remedy where a tolerance is not the same to both sides.
pub const BOTH_SIDES: &str = "a single limit is `at-most` or `at-least`, without `nominal` and `tolerance`; a tolerance that is not \
                              the same to both sides is tolerance = { minus = \"1 degC\", plus = \"2 degC\" }";

/// The remedy where the name of a section lacks its quotes.
fn remedy(message: &str, line: &str) -> Option<String> {
    let (section, name) = line.trim().strip_prefix('[')?.trim_end_matches(']').split_once('.')?;
    let is_bare = message.starts_with("unknown field") && name.contains('.') && !name.contains(['"', '\'']);
    is_bare.then(|| format!("a name with a point in it needs quotes: [{section}.\"{name}\"]"))
}

/// Whether this is the name of a section in the brackets of a list, and there is no list of such sections.
fn is_single(section: &str) -> bool {
    const LISTS: [&str; 4] = ["cases", "correlations", "uncertainty-correlations", "except"];
    let name = section.strip_prefix("[[");
    name.is_some_and(|name| !name.split([']', '.']).any(|part| LISTS.contains(&part)))
}

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
    const WORDS: [(&str, &str); 13] = [
        (
            "missing field `share`",
            "`share` is missing, the part of the points that must meet all criteria: share = \"90 %\"",
        ),
        ("missing field", "this key is missing:"),
        ("wanted string or table", "expected a text in quotes"),
        ("expected a map", "expected a section with keys"),
        ("expected a sequence", "expected a list: a section in two brackets, [[NAME]]"),
        ("expected f64", "expected a number"),
        ("expected u64", "expected a whole number, not negative"),
        ("expected usize", "expected a whole number, not negative"),
        ("expected a string", "expected a text in quotes"),
        ("expected path string", "expected a path in quotes"),
        ("expected a boolean", "expected true or false"),
        ("floating point `", "number `"),
        (" as i128", " with more digits than can be read"),
    ];
    let message = WORDS.iter().fold(message.to_owned(), |text, (from, to)| text.replace(from, to));
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
