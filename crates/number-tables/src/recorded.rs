//! A recording as a table: one row of names, `name [unit]`, and numbers below, as csv or Parquet. What a logger writes otherwise
//! becomes such a table by `convert`, which asks where two readings are possible; here nothing is guessed.

use std::{
    io::Read,
    path::{Path, PathBuf},
};

use crate::{
    Reading, Table,
    clocks::{self, is_day},
    column,
    files::{self, FileError, Result, convert},
    is_of_time, is_time_name, name_and_unit, shown,
};
use fmu_import::units::{Conversion, known};
use fmu_points::names::{did_you_mean, nearest};

/// A recording's columns by name.
#[derive(Debug)]
pub struct RecordedTable {
    path: PathBuf,
    /// In their order.
    pub columns: Vec<Column>,
    /// How many rows there are.
    pub rows: usize,
    /// How many lines between rows are blank or comments, and the first of them.
    pub skipped: Option<(usize, usize)>,
}

/// A column.
#[derive(Debug, Default)]
pub struct Column {
    /// With the unit in it.
    pub name: String,
    /// The name without the unit in it.
    bare: String,
    /// The unit in the name, by its usual letters.
    pub unit: Option<String>,
    /// The numbers, not a number where there is none.
    pub values: Vec<f64>,
    /// How many cells are empty.
    pub empty: usize,
    /// The cells that are no numbers: row, line and text.
    pub texts: Vec<(usize, u64, String)>,
}

impl Column {
    /// Whether it may be a time: by its unit, or by its name where it has none.
    fn is_time(&self) -> bool {
        self.unit.as_deref().map_or(is_time_name(&self.bare), is_of_time)
    }

    /// Whether its numbers rise; one alone may be a time.
    fn rises(&self) -> bool {
        let known: Vec<f64> = self.values.iter().copied().filter(|value| value.is_finite()).collect();
        self.texts.is_empty() && known.is_sorted() && (known.len() == 1 || known.first() < known.last())
    }

    /// Why it does not rise.
    fn why_no_time(&self) -> String {
        let name = &self.name;
        let pairs = self.values.iter().zip(self.values.iter().skip(1));
        if let Some((_, line, text)) = self.texts.first() {
            format!("line {line}: `{text}` in `{name}` is no number")
        } else if let Some((k, (before, after))) = pairs.enumerate().find(|(_, (before, after))| after < before) {
            format!("`{name}` falls from {before} to {after} in row {}", k + 2)
        } else {
            format!("`{name}` does not rise")
        }
    }
}

/// How files of other formats begin.
const BINARY: [&[u8]; 7] = [b"MDF ", b"UnFinMF", b"TDSm", b"\x89HDF", b"MATLAB", b"PK\x03\x04", b"\xd0\xcf\x11\xe0"];

impl RecordedTable {
    /// Reads a recording.
    ///
    /// # Errors
    /// When it cannot be read or is no plain table, with the command that makes one.
    pub fn read(path: &Path) -> Result<Self> {
        let table = Self::read_those(path, |_| true)?;
        if let Some(name) = table.names_signals() {
            return Err(FileError::new(
                path,
                format!(
                    "column `{name}` says in each row whose value it is; save a column for each, or a file for each"
                ),
            ));
        }
        if table.columns.iter().any(|column| column.values.iter().any(|value| value.is_finite())) {
            Ok(table)
        } else {
            Err(FileError::new(path, format!("no row of numbers below one row of names; {}", convert(path))))
        }
    }

    /// Reads the columns that may be the time; the others have no values.
    ///
    /// # Errors
    /// As [`RecordedTable::read`].
    pub fn read_times(path: &Path) -> Result<Self> {
        Self::read_those(path, Column::is_time)
    }

