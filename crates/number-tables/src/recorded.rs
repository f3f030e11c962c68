//! A recording as a table: whatever a logger writes as text, or any other format of tables. Columns with units, and times as
//! numbers or time stamps.

mod layout;
mod stamp;

use std::borrow::Cow;
use std::io::Cursor;
use std::path::{Path, PathBuf};

use crate::csv_file::Decimals;
use crate::files::FileError;
use crate::rows::{How, Rows};
use fmu_import::units::known;
use fmu_points::names::{did_you_mean, nearest};
pub use layout::composed;
use layout::{Found, unit};
pub use stamp::{Clock, Stamp, stamp};

/// What is known of a recording before it is read.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Layout {
    /// What stands between cells: `,` `;` `|` `tab` or `space`.
    pub delimiter: Option<String>,
    /// The line of the names, from 1.
    pub header: Option<usize>,
    /// The form of time stamps in the letters of strftime.
    pub format: Option<String>,
}

/// A recording's columns by name.
#[derive(Debug)]
pub struct RecordedTable {
    path: PathBuf,
    columns: Vec<Column>,
    /// How many rows there are.
    pub rows: usize,
    /// The first line behind the first row that holds no number, and how many such lines there are.
    pub others: Option<(u64, usize)>,
    /// The first line of another table above, and how many rows of numbers that has.
    pub above: Option<(u64, usize)>,
}

/// A column.
#[derive(Debug, Default)]
pub struct Column {
    name: String,
    /// The name without the unit in it.
    bare: String,
    /// The unit in the row below the header or in the name.
    pub unit: Option<String>,
    /// The numbers, not a number where there is none; of a column of time stamps the seconds since the first one.
    pub values: Vec<f64>,
    /// The first one of time stamps.
    pub first: Option<Stamp>,
    /// The line of the first number that is less than the one before.
    pub fall: Option<u64>,
    /// How many cells are empty.
    pub empty: usize,
    /// How many cells hold something that is no number.
    pub unreadable: usize,
    /// The first of these.
    pub trouble: Option<String>,
}

/// A name without the unit in it, and that: `n [1/min]`, and with a known unit `n (rpm)`, `n in rpm`, `n / rpm`.
fn name_and_unit(name: &str) -> (&str, Option<String>) {
    let enclosed = |from: char, to: char| name.strip_suffix(to).and_then(|name| name.rsplit_once(from));
    let known = |pair: &(&str, &str)| known::usual(&unit(pair.1)).is_some();
    let parts = enclosed('[', ']').or_else(|| {
        let words = [" in ", " / "].iter().filter_map(|word| name.rsplit_once(word));
        enclosed('(', ')').into_iter().chain(words).find(known)
    });
    match parts {
        Some((bare, inner)) if !bare.trim().is_empty() => (bare.trim_end_matches(['/', ' ']).trim(), Some(unit(inner))),
        _ => (name, None),
    }
}

/// The same of `n/(1/min)`, where the part before the unit is that of no other column, as a folder would be.
fn name_over_unit<'a>(name: &'a str, names: &[String]) -> Option<(&'a str, Option<String>)> {
    let slashes = name.match_indices('/').map(|(place, _)| place);
    let parts = slashes.map(|place| (name[..place].trim(), unit(&name[place + 1..])));
    let is_unit = |(bare, unit): &(&str, String)| !bare.is_empty() && known::usual(unit).is_some();
    let (bare, unit) = parts.into_iter().find(is_unit)?;
    let of_folder = |other: &&String| other.strip_prefix(bare).is_some_and(|rest| rest.trim_start().starts_with('/'));
    (names.iter().filter(of_folder).count() == 1).then_some((bare, Some(unit)))
}

/// Whether two names of units mean the same; an unknown one may mean anything.
fn may_agree(one: &str, other: &str) -> bool {
    let usual = [one, other].map(known::usual);
    matches!(usual, [None, _] | [_, None]) || usual[0] == usual[1]
}

/// The rows of a text.
struct TextRows {
    path: PathBuf,
    names: Vec<String>,
    reader: csv::Reader<Cursor<Vec<u8>>>,
    record: csv::StringRecord,
    decimals: Decimals,
    /// Lines above the first row.
    above: u64,
}

