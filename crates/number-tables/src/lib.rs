#![doc = include_str!("../README.md")]

pub mod clocks;
pub mod csv_file;
pub mod files;
pub mod parquet;
pub mod recorded;
mod rows;

use crate::files::{FileError, Result, convert, in_a_line};
use std::{collections::HashSet, path::Path};

use fmu_import::units::known;
use fmu_points::names::{did_you_mean, nearest};
pub use rows::Rows;

type Open = fn(&Path, bool) -> Result<Box<dyn Rows>>;

/// Endings of files' names in lower case, and who reads them; other files are taken for the first one's. A new format is a file with
/// its [`Rows`], its `mod` line above and its line here.
const FORMATS: &[(&str, Open)] = &[("csv", csv_file::rows), ("parquet", parquet::rows)];

/// The most rows that are read, some gigabytes.
const MOST_ROWS: usize = 50_000_000;

/// Its place in [`FORMATS`].
fn place(path: &Path) -> Option<usize> {
    let ending = path.extension()?.to_ascii_lowercase();
    FORMATS.iter().position(|(known, _)| ending == *known)
}

/// Whether a file's name ends as that of a table.
pub fn is_table(path: &Path) -> bool {
    place(path).is_some()
}

/// Opens a table in the format that its ending names, in csv otherwise. With `gaps`, an empty cell is a missing value, and so is a
/// blank line of a table with one column.
///
/// # Errors
/// When it cannot be read.
pub fn open(path: &Path, gaps: bool) -> Result<Box<dyn Rows>> {
    let (_, open) = FORMATS[place(path).unwrap_or(0)];
    open(path, gaps)
}

/// A column's name without the unit in it, and that: `n [1/min]`, and with a known unit `n (rpm)` and `Current(A)`. What stands in
/// `x[2]` is an index, and `G(h)` and `T(min)` are names.
pub fn name_and_unit(name: &str) -> (&str, Option<String>) {
    let enclosed = |from: char, to: char| name.strip_suffix(to).and_then(|name| name.rsplit_once(from));
    let is_index = |bare: &str, inner: &str| {
        !bare.ends_with(' ') && inner.chars().all(|c| c.is_ascii_digit() || c == ',' || c == ' ')
    };
    let parts = enclosed('[', ']').filter(|(bare, inner)| !is_index(bare, inner)).or_else(|| {
        enclosed('(', ')').filter(|(bare, inner)| {
            let is_plain = *inner != "min" && (bare.len() > 2 || inner.len() > 1);
            let apart = bare.ends_with(' ') || is_time_name(bare) || is_plain;
            apart && known::is_like(inner.trim())
        })
    });
    match parts {
        Some((bare, inner)) if !bare.trim().is_empty() && !inner.trim().is_empty() => {
            let unit = inner.trim();
            (bare.trim(), Some(known::usual(unit).unwrap_or(unit).to_owned()))
        }
        _ => (name, None),
    }
}

/// A time has one of these units.
pub fn is_of_time(unit: &str) -> bool {
    known::between(unit, "s").is_some()
}

/// Whether a column is called time: `T` is a temperature.
pub fn is_time_name(name: &str) -> bool {
    name == "t" || ["time", "zeit"].iter().any(|word| name.eq_ignore_ascii_case(word))
}

/// The unit of a column: the file's and the one that is stated must be known to be the same.
///
/// # Errors
/// When they are not.
pub fn agreed<'a>(column: &str, in_file: Option<&'a str>, stated: Option<&'a str>) -> Result<Option<&'a str>, String> {
    match (in_file, stated) {
        (Some(file), Some(stated))
            if file != stated && known::usual(file).is_none_or(|usual| known::usual(stated) != Some(usual)) =>
        {
            let unknown = match known::usual(file) {
                Some(_) => "",
                None => ", which is no unit that is known here",
            };
            Err(format!(
                "column `{column}` is in `{file}`{unknown}, and `unit` says `{stated}`; correct one of them: the column's name in the \
                 file says how its numbers were written"
            ))
        }
        (None, None) if column.ends_with(')') && column.contains(" (") => Err(format!(
            "column `{column}`: what stands in brackets may be its unit, and is none that is known here; say `unit`"
        )),
        _ => Ok(stated.or(in_file)),
    }
}

fn empty(path: &Path) -> FileError {
    FileError::new(path, "the table has no rows")
}

