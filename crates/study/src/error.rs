//! Errors of a study, with file, line and column.

use std::path::Path;

use toml::Table;
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
        FmuError { path, fault: FmuFault::Archive(ArchiveError::NotZip) } if path.extension().is_some_and(|it| it == "toml") => {
            format!("{}: a study, where an FMU is needed; name the FMU, or run the study by `verify`", path.display())
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
pub(super) struct Place<'a> {
    pub(super) path: &'a Path,
    pub(super) text: &'a str,
}

impl Place<'_> {
    pub(super) fn error(&self, offset: usize, message: String) -> FileError {
        let before = self.text.get(..offset).unwrap_or(self.text);
        let line_start = before.rfind('\n').map_or(0, |index| index + 1);
        FileError::new(self.path, message)
            .at(before.matches('\n').count() + 1)
            .at(before[line_start..].chars().count() + 1)
    }

    /// The TOML reader's message on one line, with a remedy.
    pub(super) fn toml(&self, error: &toml::de::Error) -> FileError {
        let message = suggest(error.message());
        match error.span() {
            Some(span) => {
                let is_broken = DeTable::parse(self.text).is_err();
                let line = self.text.get(..span.start).unwrap_or_default();
                let begin = line.rfind('\n').map_or(0, |end| end + 1);
                let line = self.text[begin..].lines().next().unwrap_or_default();
                let lines = self.text[..begin + line.len()].lines().rev();
                let section = lines.map(str::trim).find(|line| line.starts_with('['));
                let is_unknown = message.starts_with("unknown") && section == Some(line.trim());
                let remedy = match section {
                    Some(section) if !is_broken && is_single(section) && !is_unknown => Some(format!(
                        "there is only one of this section: write {} instead of {section}",
                        section.replace("[[", "[").replace("]]", "]")
                    )),
                    _ => remedy(error.message(), line, is_broken),
                };
                self.error(span.start, remedy.unwrap_or(message))
            }
            None => self.named(message),
        }
    }

    /// An error at the section that its message names in brackets, and there at the key that it names first.
    pub(super) fn named(&self, message: String) -> FileError {
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
        let key = content
            .get_ref()
            .as_table()
            .and_then(|keys| words.find_map(|word| keys.get_key_value(word).map(|(key, _)| key)));
        Some(key.unwrap_or(name).span().start)
    }
}

/// A whole number of so many digits may be beyond those that can be read.
const TOO_LONG: usize = 20;

/// Keys with which one would give a criterion one limit only.
const LIMITS: [&str; 6] = ["min", "max", "lower", "upper", "below", "above"];

/// The remedy where a tolerance is not the same to both sides.
pub const BOTH_SIDES: &str = "a single limit is `at-most` or `at-least`, without `nominal` and `tolerance`; a tolerance that is not \
                              the same to both sides is tolerance = { minus = \"1 degC\", plus = \"2 degC\" }";