impl TextRows {
    fn new(path: &Path, text: &str, found: &Found) -> Self {
        let above: usize = text.split_inclusive('\n').take(found.first).map(str::len).sum();
        let (mut separator, mut rest) = (found.separator, Cow::Borrowed(&text[above..]));
        if separator == b' ' {
            let lines = rest.lines().map(|line| line.split_whitespace().collect::<Vec<_>>().join("\t") + "\n");
            (separator, rest) = (b'\t', Cow::Owned(lines.collect()));
        }
        let mut builder = csv::ReaderBuilder::new();
        builder.trim(csv::Trim::All).has_headers(false).flexible(true).comment(Some(b'#'));
        Self {
            path: path.to_owned(),
            names: found.names.clone(),
            reader: builder.delimiter(separator).from_reader(Cursor::new(rest.into_owned().into_bytes())),
            record: csv::StringRecord::new(),
            decimals: Decimals::new(separator),
            above: found.first as u64,
        }
    }
}

impl Rows for TextRows {
    fn names(&self) -> &[String] {
        &self.names
    }

    fn advance(&mut self) -> Result<bool, FileError> {
        let more = self.reader.read_record(&mut self.record);
        let more = more.map_err(|error| FileError::new(&self.path, error.to_string()))?;
        if more && self.record.iter().any(|cell| cell.contains('\n')) {
            let message = format!("line {}: a quote without an end; close or remove it", self.line());
            return Err(FileError::new(&self.path, message));
        }
        let more_cells = self.record.iter().skip(self.names.len()).any(|cell| !cell.is_empty());
        if more && more_cells {
            let unequal = layout::unequal(self.record.len(), self.names.len());
            let message = format!("line {} {unequal}", self.line());
            return Err(FileError::new(&self.path, message));
        }
        Ok(more)
    }

    fn number(&self, place: usize) -> Option<f64> {
        self.decimals.number(&self.text(place))
    }

    fn whole(&self, place: usize) -> Option<u64> {
        self.text(place).parse().ok()
    }

    fn text(&self, place: usize) -> Cow<'_, str> {
        Cow::Borrowed(self.record.get(place).unwrap_or(""))
    }

    fn line(&self) -> u64 {
        self.above + self.record.position().map_or(0, csv::Position::line)
    }
}

impl RecordedTable {
    /// Reads a recording.
    ///
    /// # Errors
    /// When it cannot be read, or holds no rows of numbers, with a remedy.
    pub fn read(path: &Path, layout: &Layout) -> Result<Self, FileError> {
        if let Some(open) = crate::no_text(path) {
            // What this build cannot decompress, the Python package can.
            return open(path, How::default())
                .and_then(|rows| Self::fill(path, rows, Vec::new(), layout))
                .map_err(|error| layout::advice(path).unwrap_or(error));
        }
        let text = layout::text(path)?;
        let text = match text.contains('\n') {
            true => text,
            false => text.replace('\r', "\n"),
        };
        let found = layout::find(path, &text, layout)?;
        let rows = TextRows::new(path, &text, &found);
        drop(text);
        let table = Self::fill(path, Box::new(rows), found.units, layout)?;
        Ok(Self { above: found.above, ..table })
    }

    fn fill(
        path: &Path,
        mut rows: Box<dyn Rows>,
        mut units: Vec<Option<String>>,
        layout: &Layout,
    ) -> Result<Self, FileError> {
        units.resize(rows.names().len(), None);
        let column = |(name, unit): (&String, Option<String>)| {
            let (bare, own) = match name_and_unit(name) {
                (_, None) => name_over_unit(name, rows.names()).unwrap_or((name, None)),
                parts => parts,
            };
            Column { name: name.clone(), bare: bare.to_owned(), unit: unit.or(own), ..Column::default() }
        };
        let mut table = Self {
            path: path.to_owned(),
            columns: rows.names().iter().zip(units).map(column).collect(),
            rows: 0,
            others: None,
            above: None,
        };
        let form = layout.format.as_deref();
        while rows.advance()? {
            let has_value = |k| rows.number(k).is_some() || stamp(&rows.text(k), form).is_some();
            if !(0..table.columns.len()).any(has_value) {
                let (_, count) = table.others.get_or_insert((rows.line(), 0));
                *count += 1;
                continue;
            }
            table.rows += 1;
            for (k, column) in table.columns.iter_mut().enumerate() {
                column.push(&rows.text(k), rows.number(k), form, rows.line());
            }
        }
        match table.rows {
            0 => Err(FileError::new(path, "no rows of numbers")),
            _ => Ok(table),
        }
    }

