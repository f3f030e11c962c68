//! Csv files as programs and spreadsheets write them: commas, semicolons or tabs between cells, and
//! decimal commas where commas separate nothing.

use std::{
    borrow::Cow,
    fs::File,
    io::{self, BufRead, BufReader, Read, Seek, Take},
    iter::Peekable,
    path::{Path, PathBuf},
    vec::IntoIter,
};

use csv::StringRecord;

use crate::{
    files::{self, FileError, Result, convert},
    rows::Rows,
};
use fmu_points::tell::{is_hidden, visible};

/// The longest row that is read, MiB.
const MOST_ROW: u64 = 64;
const MOST_ROW_BYTES: u64 = MOST_ROW << 20;

/// Lines that begin with it are left out.
const COMMENT: u8 = b'#';

/// A csv file that is being read.
#[derive(Debug)]
struct CsvFile {
    path: PathBuf,
    reader: csv::Reader<Take<File>>,
    separator: u8,
    /// Of each column; where commas separate cells, a point is the decimal mark.
    marks: Vec<Marks>,
}

/// What a column's cells tell of its decimal mark, for point and comma each: the first cell (with its line) in which the mark can
/// only be decimal, and the first in which it may separate thousands. Columns are judged apart.
#[derive(Clone, Debug, Default)]
struct Marks {
    decimal: [Option<(u64, String)>; 2],
    unclear: [Option<(u64, String)>; 2],
}

impl Marks {
    fn see(&mut self, separator: u8, line: u64, cell: &str) {
        let Some(mark) = MARKS.iter().position(|&mark| cell.contains(mark)) else { return };
        if self.decimal[mark].is_none() && number(separator, cell).is_some() {
            let is_unclear = has_thousands(cell, MARKS[mark]);
            let seen = if is_unclear { &mut self.unclear[mark] } else { &mut self.decimal[mark] };
            seen.get_or_insert_with(|| (line, cell.to_owned()));
        }
    }

    /// What has two readings, with its line. Whole numbers tell nothing: some loggers group from five figures on.
    fn unclear(&self) -> Option<(u64, String)> {
        let may_be = |mark: usize| {
            let (line, cell) = self.unclear[mark].as_ref()?;
            let is_clear = self.decimal[mark].is_some() && self.decimal[1 - mark].is_none();
            let (without, with) = (cell.replace(MARKS, ""), cell.replace(',', "."));
            (!is_clear).then(|| (*line, format!("`{cell}` may be {without} or {with}")))
        };
        may_be(0).or_else(|| may_be(1)).or_else(|| match &self.decimal {
            [Some((_, point)), Some((line, comma))] => {
                Some((*line, format!("`{comma}` has a decimal comma and `{point}` a decimal point")))
            }
            _ => None,
        })
    }
}

const MARKS: [char; 2] = ['.', ','];

impl CsvFile {
    fn open(path: &Path) -> Result<Self> {
        Self::begin(path).map_err(|error| FileError::system(path, error))
    }

    fn begin(path: &Path) -> io::Result<Self> {
        let mut file = files::open(path)?;
        let mut start = BufReader::new(&file).take(MOST_ROW_BYTES);
        let archive = start.fill_buf()?.starts_with(b"PK\x03\x04");
        if archive {
            return Err(io::Error::other("a zip archive, such as a spreadsheet or an FMU; save the table as csv"));
        }
        let separator = separator(&mut start)?;
        file.rewind()?;
        let mut builder = csv::ReaderBuilder::new();
        builder.trim(csv::Trim::All).comment(Some(COMMENT));
        let file = file.take(MOST_ROW_BYTES);
        Ok(Self {
            path: path.to_owned(),
            reader: builder.delimiter(separator).from_reader(file),
            separator,
            marks: Vec::new(),
        })
    }

    /// The cells of its first row.
    fn header(&mut self) -> Result<Vec<String>> {
        let header = self
            .reader
            .headers()
            .map_err(|error| wrong(&self.path, &error))?
            .iter()
            .map(|name| text(name).into_owned())
            .collect();
        self.check_row()?;
        Ok(header)
    }

    /// Reads the next row, without the blanks around cells; none behind the last one.
    fn row(&mut self, row: &mut StringRecord) -> Result<bool> {
        self.reader.get_mut().set_limit(MOST_ROW_BYTES);
        let more = self.reader.read_record(row).map_err(|error| wrong(&self.path, &error))?;
        self.check_row()?;
        if self.separator != b',' {
            self.marks.resize(row.len().max(self.marks.len()), Marks::default());
            let line = row.position().map_or(0, csv::Position::line);
            self.marks.iter_mut().zip(row.iter()).for_each(|(marks, cell)| marks.see(self.separator, line, cell));
        }
        Ok(more)
    }