/// Refuses columns with numbers that have two readings.
fn check_marks(path: &Path, rows: &dyn Rows, mut places: impl Iterator<Item = usize>) -> Result {
    let Some((name, (line, why))) = places.find_map(|place| Some((&rows.names()[place], rows.unclear(place)?))) else {
        return Ok(());
    };
    let message = format!("column `{}`: {why}; {} and asks for --decimal", shown(name), convert(path));
    Err(FileError::new(path, message).at_line(line))
}

fn twice(path: &Path, what: &str) -> FileError {
    FileError::new(path, format!("{what} is there twice; remove or rename one"))
}

/// The remedy where a cell is no number.
fn remedy(path: &Path, text: &str) -> String {
    let is_stamp = text.len() >= 8 && text.starts_with(|first: char| first.is_ascii_digit()) && text.contains(':');
    if is_stamp {
        return format!("; it looks like a time stamp: {}, in seconds", convert(path));
    }
    let remedy = if text.contains([',', '.']) && !text.contains(char::is_alphabetic) {
        "; a decimal comma needs cells that no commas separate, and no points in other cells, as in 1.000"
    } else if text.is_empty() {
        "; fill it, or remove the row"
    } else if text.starts_with('#') {
        "; a spreadsheet's error: leave the cell empty where a value may be missing, or mend the formula"
    } else if text.chars().any(char::is_alphabetic) {
        return format!(
            "; units belong behind the column's name (`F [N]`), an item of an enumeration is its number; {}",
            convert(path)
        );
    } else {
        ""
    };
    remedy.to_owned()
}

/// A column that is asked for: the names that it may have, and its purpose.
pub type Column = (Vec<String>, String);

/// A column of one name.
pub fn column(name: &str, purpose: impl Into<String>) -> Column {
    (vec![name.to_owned()], purpose.into())
}

/// Columns of numbers from a csv or Parquet file, with the rows' own numbers where it has a column `point`.
#[derive(Clone, Debug)]
pub struct Table {
    /// A row's numbers, in the order of the columns asked for.
    pub rows: Vec<Vec<f64>>,
    /// The rows' labels.
    pub labels: Vec<u64>,
    /// The units in the names of the columns asked for, by their usual letters.
    pub units: Vec<Option<String>>,
}

impl Table {
    /// Reads columns; `columns` gives for each the names that it may have, and its purpose.
    ///
    /// # Errors
    /// When the table cannot be read, a column is missing, or a cell is not a number.
    pub fn read(path: &Path, columns: &[Column]) -> Result<Self> {
        Ok(Self::load(path, columns, false)?.table)
    }

    /// With `gaps`, an empty cell is not a number instead of an error.
    fn load<'a>(path: &'a Path, columns: &[Column], gaps: bool) -> Result<Reading<'a>> {
        let mut rows = open(path, gaps)?;
        if rows.names().is_empty() {
            return Err(empty(path));
        }
        let mut reading = Reading::new(path, rows.names().to_vec(), columns)?;
        while rows.advance()? {
            reading.add(&*rows, gaps)?;
        }
        if reading.table.rows.is_empty() {
            return Err(empty(path));
        }
        check_marks(path, &*rows, reading.places.iter().copied())?;
        Ok(reading)
    }

    /// Reads a table of points, whose rows are told apart by their numbers.
    ///
    /// # Errors
    /// As [`Table::read`], and when two points have the same number.
    pub fn read_points(path: &Path, columns: &[Column]) -> Result<Self> {
        Self::load(path, columns, false)?.table.distinct(path)
    }

    /// Reads a table of results: an empty cell, as of a failed point, becomes NaN.
    ///
    /// # Errors
    /// As [`Table::read_points`].
    pub fn read_results(path: &Path, columns: &[Column]) -> Result<Self> {
        Self::load(path, columns, true)?.table.distinct(path)
    }

    fn distinct(self, path: &Path) -> Result<Self> {
        let mut known = HashSet::new();
        match self.labels.iter().find(|&&label| !known.insert(label)) {
            Some(label) => Err(twice(path, &format!("point {label}"))),
            None => Ok(self),
        }
    }
}

/// A table that is being read.
struct Reading<'a> {
    path: &'a Path,
    header: Vec<String>,
    /// Where the columns are that were asked for, and that of the labels.
    places: Vec<usize>,
    label: Option<usize>,
    /// Whether another column has a day in the first row.
    has_days: bool,
    table: Table,
}