    fn read_those(path: &Path, is_read: fn(&Column) -> bool) -> Result<Self> {
        let mut begin = Vec::new();
        files::open(path)
            .and_then(|file| file.take(8).read_to_end(&mut begin))
            .map_err(|error| FileError::system(path, error))?;
        if BINARY.iter().any(|known| begin.starts_with(known)) {
            return Err(FileError::new(path, format!("not a plain table; {}", convert(path))));
        }
        let plain = |error: FileError| match error.kind {
            Some(_) => error,
            None => error.with(format!("; {}", convert(path))),
        };
        let mut rows = crate::open(path, true).map_err(plain)?;
        let column = |name: &String| {
            let (bare, unit) = name_and_unit(name);
            Column { name: name.clone(), bare: bare.to_owned(), unit, ..Column::default() }
        };
        let columns: Vec<Column> = rows.names().iter().map(column).collect();
        if columns.iter().all(|column| column.name.trim().is_empty()) {
            let message =
                "it is empty: its first line names the columns, such as `time,speed [rpm]`, and rows of numbers follow";
            return Err(FileError::new(path, message));
        }
        let mut table = Self { path: path.to_owned(), columns, rows: 0, skipped: None };
        while rows.advance().map_err(plain)? {
            if table.rows == 0 && (0..table.columns.len()).all(|k| rows.number(k).is_none() && !rows.text(k).is_empty())
            {
                return Err(FileError::new(
                    path,
                    format!("line {} below the names has no number; {}", rows.line(), convert(path)),
                ));
            }
            for (k, column) in table.columns.iter_mut().enumerate().filter(|(_, column)| is_read(column)) {
                let (text, number) = (rows.text(k), rows.number(k).filter(|number| !number.is_infinite()));
                match number {
                    Some(number) => column.empty += usize::from(number.is_nan()),
                    None if text.is_empty() => column.empty += 1,
                    None => column.texts.push((table.rows, rows.line(), shown(&text))),
                }
                column.values.push(number.unwrap_or(f64::NAN));
            }
            table.rows += 1;
        }
        crate::check_marks(path, &*rows, (0..table.width()).filter(|&place| is_read(&table.columns[place])))?;
        if let [first, ..] = rows.skipped() {
            table.skipped = Some((rows.skipped().len(), *first));
        }
        Ok(table)
    }

    /// The column that says in each row of which signal the value is, where a table has such rows: its values are one column of all.
    fn names_signals(&self) -> Option<&str> {
        const SIGNALS: [&str; 10] =
            ["signal", "name", "channel", "variable", "parameter", "sensor", "tag", "id", "pid", "item"];
        const VALUES: [&str; 4] = ["value", "values", "wert", "reading"];
        let called = |column: &&Column, names: &[&str]| names.iter().any(|name| column.bare.eq_ignore_ascii_case(name));
        self.columns
            .iter()
            .filter(|column| called(column, &SIGNALS))
            .find(|column| {
                let texts = column.texts.iter().map(|(_, _, text)| text.clone());
                let numbers = column.values.iter().filter(|value| value.is_finite()).map(f64::to_string);
                let count = texts.chain(numbers).collect::<std::collections::BTreeSet<_>>().len();
                count > 1 && count <= self.rows / 2
            })
            .filter(|_| self.columns.iter().any(|column| called(&column, &VALUES)))
            .map(|column| column.name.as_str())
    }

    /// The file.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The columns that may be the time, among those of which a caller knows no better.
    fn times(&self, may_be: &dyn Fn(&str) -> bool) -> Vec<&Column> {
        self.columns.iter().filter(|column| column.is_time() && may_be(&column.name)).collect()
    }

    /// Whether the rows follow each other in time: a column is called time, or has a unit of time and rises.
    pub fn is_over_time(&self, may_be: &dyn Fn(&str) -> bool) -> bool {
        let is_called = |column: &Column| is_time_name(&column.bare) && may_be(&column.name);
        self.columns.iter().any(is_called) || self.rows > 1 && self.times(may_be).iter().any(|column| column.rises())
    }