    /// The file.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The name of the first column that may be one of times.
    pub fn first(&self) -> &str {
        let mut columns = self.columns.iter();
        let sound = columns.find(|column| {
            let [unreadable, empty] = [column.unreadable, column.empty];
            2 * unreadable < self.rows && empty < self.rows
        });
        sound.or(self.columns.first()).map_or("", |column| &column.name)
    }

    /// How many columns there are.
    pub fn width(&self) -> usize {
        self.columns.len()
    }

    /// The place of a column, 0 where there is none.
    pub fn place(&self, name: &str) -> usize {
        let is_it = |column: &Column| self.get(name).is_some_and(|known| std::ptr::eq(known, column));
        self.columns.iter().position(is_it).unwrap_or(0)
    }

    /// A column by its name, with or without the unit in it; none where there is none.
    pub fn get(&self, name: &str) -> Option<&Column> {
        let exact = self.columns.iter().find(|column| column.name == name);
        exact.or_else(|| self.columns.iter().find(|column| column.bare == name))
    }

    /// A column by its name, with or without the unit in it.
    ///
    /// # Errors
    /// When there is none.
    pub fn column(&self, name: &str) -> Result<&Column, FileError> {
        self.get(name).ok_or_else(|| Self::none_has(&[self], name))
    }

    /// That none of some tables, of which there is at least one, has a column, with the names that they have.
    pub fn none_has(tables: &[&Self], name: &str) -> FileError {
        const MANY: usize = 20;
        let columns = tables.iter().flat_map(|table| &table.columns);
        let suggestion = did_you_mean(nearest(name, columns.map(|column| column.bare.as_str())));
        let has = |table: &Self| {
            let names = table.columns.iter().map(|column| column.name.as_str());
            names.take(MANY).collect::<Vec<_>>().join(", ")
        };
        let others: String =
            tables[1..].iter().map(|table| format!("; {} has {}", table.path.display(), has(table))).collect();
        tables[0].wrong(format!("there is no column `{name}`{suggestion}; it has {}{others}", has(tables[0])))
    }

    fn wrong(&self, message: String) -> FileError {
        FileError::new(&self.path, message)
    }

    /// The unit of a column: that of the settings, which the recording must not contradict, or the recording's; by its usual
    /// name.
    ///
    /// # Errors
    /// When the two contradict each other, and when there is none.
    pub fn unit(&self, name: &str, wanted: Option<&str>) -> Result<String, FileError> {
        let known = self.column(name)?.unit.as_deref();
        match (wanted, known) {
            (Some(wanted), Some(known)) if !may_agree(wanted, known) => Err(self.wrong(format!(
                "column `{name}` is in `{known}`, and the settings say `{wanted}`; correct one of them"
            ))),
            (Some(unit), _) | (None, Some(unit)) => {
                let usual = known::usual(unit).unwrap_or(unit);
                Ok(usual.to_owned())
            }
            (None, None) => Err(self.wrong(format!(
                "column `{name}` has no unit; add `unit` to it in the settings or a row of units below the header"
            ))),
        }
    }

    /// The times in a column: what a time stamp counts from, and the rows' numbers as they are written or the seconds since
    /// that stamp.
    ///
    /// # Errors
    /// With the line of a cell that is no time.
    pub fn times(&self, name: &str) -> Result<(Option<Stamp>, &[f64]), FileError> {
        let column = self.column(name)?;
        match &column.trouble {
            Some(trouble) => Err(self.wrong(format!(
                "{trouble} of column `{name}` is neither a number nor a time such as 2026-11-22T13:15:07.250; correct the \
                 cell, or say `format` in the settings' time"
            ))),
            None => Ok((column.first, &column.values)),
        }
    }
}