impl<'a> Reading<'a> {
    fn new(path: &'a Path, header: Vec<String>, columns: &[Column]) -> Result<Self> {
        let places: Vec<usize> =
            columns.iter().map(|(names, purpose)| find(path, &header, names, purpose)).collect::<Result<_, _>>()?;
        let units = places.iter().map(|&place| name_and_unit(&header[place]).1).collect();
        Ok(Self {
            path,
            places,
            label: header.iter().position(|name| name.eq_ignore_ascii_case("point")),
            header,
            has_days: false,
            table: Table { rows: Vec::new(), labels: Vec::new(), units },
        })
    }

    fn add(&mut self, row: &dyn Rows, gaps: bool) -> Result {
        let numbers = self
            .places
            .iter()
            .map(|&place| {
                row.number(place)
                    .or_else(|| (gaps && row.text(place).is_empty()).then_some(f64::NAN))
                    .or_else(|| truth(&row.text(place)))
                    .ok_or_else(|| {
                        let (column, text) = (shown(&self.header[place]), shown(&row.text(place)));
                        let remedy = remedy(self.path, &text);
                        FileError::new(self.path, format!("column `{column}`: `{text}` is not a number{remedy}"))
                            .at_line(row.line())
                    })
            })
            .collect::<Result<_, _>>()?;
        let Table { rows, labels, .. } = &mut self.table;
        if rows.is_empty() {
            let is_day = |place: usize| clocks::is_day(name_and_unit(&self.header[place]).0, &row.text(place));
            self.has_days = (0..self.header.len()).any(is_day);
        }
        if rows.len() == MOST_ROWS {
            return Err(FileError::new(
                self.path,
                format!("more than {MOST_ROWS} rows, which is the most that is read here"),
            ));
        }
        rows.push(numbers);
        let label = self.label.and_then(|place| row.whole(place));
        labels.push(label.unwrap_or(rows.len() as u64));
        Ok(())
    }
}

/// Yes as 1, no as 0.
fn truth(text: &str) -> Option<f64> {
    [("false", 0.0), ("true", 1.0)]
        .iter()
        .find(|(word, _)| text.trim().eq_ignore_ascii_case(word))
        .map(|(_, number)| *number)
}

/// A cell as a message shows it: on one line, and not longer than people read.
fn shown(text: &str) -> String {
    const ENOUGH: usize = 60;
    let line = in_a_line(text);
    match line.char_indices().nth(ENOUGH) {
        Some((end, _)) => format!("{}...", &line[..end]),
        None => line,
    }
}

fn find(path: &Path, header: &[String], names: &[String], purpose: &str) -> Result<usize> {
    let bare = |place: usize| name_and_unit(&header[place]).0;
    let found = |name: &String| places(header.len(), |place| header[place] == *name, |place| bare(place) == name);
    let is_there = |name: &&String| header.contains(name);
    let named = names.iter().find(is_there).or_else(|| names.iter().find(|name| !found(name).is_empty()));
    match named.map(found).unwrap_or_default()[..] {
        [place] => return Ok(place),
        [place, ..] => return Err(twice(path, &format!("column `{}`", shown(&header[place])))),
        [] => {}
    }
    let column = &names[0];
    let near = nearest(column, header.iter().map(String::as_str)).map(shown);
    let rest = if header.iter().all(|name| name.parse::<f64>().is_ok()) {
        ": the first line must name the columns, and".to_owned()
    } else {
        did_you_mean(near.as_deref()) + ";"
    };
    Err(FileError::new(path, format!("no column `{column}` for {purpose}{rest} it has {}", listed(header))))
}

/// The places of the columns that have a name, or else of those that have it without their units.
fn places(count: usize, has: impl Fn(usize) -> bool, has_bare: impl Fn(usize) -> bool) -> Vec<usize> {
    let exact: Vec<usize> = (0..count).filter(|&place| has(place)).collect();
    if exact.is_empty() { (0..count).filter(|&place| has_bare(place)).collect() } else { exact }
}

/// Names of columns as a message shows them.
fn listed<'a>(names: impl IntoIterator<Item = &'a String, IntoIter: ExactSizeIterator>) -> String {
    const MANY: usize = 20;
    let names = names.into_iter();
    let further = names.len().saturating_sub(MANY);
    let further = (further > 0).then(|| format!("{further} more"));
    names.take(MANY).map(|name| shown(name)).chain(further).collect::<Vec<_>>().join(", ")
}