    /// The column of the time: the only one whose numbers rise among those that have a unit of time, or none and are called time.
    /// Neither its place nor a letter decides.
    ///
    /// # Errors
    /// When there is none or several, with the `remedy`.
    pub fn time(&self, may_be: &dyn Fn(&str) -> bool, remedy: &str) -> Result<&str> {
        let times = self.times(may_be);
        match times.iter().filter(|column| column.rises()).collect::<Vec<_>>().as_slice() {
            [one] => Ok(&one.name),
            [] => {
                let none = "none has a unit of time, or is called `time`".to_owned();
                Err(self.wrong(format!(
                    "no column is the time: {} (it has {}); {remedy}; where a column has time stamps, {}",
                    times.first().map_or(none, |column| column.why_no_time()),
                    self.names(),
                    convert(&self.path)
                )))
            }
            several => {
                let names: Vec<String> = several.iter().map(|column| format!("`{}`", column.name)).collect();
                Err(self.wrong(format!("the time may be {}; {remedy}", names.join(" or "))))
            }
        }
    }

    /// Whether a column has days.
    pub fn has_days(&self) -> bool {
        self.columns.iter().any(|column| {
            let text = column.texts.first().map(|(_, _, text)| text.clone());
            let first = text.or_else(|| column.values.first().map(f64::to_string));
            first.is_some_and(|cell| is_day(&column.bare, &cell))
        })
    }

    /// How many columns there are.
    pub fn width(&self) -> usize {
        self.columns.len()
    }

    /// The places of the columns of a name, with or without the unit in it.
    fn places(&self, name: &str) -> Vec<usize> {
        let columns = &self.columns;
        crate::places(columns.len(), |place| columns[place].name == name, |place| columns[place].bare == name)
    }

    /// The place of a column, 0 where there is none.
    pub fn place(&self, name: &str) -> usize {
        self.places(name).first().copied().unwrap_or(0)
    }

    /// A column by its name, with or without the unit in it; none where there is none.
    pub fn get(&self, name: &str) -> Option<&Column> {
        self.places(name).first().map(|&place| &self.columns[place])
    }

    /// A column by its name, with or without the unit in it.
    ///
    /// # Errors
    /// When there is none, or there are two.
    pub fn column(&self, name: &str) -> Result<&Column> {
        match self.places(name)[..] {
            [place] => Ok(&self.columns[place]),
            [] => Err(Self::none_has(&[self], name)),
            _ => Err(crate::twice(&self.path, &format!("column `{name}`"))),
        }
    }

    fn names(&self) -> String {
        crate::listed(self.columns.iter().map(|column| &column.name))
    }

    /// That none of some tables, of which there is at least one, has a column, with the names that they have.
    pub fn none_has(tables: &[&Self], name: &str) -> FileError {
        let columns = tables.iter().flat_map(|table| &table.columns);
        let suggestion = did_you_mean(nearest(name, columns.map(|column| column.bare.as_str())));
        let others: String =
            tables[1..].iter().map(|table| format!("; {} has {}", table.path.display(), table.names())).collect();
        tables[0].wrong(format!("there is no column `{name}`{suggestion}; it has {}{others}", tables[0].names()))
    }

    fn wrong(&self, message: String) -> FileError {
        FileError::new(&self.path, message)
    }

    /// The unit of a column: that of the settings, which the recording must not contradict, or the recording's; by its usual
    /// name.
    ///
    /// # Errors
    /// When the two are not known to be the same, and when there is none.
    pub fn unit(&self, name: &str, wanted: Option<&str>) -> Result<String> {
        let found = self.column(name)?.unit.as_deref();
        let unit = crate::agreed(name, found, wanted).map_err(|message| self.wrong(message))?.ok_or_else(|| {
            self.wrong(format!(
                "column `{name}` has no unit; write `{name} [unit]` in the file, or add `unit` to it in the settings"
            ))
        })?;
        Ok(known::usual(unit).unwrap_or(unit).to_owned())
    }

    /// The numbers of a column, in which some texts and numbers mean that there is none, and how many these are.
    ///
    /// # Errors
    /// With line and text of a cell that is neither a number nor one of these.
    pub fn values(&self, name: &str, missing: &[String]) -> Result<(Vec<f64>, usize)> {
        let column = self.column(name)?;
        let marks: Vec<f64> = missing.iter().filter_map(|mark| mark.parse().ok()).collect();
        if let Some((_, line, text)) = column.texts.iter().find(|(_, _, text)| !missing.contains(text)) {
            return Err(self.wrong(format!(
                "line {line}: `{text}` in column `{name}` is no number ({} such cells); where it marks missing values, write \
                 missing = [{text:?}]; else {}",
                column.texts.iter().filter(|(_, _, text)| !missing.contains(text)).count(),
                convert(&self.path)
            )));
        }
        let is_mark = |value: &f64| marks.contains(value);
        let count = column.texts.len() + column.values.iter().filter(|value| is_mark(value)).count();
        Ok((column.values.iter().map(|value| if is_mark(value) { f64::NAN } else { *value }).collect(), count))
    }
}