    /// A row that ends with what may be read of it may be longer.
    fn check_row(&self) -> Result {
        if self.reader.get_ref().limit() > 0 {
            return Ok(());
        }
        Err(FileError::new(
            &self.path,
            format!(
                "line {}: a row longer than {MOST_ROW} MiB, which is the most that is read; look for a quote without an end",
                self.reader.position().line()
            ),
        ))
    }
}

/// A csv file as [`Rows`].
struct CsvRows {
    file: CsvFile,
    names: Vec<String>,
    record: StringRecord,
    /// Whether `record` has not been given yet: blank rows stand before it.
    is_ahead: bool,
    /// The rows that are blank. The reader skips them; in a table of one column they are empty cells, but for those at the end.
    blanks: Peekable<IntoIter<usize>>,
    is_blank: bool,
    count: usize,
    skipped: Vec<usize>,
}

/// Opens a csv file.
///
/// # Errors
/// When it cannot be read.
pub fn rows(path: &Path, gaps: bool) -> Result<Box<dyn Rows>> {
    let mut file = CsvFile::open(path)?;
    let names = file.header()?;
    let keeps = gaps && names.len() == 1;
    let (blanks, skipped) = files::open(path)
        .and_then(|file| blank(BufReader::new(file), keeps))
        .map_err(|error| FileError::system(path, error))?;
    Ok(Box::new(CsvRows {
        file,
        names,
        record: StringRecord::new(),
        is_ahead: false,
        blanks: blanks.into_iter().peekable(),
        is_blank: false,
        count: 0,
        skipped,
    }))
}

impl Rows for CsvRows {
    fn names(&self) -> &[String] {
        &self.names
    }

    fn advance(&mut self) -> Result<bool> {
        self.is_ahead = self.is_ahead || self.file.row(&mut self.record)?;
        if !self.is_ahead {
            return Ok(false);
        }
        self.is_blank = self.blanks.next_if_eq(&self.count).is_some();
        self.is_ahead = self.is_blank;
        self.count += 1;
        Ok(true)
    }

    fn number(&self, place: usize) -> Option<f64> {
        number(self.file.separator, &self.text(place))
    }

    fn whole(&self, place: usize) -> Option<u64> {
        self.text(place).parse().ok()
    }

    fn unclear(&self, place: usize) -> Option<(u64, String)> {
        self.file.marks.get(place)?.unclear()
    }

    fn skipped(&self) -> &[usize] {
        &self.skipped
    }

    fn text(&self, place: usize) -> Cow<'_, str> {
        let cell = self.record.get(place).filter(|_| !self.is_blank);
        Cow::Borrowed(cell.unwrap_or(""))
    }

    fn line(&self) -> u64 {
        self.record.position().map_or(0, csv::Position::line)
    }
}

/// Whether this mark of a number could stand between thousands.
fn has_thousands(cell: &str, mark: char) -> bool {
    let mut parts = cell.trim_start_matches(['+', '-']).split(mark);
    let is_first = |part: &str| (1..=3).contains(&part.len()) && !part.starts_with('0');
    let is_first = parts.next().is_some_and(is_first);
    let mut parts = parts.peekable();
    is_first && parts.peek().is_some() && parts.all(|part| part.len() == 3 && part.bytes().all(|c| c.is_ascii_digit()))
}

pub(crate) fn number(separator: u8, cell: &str) -> Option<f64> {
    let point = || {
        let decimal_comma = separator != b',' && cell.matches(',').count() == 1;
        (decimal_comma && !cell.contains('.')).then(|| cell.replace(',', "."))
    };
    cell.parse().ok().or_else(|| point().and_then(|cell| cell.parse().ok()))
}

/// The separator in the first line that is neither blank nor a comment.
fn separator(file: &mut impl BufRead) -> io::Result<u8> {
    let mut line = Vec::new();
    while file.read_until(b'\n', &mut line)? > 0 {
        let text = line.trim_ascii();
        if !text.is_empty() && !text.starts_with(&[COMMENT]) {
            break;
        }
        line.clear();
    }
    let mut quoted = false;
    let mut counts = [(b',', 0), (b'\t', 0), (b';', 0)];
    for &byte in &line {
        quoted ^= byte == b'"';
        let count = counts.iter_mut().find(|(mark, _)| *mark == byte && !quoted);
        count.into_iter().for_each(|(_, count)| *count += 1);
    }
    // A tie goes to the last one: names hold commas more often than semicolons.
    Ok(counts.iter().max_by_key(|(_, count)| *count).map_or(b',', |&(byte, count)| if count > 0 { byte } else { b',' }))
}