impl Column {
    fn push(&mut self, cell: &str, number: Option<f64>, form: Option<&str>, line: u64) {
        let has_stamps = self.first.is_some();
        let mut of_stamp = || {
            let stamp = stamp(cell, form)?;
            let first = *self.first.get_or_insert(stamp);
            // The difference is exact; a recording is shorter than the 104 days up to which nanoseconds are.
            let seconds = (stamp.nanoseconds - first.nanoseconds) as f64 * 1e-9;
            let last = self.values.iter().rev().find(|value| value.is_finite());
            // A time of day begins anew at midnight.
            let days = match (stamp.clock, last) {
                (Clock::Day, Some(last)) => ((last - seconds) / 86_400.0).round().max(0.0),
                _ => 0.0,
            };
            (first.clock == stamp.clock).then_some(seconds + 86_400.0 * days)
        };
        let value = match (number, has_stamps || form.is_some()) {
            (Some(number), false) => Some(number),
            _ if cell.is_empty() => None,
            // A column of numbers has no stamps.
            (None, false) if self.values.iter().any(|value| value.is_finite()) => None,
            _ => of_stamp(),
        };
        let value = value.filter(|value| value.is_finite());
        if value.is_none() {
            // Loggers write signs such as `-` where nothing was measured.
            match cell.chars().any(|c| c.is_alphanumeric() || c == '∞') && !cell.eq_ignore_ascii_case("nan") {
                true => {
                    self.unreadable += 1;
                    self.trouble.get_or_insert_with(|| format!("line {line}: `{cell}`"));
                }
                false => self.empty += 1,
            }
        }
        let last = || self.values.iter().rev().find(|value| value.is_finite());
        if value.is_some_and(|value| last().is_some_and(|last| value < *last)) {
            self.fall.get_or_insert(line);
        }
        self.values.push(value.unwrap_or(f64::NAN));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::typed;

    fn table(text: &str) -> Result<RecordedTable, FileError> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("m.csv");
        std::fs::write(&path, text).unwrap();
        RecordedTable::read(&path, &Layout::default())
    }

    #[test]
    fn units_and_time_stamps_of_a_table() {
        let text = "t;F;M\n[s];[kN];(Nm)\n2026-11-22T12:00:59,5Z;0,75;0,4\n2026-11-22T13:01:00.502+01:00;0,8;\n";
        let table = table(text).unwrap();
        let (first, times) = table.times("t").unwrap();
        assert_eq!(first.unwrap().clock, Clock::Zone);
        assert_eq!(times.len(), 2);
        assert!(times[0] == 0.0 && (times[1] - 1.002).abs() < 1e-12);
        assert_eq!(table.column("F").unwrap().values, [0.75, 0.8]);
        let torque = table.column("M").unwrap();
        assert!(torque.values[1].is_nan());
        assert_eq!((torque.empty, torque.unreadable), (1, 0));
        assert_eq!(table.unit("F", None).unwrap(), "kN");
        assert_eq!(table.unit("M", Some("N.m")).unwrap(), "N.m");
        let error = table.unit("F", Some("N")).unwrap_err().to_string();
        assert!(error.contains("m.csv: column `F` is in `kN`"), "{error}");
    }

    #[test]
    fn units_stand_in_names() {
        let table =
            table("t [ms],n in rpm,p (bar),T / °C,side (left)\n0,1,2,3,4\n1,1,2,3,OVR\nend of record,,,,\n").unwrap();
        for (name, unit) in [("t", "ms"), ("n", "rpm"), ("p", "bar"), ("T", "degC")] {
            assert_eq!(table.unit(name, None).unwrap(), unit);
        }
        assert_eq!(table.unit("side (left)", Some("mm")).unwrap(), "mm");
        let side = table.column("side (left)").unwrap();
        assert_eq!((side.unreadable, side.trouble.as_deref()), (1, Some("line 3: `OVR`")));
        assert_eq!((table.rows, table.others), (2, Some((4, 1))));
        let error = table.column("sid (left)").unwrap_err().to_string();
        assert!(error.contains("did you mean") && error.contains("it has t [ms], n in rpm"), "{error}");
    }

    #[test]
    fn units_stand_behind_a_slash() {
        let units = "Zeit/ms,y/degC,n/(1/min),a/b/bar,run/t,run/T\n0,1,2,3,4,5\n1,1,2,3,4,5\n";
        let table = table(units).unwrap();
        for (name, unit) in [("Zeit", "ms"), ("y", "degC"), ("n", "rpm"), ("a/b", "bar")] {
            assert_eq!(table.unit(name, None).unwrap(), unit);
        }
        // Channels of a folder.
        assert!(table.column("run/T").unwrap().unit.is_none() && table.get("run").is_none());
    }