/// The remedy for a message of the TOML reader, from the line that it is about, which may break the rules of TOML; none where its
/// own words do.
fn remedy(message: &str, line: &str, is_broken: bool) -> Option<String> {
    let says = |part: &str| message.contains(part);
    let (key, value) = line.split_once('=').unwrap_or((line, ""));
    let (key, value) = (key.trim(), value.split('#').next().unwrap_or_default().trim());
    let header = line.trim().strip_prefix('[');
    let alone = value.trim_end_matches([',', ';']);
    let whole = value.trim_start_matches(['+', '-']).replace('_', "");
    if header.is_some() && is_broken && !says("duplicate key") {
        return Some(section_name(line));
    }
    if is_broken && value.is_empty() && line.contains('=') {
        return Some(format!("{key} has no value: write one behind the =, or remove the line"));
    }
    if is_broken && alone != value && toml::from_str::<Table>(&format!("x = {alone}")).is_ok() {
        return Some(format!("nothing stands behind a value: write {key} = {alone}"));
    }
    if whole.bytes().all(|digit| digit.is_ascii_digit()) && whole.len() >= TOO_LONG {
        return Some(format!(
            "{key} is beyond the whole numbers that can be read, which end at {}; write a smaller one, or {value}.0 where it need not be \
             whole",
            u64::MAX
        ));
    }
    if says("expected newline") && is_decimal_comma(value) {
        let point = value.replace(',', ".");
        return Some(format!("a number has a point, not a comma: {key} = {point}"));
    }
    if says("escaped value") || says("unicode value") || says("unicode hexadecimal") {
        return Some(format!(
            "between double quotes a backslash begins a special character: write '{}', with single quotes, or / instead of \\",
            value.trim_matches('"')
        ));
    }
    if says("must be quoted") {
        let bare = value.trim_matches(|c: char| "\u{201c}\u{201d}\u{201e}\u{201f}\"'".contains(c));
        return Some(format!("a text needs straight quotes: {key} = \"{bare}\""));
    }
    if says("key with no value") && line.contains(':') {
        return Some("a key has = behind it, not a colon: `key = value`".to_owned());
    }
    if says("key with no value") || says("invalid key-value pair") || says("invalid unquoted") {
        return Some("this is neither `key = value` nor `[section]`, as every line of a study is".to_owned());
    }
    if says("invalid basic string") || says("invalid literal string") {
        return Some(format!("the text has no end: {key} needs the same quote behind its value"));
    }
    if says("duplicate key") {
        let name = header.map_or(key, |name| name.trim_matches(['[', ']']));
        return Some(format!("`{name}` stands here a second time; keep one"));
    }
    if says("expected a sequence") {
        return Some(match header {
            Some(name) => format!(
                "there may be several of this section: write two brackets around its name, [[{}]]",
                name.trim_end_matches(']')
            ),
            None => format!("{key} takes a list: write brackets around its values"),
        });
    }
    if let Some((section, name)) = header.and_then(|name| name.split_once('.'))
        && says("unknown field")
        && name.contains('.')
        && !name.contains(['"', '\''])
    {
        let name = name.trim_end_matches(']');
        return Some(format!("a name with a point in it needs quotes: [{section}.\"{name}\"]"));
    }
    None
}

/// Whether this is the name of a section in the brackets of a list, and there is no list of such sections.
fn is_single(section: &str) -> bool {
    const LISTS: [&str; 4] = ["cases", "correlations", "uncertainty-correlations", "except"];
    let name = section.strip_prefix("[[");
    name.is_some_and(|name| !name.split([']', '.']).any(|part| LISTS.contains(&part)))
}

/// How the name of a section is to be written whose line breaks the rules.
fn section_name(line: &str) -> String {
    let line = line.split('#').next().unwrap_or_default().trim();
    let name = line.trim_start_matches('[');
    let count = line.len() - name.len();
    let name = name.trim_end_matches(']');
    if line != format!("{}{name}{}", "[".repeat(count), "]".repeat(count)) {
        let (open, close) = ("[".repeat(count), "]".repeat(count));
        return format!("the section's name has other brackets before it than behind it: write {open}{name}{close}");
    }
    "points stand between the parts of a section's name, and a part needs quotes where it has more than letters, digits, - and _: \
     [criteria.\"Y 1\"]"
        .to_owned()
}