/// The places of blank lines among the rows of a file, counted from 0 behind the header, where they are kept; and the other lines
/// between rows that are none: blank ones and those that begin with the sign of a comment.
///
/// # Errors
/// When it cannot be read, and when a row begins with a spreadsheet's error: it would be a comment.
fn blank(file: impl BufRead, keeps: bool) -> io::Result<(Vec<usize>, Vec<usize>)> {
    let is_of_error = |byte: &u8| byte.is_ascii_uppercase() || b"/0!?".contains(byte);
    let (mut rows, mut skipped, mut pending) = (Vec::new(), Vec::new(), Vec::new());
    let mut row: Option<usize> = None;
    for (place, line) in file.split(b'\n').enumerate() {
        let line = line?;
        let text = line.trim_ascii();
        if line.starts_with(&[COMMENT]) || (row.is_none() && text.is_empty()) {
            let cell = text.split(|byte| b",;\t".contains(byte)).next().unwrap_or_default();
            if row.is_some() && cell.len() > 1 && cell[1..].iter().all(is_of_error) {
                let cell = String::from_utf8_lossy(cell);
                return Err(io::Error::other(format!(
                    "line {}: `{cell}` makes the row a comment; leave the cell empty",
                    place + 1
                )));
            }
            pending.push(place + 1);
            continue;
        }
        if text.is_empty() && !keeps {
            pending.push(place + 1);
            continue;
        }
        if let Some(row) = row.filter(|_| text.is_empty()) {
            rows.push(row);
        } else {
            // What stands above the first row is none.
            if row.is_some_and(|row| row > rows.len()) {
                skipped.append(&mut pending);
            }
            pending.clear();
        }
        row = Some(row.map_or(0, |row| row + 1));
    }
    Ok((rows, skipped))
}

/// A text as a cell: where a spreadsheet would take it for a formula, an apostrophe before it prevents that, and what a
/// terminal would obey is written as `\u001b`. Numbers stay as they are.
pub fn cell(text: &str) -> Cow<'_, str> {
    let formula = is_formula(text) && text.parse::<f64>().is_err();
    if !formula && !text.contains(is_hidden) && !text.contains("\\u") {
        return Cow::Borrowed(text);
    }
    // What looks like a hidden character that is written so must not become one.
    let plain = text.replace("\\u", "\\u005cu");
    let mark = if formula { "'" } else { "" };
    Cow::Owned(format!("{mark}{}", visible(&plain)))
}

/// The text that [`cell`] made a cell of.
pub fn text(cell: &str) -> Cow<'_, str> {
    let mut text = Cow::Borrowed(cell);
    let mut rest = cell;
    if cell.contains("\\u") {
        let mut all = String::new();
        while let Some((before, after)) = rest.split_once("\\u") {
            let c = after.get(..4).and_then(|code| u32::from_str_radix(code, 16).ok()).and_then(char::from_u32);
            let c = c.filter(|c| *c == '\\' || is_hidden(*c));
            all += before;
            all.push(c.unwrap_or('\\'));
            rest = match c {
                Some(_) => &after[4..],
                None => &rest[before.len() + 1..],
            };
        }
        text = Cow::Owned(all + rest);
    }
    let bare = text.strip_prefix('\'').filter(|bare| is_formula(bare));
    match bare.map(str::to_owned) {
        Some(bare) => Cow::Owned(bare),
        None => text,
    }
}

/// Whether a text begins as a formula does. One that has an apostrophe before it already gets another, so that
/// [`text`] gives back either.
fn is_formula(text: &str) -> bool {
    text.trim_start_matches('\'').starts_with(['=', '+', '-', '@', '\t', '\r'])
}