impl Table {
    /// Reads columns behind that of the times, which become seconds: the column of this name, or where none is stated that of
    /// [`RecordedTable::time`].
    ///
    /// # Errors
    /// As [`Table::read`], and when the times have no unit of time, or may be days or clocks.
    pub fn read_over_time(path: &Path, time: Option<&str>, columns: Vec<crate::Column>) -> Result<Self> {
        let time = match time {
            Some(time) => time.to_owned(),
            None => RecordedTable::read_times(path)?.time(&|_| true, "say time = \"...\"")?.to_owned(),
        };
        let columns: Vec<crate::Column> = std::iter::once(column(&time, "the time")).chain(columns).collect();
        let Reading { mut table, header, places, has_days, .. } = Self::load(path, &columns, false)?;
        let name = shown(&header[places[0]]);
        let way = match table.units[0].as_deref() {
            Some(unit) => known::between(unit, "s")
                .ok_or_else(|| format!("column `{name}` is in `{unit}`, which is no unit of time")),
            None => {
                let times: Vec<f64> = table.rows.iter().map(|row| row[0]).collect();
                let units = format!("write `{name} [ms]` in its first line");
                clocks::doubt(path, &name, &times, has_days, &units).map_or(Ok(Conversion::IDENTITY), Err)
            }
        };
        let way = way.map_err(|message| FileError::new(path, message))?;
        table.rows.iter_mut().for_each(|row| row[0] = way.value(row[0]));
        Ok(table)
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    fn read(text: &[u8]) -> Result<RecordedTable> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("m.csv");
        std::fs::write(&path, text).unwrap();
        RecordedTable::read(&path)
    }

    #[test]
    fn the_time_is_known_by_its_unit_or_name_and_rises() {
        for (text, time) in [
            ("n [rpm],t [s]\n5,0\n6,1\n", Some("t [s]")),
            // A temperature is no time, wherever it stands.
            ("T;Zeit\n20,5;0\n21,5;1\n", Some("Zeit")),
            ("T,M\n20,1\n21,2\n", None),
            ("nr,wait [s],Time (ms)\n1,5,0\n2,3,1\n", Some("Time (ms)")),
            ("t [s],uptime [h]\n0,0\n1,1\n", None),
            ("t,time\n0,0\n1,1\n", None),
            ("t [s],M\n1,0\n0,1\n", None),
        ] {
            let table = read(text.as_bytes()).unwrap();
            assert_eq!(table.time(&|_| true, "").ok(), time, "{text}");
        }
    }

    #[test]
    fn a_unit_may_stand_right_behind_the_name() {
        for (name, unit) in [
            ("Current(A)", Some("A")),
            ("t(s)", Some("s")),
            ("n(rpm)", Some("rpm")),
            ("F(kN)", Some("kN")),
            ("T (min)", Some("min")),
            ("Temp(min)", None),
            ("G(h)", None),
            ("Force (M1)", None),
            ("V(A)", None),
            ("x[2]", None),
            ("Dev(x)", None),
            ("tilt (mrad)", Some("mrad")),
            ("F (KN)", Some("KN")),
            ("P (MW)", Some("MW")),
            ("T (mean)", None),
            ("phase (a)", None),
        ] {
            assert_eq!(name_and_unit(name).1.as_deref(), unit, "{name}");
        }
    }

    #[test]
    fn what_may_be_a_unit_is_asked_about() {
        let agreed = |column, in_file, stated| crate::agreed(column, in_file, stated).map_err(|_| ());
        assert_eq!(agreed("p (inHg)", None, None), Err(()));
        assert_eq!(agreed("p (inHg)", None, Some("Pa")), Ok(Some("Pa")));
        assert_eq!(agreed("F", Some("KN"), Some("N")), Err(()));
        assert_eq!([agreed("p", None, None), agreed("der(x)", None, None)], [Ok(None); 2]);
    }