/// Whether a value is a number such as `0,02`.
fn is_decimal_comma(value: &str) -> bool {
    value.matches(',').count() == 1 && !value.contains('.') && value.replace(',', ".").parse::<f64>().is_ok()
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
        Some("discrepancy") if unknown => {
            "`discrepancy` is gone: how far the model itself may be off is part of `accuracy` (of a criterion's `noise`), as the root of \
             the sum of squares"
                .to_owned()
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
    const WORDS: [(&str, &str); 10] = [
        ("missing field `fmu`", "`fmu` is missing, the model: fmu = \"my.fmu\""),
        ("missing field", "there is missing"),
        ("expected f64", "expected a number"),
        ("expected u64", "expected a whole number, not negative"),
        ("expected usize", "expected a whole number, not negative"),
        ("expected a string", "expected a text in quotes"),
        ("expected path string", "expected a path in quotes"),
        ("expected a boolean", "expected true or false"),
        ("floating point `", "number `"),
        (" as i128", " with more digits than can be read"),
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
    use crate::Study;

    #[test]
    fn every_slip_of_the_pen_has_its_place_and_remedy() {
        const STUDY: &str = "fmu = \"lag.fmu\"\n[design]\npoints = 8\n[parameters.\"lag.rate\"]\n\
                             distribution = \"normal\"\nmean = 1\ndeviation = 0.1\n";
        for (from, to, message) in [
            ("mean = 1", "mean = 0,020", "6:9: a number has a point, not a comma: mean = 0.020"),
            ("mean = 1", "mean = 1 mm # wide", "6:8: a text needs straight quotes: mean = \"1 mm\""),
            ("\"lag.fmu\"", "lag.fmu", "1:7: a text needs straight quotes: fmu = \"lag.fmu\""),
            ("\"normal\"", "\u{201c}normal\u{201d}", "5:16: a text needs straight quotes: distribution = \"normal\""),
            ("\"lag.fmu\"", "\"C:\\Users\\me\\lag.fmu\"", "write 'C:\\Users\\me\\lag.fmu', with single quotes, or /"),
            ("\"lag.fmu\"", "\"a\\lag.fmu\"", "write 'a\\lag.fmu', with single quotes, or /"),
            ("mean = 1", "mean: 1", "6:7: a key has = behind it, not a colon"),
            ("mean = 1", "mean", "6:5: this is neither `key = value` nor `[section]`"),
            (
                "[design]",
                "[design",
                "2:8: the section's name has other brackets before it than behind it: write [design]",
            ),
            ("\"normal\"", "\"normal", "5:23: the text has no end: distribution needs the same quote"),
            ("mean = 1", "mean = 1\nmean = 2", "7:1: `mean` stands here a second time; keep one"),
            ("[design]", "[design]\n[design]", "3:2: `design` stands here a second time; keep one"),
            (
                "[design]",
                "[cases]\n[design]",
                "2:1: there may be several of this section: write two brackets around its name, [[cases]]",
            ),
            ("\"lag.rate\"]", "lag.rate]", "4:17: a name with a point in it needs quotes: [parameters.\"lag.rate\"]"),
            ("fmu = \"lag.fmu\"\n", "", "`fmu` is missing, the model: fmu = \"my.fmu\""),
            ("\"normal\"", "\"gauss\"", "did you mean `normal`?"),
            (
                "[design]",
                "[[design] # drawn",
                "2:10: the section's name has other brackets before it than behind it: write [[design]]",
            ),
            ("[design]", "[the design]", "[criteria.\"Y 1\"]"),
            ("[design]", "[[desing]]", "did you mean `design`?"),
            ("[design]", "[[design]]", "there is only one of this section: write [design] instead of [[design]]"),
            (
                "[parameters.\"lag.rate\"]",
                "[[parameters.\"lag.rate\"]]",
                "4:1: there is only one of this section: write [parameters.\"lag.rate\"]",
            ),
            ("mean = 1", "mean = 1;", "6:8: nothing stands behind a value: write mean = 1"),
            ("mean = 1", "mean = 1.0,", "nothing stands behind a value: write mean = 1.0"),
            ("mean = 1", "mean = # ?", "6:8: mean has no value: write one behind the ="),
            (
                "points = 8",
                "seed = 99_999_999_999_999_999_999",
                "3:8: seed is beyond the whole numbers that can be read, which end at 18446744073709551615",
            ),
            (
                "mean = 1",
                "mean = 9999999999999999999999999999999999999999999",
                "write a smaller one, or 9999999999999999999999999999999999999999999.0 where",
            ),
            ("\"normal\"", "\"rectangular\"", "did you mean `uniform`?"),
            ("deviation", "sigma", "did you mean `deviation`?"),
            ("points = 8", "method = \"lhs\"", "did you mean `latin-hypercube`?"),
        ] {
            assert!(STUDY.contains(from), "{from}");
            let error = Study::parse("s.toml".as_ref(), STUDY.replace(from, to)).unwrap_err();
            assert!(error.to_string().contains(message), "{to}: {error}");
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