    /// What is lost from the first rows is told as that from later ones.
    #[test]
    fn rows_of_words_are_told_wherever_they_stand() {
        for place in [1, 150, 399] {
            let mut rows: Vec<String> = (0..400).map(|k| format!("{k},2")).collect();
            rows.insert(place + 1, "t,F".to_owned());
            rows[place] = format!("{place},n/a");
            let table = table(&format!("t,F\n{}\n", rows.join("\n"))).unwrap();
            let line = place as u64 + 3;
            assert_eq!((table.rows, table.others), (400, Some((line, 1))));
            assert_eq!(table.column("F").unwrap().unreadable, 1);
            assert_eq!(table.first(), "t");
        }
        let lost = table("t,state,F\n0,on,1\nn/a,on,1\n2,on,1\n3,on,2\n").unwrap();
        assert_eq!(lost.first(), "t");
    }

    #[test]
    fn what_is_odd_in_a_file_is_known_by_its_line() {
        let odd = table("t,F\n0,1\n1,2\n0.5,3\n0.7,4\n").unwrap();
        assert_eq!(odd.column("t").unwrap().fall, Some(4));
        assert_eq!(odd.column("F").unwrap().fall, None);
        let two = "raw;bar\n0;0\n10;16\n\nt;p\n0;1,5\n1;1,6\n2;1,7\n";
        assert_eq!(table(two).unwrap().above, Some((2, 2)));
        // An umlaut as two characters is the same.
        let split = table("t,Kra\u{308}fte [N]\n0,1\n1,2\n").unwrap();
        assert_eq!(split.column("Kr\u{e4}fte").unwrap().values, [1.0, 2.0]);
    }

    #[test]
    fn a_table_without_units_and_times_that_are_none() {
        let plain = table("t,F\n0,1\n1,2\n").unwrap();
        assert_eq!(plain.column("t").unwrap().values, [0.0, 1.0]);
        let error = plain.unit("F", None).unwrap_err().to_string();
        assert!(error.contains("`F` has no unit; add `unit`"), "{error}");
        for (text, expected) in [
            ("t,F\n0,1\nsoon,2\n", "line 3: `soon` of column `t` is neither"),
            ("t,F\n2026-11-22T12:00:00Z,1\n2026-11-22T12:00:01,2\n", "line 3: `2026-11-22T12:00:01` of"),
        ] {
            let error = table(text).unwrap().times("t").unwrap_err().to_string();
            assert!(error.contains(expected), "{error}");
        }
        // Midnight.
        let night = table("t;F\n23:59:59,5;1\n00:00:00,5;2\n").unwrap();
        assert_eq!(night.times("t").unwrap().1, [0.0, 1.0]);
        let error = table("t,F\n0,1,5\n").unwrap_err().to_string();
        assert!(error.contains("semicolons"), "{error}");
    }

    #[test]
    fn a_table_that_is_no_text_is_a_recording_too() {
        let folder = tempfile::tempdir().unwrap();
        let [csv, path] = ["m.csv", "m.parquet"].map(|name| folder.path().join(name));
        std::fs::write(&csv, "t,F [N]\n0,1.5\n1,2.5\n").unwrap();
        let file = std::fs::File::create(&path).unwrap();
        typed::convert(&csv, file, |_, _| typed::Kind::Number).unwrap();
        let table = RecordedTable::read(&path, &Layout::default()).unwrap();
        let force = table.column("F").unwrap();
        assert_eq!((&*force.values, force.unit.as_deref()), (&[1.5, 2.5][..], Some("N")));
        // Only what is of a format that the Python package reads is to be converted.
        for (content, converts) in [("PAR1, and no more", true), ("t,F\n0,1\n1,2\n", false)] {
            std::fs::write(&path, content).unwrap();
            let error = RecordedTable::read(&path, &Layout::default()).unwrap_err();
            let told = error.to_string();
            assert_eq!(told.contains("convert it with"), converts, "{told}");
        }
    }
}
