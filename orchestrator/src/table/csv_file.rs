//! Csv files as programs and spreadsheets write them: commas, semicolons or tabs between cells, and
//! decimal commas where commas separate nothing.

use std::borrow::Cow;
use std::fs::File;
use std::io::{self, BufRead, BufReader, Seek};
use std::path::Path;

use crate::files;

/// A csv file that is being read.
#[derive(Debug)]
pub struct CsvFile {
    /// Its records, without the blanks around cells.
    pub reader: csv::Reader<BufReader<File>>,
    separator: u8,
}

impl CsvFile {
    /// Opens a file; lines that begin with `comment` are left out.
    ///
    /// # Errors
    /// When it cannot be read.
    pub fn open(path: &Path, comment: Option<u8>) -> csv::Result<Self> {
        let mut file = BufReader::new(File::open(path)?);
        let separator = separator(&mut file, comment)?;
        file.rewind()?;
        let mut builder = csv::ReaderBuilder::new();
        builder.trim(csv::Trim::All).comment(comment);
        Ok(Self {
            reader: builder.delimiter(separator).from_reader(file),
            separator,
        })
    }

    /// The number in a cell of this file.
    pub fn number(&self, cell: &str) -> Option<f64> {
        number(self.separator, cell)
    }
}

fn number(separator: u8, cell: &str) -> Option<f64> {
    let point = || {
        let decimal_comma = separator != b',' && cell.matches(',').count() == 1;
        (decimal_comma && !cell.contains('.')).then(|| cell.replace(',', "."))
    };
    let plain = cell.parse().ok();
    plain.or_else(|| point().and_then(|cell| cell.parse().ok()))
}

/// The separator in the first line that is neither blank nor a comment.
fn separator(file: &mut impl BufRead, comment: Option<u8>) -> io::Result<u8> {
    let mut line = Vec::new();
    while file.read_until(b'\n', &mut line)? > 0 {
        let text = line.trim_ascii();
        if !text.is_empty() && text.first() != comment.as_ref() {
            break;
        }
        line.clear();
    }
    let mut quoted = false;
    let mut counts = [(b',', 0), (b'\t', 0), (b';', 0)];
    for &byte in &line {
        quoted ^= byte == b'"';
        let count = counts.iter_mut().find(|(own, _)| *own == byte && !quoted);
        count.into_iter().for_each(|(_, count)| *count += 1);
    }
    // A tie goes to the last one: names hold commas more often than semicolons.
    let most = counts.iter().max_by_key(|(_, count)| *count);
    Ok(most.map_or(b',', |&(byte, count)| if count > 0 { byte } else { b',' }))
}

/// The places of blank lines among the rows of a file, counted from 0 behind the header. Lines that begin with `comment`
/// are no rows.
pub fn blank_rows(path: &Path, comment: u8) -> io::Result<Vec<usize>> {
    blank(BufReader::new(File::open(path)?), comment)
}

fn blank(file: impl BufRead, comment: u8) -> io::Result<Vec<usize>> {
    let mut found = Vec::new();
    let mut row: Option<usize> = None;
    for line in file.lines() {
        let line = line?;
        let text = line.trim();
        if line.as_bytes().first() == Some(&comment) || (row.is_none() && text.is_empty()) {
            continue;
        }
        if let Some(row) = row.filter(|_| text.is_empty()) {
            found.push(row);
        }
        row = Some(row.map_or(0, |row| row + 1));
    }
    Ok(found)
}

/// A text as a cell: where a spreadsheet would take it for a formula, an apostrophe before it prevents that. Numbers
/// stay as they are.
pub fn cell(text: &str) -> Cow<'_, str> {
    if is_formula(text) && text.parse::<f64>().is_err() {
        Cow::Owned(format!("'{text}"))
    } else {
        Cow::Borrowed(text)
    }
}

/// The text that [`cell`] made a cell of.
pub fn text(cell: &str) -> &str {
    let inner = cell.strip_prefix('\'');
    inner.filter(|inner| is_formula(inner)).unwrap_or(cell)
}

/// Whether a text begins as a formula does. One that has an apostrophe before it already gets another, so that
/// [`text`] gives back either.
fn is_formula(text: &str) -> bool {
    let bare = text.trim_start_matches('\'');
    bare.starts_with(['=', '+', '-', '@', '\t', '\r'])
}

/// Why a file cannot be read, for people.
pub fn reason(path: &Path, error: &csv::Error) -> String {
    let line = |position: &Option<csv::Position>| {
        let line = position.as_ref().map_or(0, csv::Position::line);
        format!("line {}", line.max(1))
    };
    match error.kind() {
        csv::ErrorKind::Io(error) => files::reason(path, error),
        csv::ErrorKind::Utf8 { pos, .. } => {
            format!("{} is no text in UTF-8; save the table so", line(pos))
        }
        csv::ErrorKind::UnequalLengths {
            pos,
            expected_len,
            len,
        } => format!(
            "{} has {len} cells instead of {expected_len} as the first line",
            line(pos)
        ),
        _ => error.to_string(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn separators() {
        for (header, expected) in [
            ("a,b,c", b','),
            ("a;b;c", b';'),
            ("T, degC;F, N;p", b';'),
            ("a\tb", b'\t'),
            ("\"a;b;c\",d", b','),
            ("alone", b','),
            ("", b','),
            ("# a;b;c;d\n\na,b", b','),
        ] {
            let found = separator(&mut header.as_bytes(), Some(b'#')).unwrap();
            assert_eq!(found, expected, "{header}");
        }
    }

    #[test]
    fn blank_lines_have_their_places_among_the_rows() {
        for (text, places) in [
            ("y\n1\n2\n", vec![]),
            ("\n# made by hand\n\ny\n1\n\n2\n", vec![1]),
            ("y\n\n1\n# more\n\n\n2\n\n", vec![0, 2, 3, 5]),
        ] {
            assert_eq!(blank(text.as_bytes(), b'#').unwrap(), places, "{text}");
        }
    }

    #[test]
    fn no_text_becomes_a_formula() {
        for formula in ["=1+1", "+cmd|' /C calc'!A0", "-x", "@SUM(A1)", "\t=1", "-"] {
            let cell = cell(formula);
            assert_eq!(cell, format!("'{formula}"));
            assert_eq!(text(&cell), formula);
        }
        for plain in ["", "lag.y", "-1.5e3", "+2", "'quoted'", "der(x)", "a=b"] {
            assert_eq!(cell(plain), plain);
            assert_eq!(text(plain), plain);
        }
    }

    proptest::proptest! {
        #[test]
        fn every_text_comes_back(plain in "['=+@\t\r-]{0,3}.{0,5}") {
            let cell = cell(&plain);
            let number = plain.parse::<f64>().is_ok();
            let formula = cell.starts_with(['=', '+', '-', '@', '\t', '\r']);
            proptest::prop_assert!(number || !formula);
            proptest::prop_assert_eq!(text(&cell), plain.as_str());
        }
    }

    #[test]
    fn decimal_commas() {
        assert_eq!(number(b';', "81,33"), Some(81.33));
        assert_eq!(number(b';', "-8,1e2"), Some(-810.0));
        assert_eq!(number(b'\t', "81.33"), Some(81.33));
        assert_eq!(number(b',', "81,33"), None);
        assert_eq!(number(b';', "1,234,567"), None);
        assert_eq!(number(b';', "1.234,5"), None);
        assert_eq!(number(b';', ""), None);
    }
}