    #[test]
    fn studies_know_the_time_by_its_unit_too() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("m.csv");
        for (names, times) in [
            ("u,t [s]\n0,1\n2,3", Some([1.0, 3.0])),
            ("u,Time(ms)\n0,1\n2,3", Some([0.001, 0.003])),
            ("wait [s],time\n2,1\n0,3", Some([1.0, 3.0])),
            ("time,t [s]\n2,1\n0,3", Some([1.0, 3.0])),
            ("time,t [s]\n0,1\n,2\n2,3", None),
            ("wait [s],time\n0,1\n2,3", None),
            ("wait [s],t\n0,1\n2,3", None),
            ("u,v\n0,1\n2,3", None),
        ] {
            std::fs::write(&path, names).unwrap();
            let read = Table::read_over_time(&path, None, Vec::new());
            let found = read.map(|table| [table.rows[0][0], table.rows[1][0]]);
            match times {
                Some(times) => assert_eq!(found.unwrap(), times, "{names}"),
                None => assert!(found.unwrap_err().to_string().contains("say time = "), "{names}"),
            }
        }
    }

    /// 09:15:00 is no second 91,500; neither is a day, or a clock beside one, in whichever way the day is written.
    #[test]
    fn clocks_and_days_of_figures_are_no_seconds() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("m.csv");
        for (text, is_asked) in [
            ("time,u\n91500,1\n91600,2\n91700,3\n", true),
            ("time,u\n20260311,1\n20260312,2\n", true),
            ("time,u\n1.7e12,1\n1.8e12,2\n", true),
            ("Date,time,u\n20260311,915,1\n20260311,1000,2\n", true),
            ("Date,time,u\n260311,915,1\n260311,1000,2\n", true),
            ("a,time,u\n2026-03-11,915,1\n2026-03-11,1000,2\n", true),
            ("time,a,u\n915,11.03.2026,1\n1000,11.03.2026,2\n", true),
            ("time [s],u\n91500,1\n91600,2\n91700,3\n", false),
            ("time,u\n0,1\n30,2\n60,3\n90,4\n", false),
            ("Date,time,u\n20260311,30,1\n20260311,75.5,2\n", false),
        ] {
            std::fs::write(&path, text).unwrap();
            match Table::read_over_time(&path, None, Vec::new()).map_err(|error| error.to_string()) {
                Ok(_) => assert!(!is_asked, "{text}"),
                Err(error) => {
                    assert!(is_asked && error.contains("write `time [ms]`") && error.contains("%H%M%S"), "{error}")
                }
            }
        }
        // A missing cell does not make seconds of clocks.
        let times = [91_500.0, f64::NAN, 91_600.0, 91_700.0];
        assert!(clocks::doubt(&path, "t", &times, false, "").is_some());
    }

    #[test]
    fn thousands_and_decimals_are_told_apart_or_asked_about() {
        for text in [
            "t;F\n0;1.500\n1;2.250\n",
            "t;F\n0;950\n1;1.200\n",
            "t\tF\n0\t-1,500\n1\t2,250\n",
            "t;F\n0;1.500\n1;1500\n",
            "t;F\n0,5;980\n1,5;1.001\n",
            "t\tF\n0.5\t980\n1.5\t1,001\n",
            // What a mark is in another column says nothing.
            "t;F\n0.5;1.234\n1.5;2.345\n",
            "t;F\n0,0;1,500\n1,5;2,250\n",
            "t\tF\n0.5\t1.500\n1.5\t1500\n",
        ] {
            let error = read(text.as_bytes()).unwrap_err().to_string();
            assert!(
                error.contains(": column `F`: `") && error.contains(" may be ") && error.contains("convert"),
                "{error}"
            );
            let folder = tempfile::tempdir().unwrap();
            let path = folder.path().join("m.csv");
            std::fs::write(&path, text).unwrap();
            let error = Table::read(&path, &[column("F", "")]).unwrap_err().to_string();
            assert!(error.contains(" may be "), "{error}");
        }
        for (text, first) in [
            ("t;F\n0;1.500\n1;0.25\n", 1.5),
            ("t;F\n0,5;1.500\n1,5;0.250\n", 1.5),
            ("t;F\n0;1,500\n1;1500,25\n", 1.5),
            ("t,F\n0,1.500\n1,2.250\n", 1.5),
        ] {
            assert_eq!(read(text.as_bytes()).unwrap().get("F").unwrap().values[0], first, "{text}");
        }
        let error = read(b"t;F\n0;0.5\n1;0,25\n2;1.500\n").unwrap_err().to_string();
        assert!(error.contains("m.csv:3: column `F`: `0,25` has a decimal comma and `0.5` a decimal point"), "{error}");
        // A table of points is not asked about columns that nobody reads.
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("m.csv");
        std::fs::write(&path, "t;F\n0;1.500\n1;2.500\n").unwrap();
        assert!(Table::read(&path, &[column("t", "")]).is_ok());
    }

    #[test]
    fn a_row_for_each_value_of_each_signal_is_refused() {
        for text in
            ["time,signal,value\n0,F,1.5\n0,n,1500\n1,F,2.5\n1,n,1501\n", "t;ID;Wert\n0;1;5\n1;2;6\n2;1;5\n3;2;6\n"]
        {
            let error = read(text.as_bytes()).unwrap_err().to_string();
            assert!(error.contains("says in each row whose value it is"), "{error}");
        }
        // A running number, one name alone and columns of other names are none.
        for text in [
            "id,value\n1,5\n2,6\n3,7\n",
            "t,name,value\n0,F,1\n1,F,2\n",
            "t,signal,F\n0,on,1\n1,off,2\n2,on,3\n3,off,4\n",
        ] {
            assert!(read(text.as_bytes()).is_ok(), "{text}");
        }
    }

    #[test]
    fn why_no_column_is_the_time_is_said() {
        for (text, why) in [
            ("t [s],F\n0,1\n2,2\n1,3\n", "`t [s]` falls from 2 to 1 in row 3"),
            ("t [s],F\n0,1\n1,2\nTotal,3\n", "line 4: `Total` in `t [s]` is no number"),
        ] {
            let error = read(text.as_bytes()).unwrap().time(&|_| true, "").unwrap_err().to_string();
            assert!(error.contains(why), "{error}");
        }
    }

    #[test]
    fn units_must_agree() {
        let table = read(b"t [s],F [KN],n [1/min],M\n0,1,2,3\n1,2,3,4\n").unwrap();
        assert!(table.unit("F", Some("N")).unwrap_err().to_string().contains("`KN`"));
        assert_eq!(table.unit("n", Some("rpm")).unwrap(), "rpm");
        assert!(table.unit("n", Some("rad/s")).is_err());
        assert!(table.unit("M", None).is_err());
    }

    #[test]
    fn what_is_no_number_is_asked_for_with_its_line() {
        let table = read(b"t [s];T [degC];state\n0;20,5;on\n1;-;on\n2;-9999;off\n3;;off\n4;nan;off\n").unwrap();
        let error = table.values("T", &[]).unwrap_err().to_string();
        assert!(error.contains("line 3: `-`") && error.contains("missing = "), "{error}");
        let (values, missing) = table.values("T", &["-".to_owned(), "-9999".to_owned()]).unwrap();
        assert_eq!((values[0], missing, table.column("T").unwrap().empty), (20.5, 2, 2));
        assert!(values[1..].iter().all(|value| value.is_nan()));
    }

    #[test]
    fn anything_else_is_for_convert() {
        let preamble = b"Tester;Meier\n\nt;T\n0;1\n".as_slice();
        for text in [preamble, b"T [\xb0C],t\n1,2\n", b"MDF     4.10", b"T;t\nx;y\n", b"\xff\xfea\0"] {
            let error = read(text).unwrap_err().to_string();
            assert!(error.contains("python -m fmu_orchestrator convert") && error.lines().count() == 1, "{error}");
        }
    }
}