/// Why a file cannot be read, for people.
fn wrong(path: &Path, error: &csv::Error) -> FileError {
    let line = |position: &Option<csv::Position>| {
        let line = position.as_ref().map_or(0, csv::Position::line);
        format!("line {}", line.max(1))
    };
    let message = match error.kind() {
        csv::ErrorKind::Io(error) => files::reason(path, error),
        csv::ErrorKind::Utf8 { pos, .. } => {
            format!("{} is no text in UTF-8; {}", line(pos), convert(path))
        }
        csv::ErrorKind::UnequalLengths { pos, expected_len, len } => format!(
            "{} has {len} cells instead of {expected_len} as the first line; a decimal comma needs semicolons between cells",
            line(pos)
        ),
        _ => error.to_string(),
    };
    FileError::new(path, message)
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
            let separator = separator(&mut header.as_bytes()).unwrap();
            assert_eq!(separator, expected, "{header}");
        }
    }

    #[test]
    fn blank_lines_have_their_places_among_the_rows() {
        for (text, places) in [
            ("y\n1\n2\n", vec![]),
            ("\n# made by hand\n\ny\n1\n\n2\n", vec![1]),
            ("y\n\n1\n# more\n\n\n2\n\n", vec![0, 2, 3, 5]),
        ] {
            assert_eq!(blank(text.as_bytes(), true).unwrap().0, places, "{text}");
        }
    }

    #[test]
    fn lines_between_rows_that_are_none_are_known() {
        let text = "# made by hand\n\ny,z\n# s,N\n1,2\n\n# 3,4\n5,6\n\n";
        assert_eq!(blank(text.as_bytes(), false).unwrap(), (vec![], vec![6, 7]));
        assert_eq!(blank("y\n1\n\n# 3\n2\n".as_bytes(), true).unwrap(), (vec![1], vec![4]));
    }

    #[test]
    fn a_row_that_begins_with_an_error_is_no_comment() {
        for (text, is_comment) in [
            ("F,n\n1,2\n#DIV/0!,3\n", false),
            ("F\n1\n#N/A\n", false),
            ("F,n\n# Made by hand, 3\n#\n1,2\n#note\n", true),
            ("#NOTE\nF,n\n1,2\n", true),
        ] {
            assert_eq!(blank(text.as_bytes(), true).is_ok(), is_comment, "{text}");
        }
    }

    #[test]
    fn no_text_becomes_a_formula() {
        for formula in ["=1+1", "+cmd|' /C calc'!A0", "-x", "@SUM(A1)", "\t=1", "-"] {
            let cell = cell(formula);
            assert_eq!(cell, format!("'{formula}"));
            assert_eq!(text(&cell), formula);
        }
        for plain in ["", "lag.y", "-1.5e3", "+2", "'quoted'", "der(x)", "a=b", "C:\\a", "a\nb"] {
            assert_eq!(cell(plain), plain);
            assert_eq!(text(plain), plain);
        }
    }

    #[test]
    fn nothing_hidden_is_in_a_cell() {
        let steering = "\x1b]0;owned\x07\u{9b}2J\u{202e}\r";
        assert_eq!(cell(steering), r"\u001b]0;owned\u0007\u009b2J\u202e\u000d");
        for plain in [steering, r"\u001b", r"\u005cu001b", r"\u00e9", "=\x1b", "\\u\x1b"] {
            assert_eq!(text(&cell(plain)), plain);
            assert!(!cell(plain).contains(is_hidden));
        }
        // What other programs write stays what it is.
        assert_eq!(text(r"\u00e9 \u12 \user"), r"\u00e9 \u12 \user");
    }

    #[test]
    fn a_row_without_end_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.csv");
        std::fs::write(&path, "x\n1\n\"").unwrap();
        let file = std::fs::OpenOptions::new().write(true).open(&path).unwrap();
        file.set_len(65 << 20).unwrap();
        let mut table = CsvFile::open(&path).unwrap();
        let mut row = StringRecord::new();
        assert_eq!(table.header().unwrap(), ["x"]);
        assert!(table.row(&mut row).unwrap());
        let error = table.row(&mut row).unwrap_err().to_string();
        assert!(error.contains("a row longer than 64 MiB"), "{error}");
        std::fs::write(&path, "PK\x03\x04").unwrap();
        let error = CsvFile::open(&path).unwrap_err().to_string();
        assert!(error.contains(": a zip archive"), "{error}");
    }

    proptest::proptest! {
        #[test]
        fn every_text_comes_back(plain in "['=+@\t\r-]{0,3}(\\\\u00|[\\\\u0159b\u{9b}\u{202e}\x07]|.){0,5}") {
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
        for (cell, expected) in
            [("1.000", true), ("-12.345", true), ("0.125", false), ("1.00", false), ("1000", false), ("1.5e3", false)]
        {
            assert_eq!(has_thousands(cell, '.'), expected, "{cell}");
        }
    }
}
