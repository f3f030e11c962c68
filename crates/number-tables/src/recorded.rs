//! A recording as a table: its columns, the units in a row below the header, and times as numbers or time stamps.

use std::path::{Path, PathBuf};

use crate::files::FileError;
use crate::formats::open;
use crate::rows::How;
use chrono::{DateTime, NaiveDateTime};
use fmu_points::names::{did_you_mean, nearest};

/// A recording's columns by name.
#[derive(Debug)]
pub struct RecordedTable {
    path: PathBuf,
    columns: Vec<Column>,
}

/// A column.
#[derive(Debug)]
pub struct Column {
    name: String,
    /// The unit in the row below the header.
    pub unit: Option<String>,
    /// The numbers; of a column of time stamps the seconds since the first one.
    pub values: Vec<f64>,
    /// Whether they were time stamps.
    pub stamps: bool,
}

/// A time stamp.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Stamp {
    nanoseconds: i64,
    has_zone: bool,
}

/// A time stamp after ISO 8601, with or without a zone and parts of a second.
fn stamp(cell: &str) -> Option<Stamp> {
    let iso = cell.replacen(' ', "T", 1).replace(',', ".");
    let zoned = ["%Y-%m-%dT%H:%M:%S%.f%#z", "%Y%m%dT%H%M%S%.f%#z"];
    let plain = ["%Y-%m-%dT%H:%M:%S%.f", "%Y%m%dT%H%M%S%.f"];
    let utc = iso
        .strip_suffix(['Z', 'z'])
        .map(|iso| format!("{iso}+00:00"));
    let with_zone = utc.as_ref().unwrap_or(&iso);
    let zoned = zoned
        .iter()
        .find_map(|form| DateTime::parse_from_str(with_zone, form).ok());
    let plain = || {
        plain
            .iter()
            .find_map(|form| NaiveDateTime::parse_from_str(&iso, form).ok())
    };
    let nanoseconds = match &zoned {
        Some(time) => time.timestamp_nanos_opt(),
        None => plain()?.and_utc().timestamp_nanos_opt(),
    };
    Some(Stamp {
        nanoseconds: nanoseconds?,
        has_zone: zoned.is_some(),
    })
}

/// A unit without brackets around it, by its usual letters.
fn unit(cell: &str) -> String {
    let bare = cell.trim_matches(|c: char| "[]()".contains(c) || c.is_whitespace());
    bare.replace('°', "deg").replace(['·', '*'], ".")
}

impl RecordedTable {
    /// Reads a recording; `time` is the column that may hold time stamps.
    ///
    /// # Errors
    /// When it cannot be read, and with the line of a time that is none.
    pub fn read(path: &Path, time: &str) -> Result<Self, FileError> {
        let mut rows = open(path, How::default())?;
        let column = |name: &String| Column {
            name: name.trim_start_matches('\u{feff}').to_owned(),
            unit: None,
            values: Vec::new(),
            stamps: false,
        };
        let mut columns: Vec<Column> = rows.names().iter().map(column).collect();
        let mut first: Option<Stamp> = None;
        let mut is_first = true;
        while rows.advance()? {
            let texts = || (0..columns.len()).map(|k| rows.text(k));
            let no_value = |k| rows.number(k).is_none() && stamp(&rows.text(k)).is_none();
            if std::mem::take(&mut is_first)
                && (0..columns.len()).all(no_value)
                && texts().any(|cell| !cell.is_empty())
            {
                for (k, column) in columns.iter_mut().enumerate() {
                    column.unit = Some(unit(&rows.text(k))).filter(|unit| !unit.is_empty());
                }
                continue;
            }
            for (k, column) in columns.iter_mut().enumerate() {
                let cell = rows.text(k);
                let mut value = rows.number(k);
                if value.is_none() && column.name == time && !cell.is_empty() {
                    let line = rows.line();
                    value = Some(seconds(&cell, &mut first).map_err(|message| {
                        let name = &column.name;
                        FileError::new(path, format!("line {line}, column `{name}`: {message}"))
                    })?);
                    column.stamps = true;
                }
                // An empty or unreadable cell is a sample that is missing.
                column.values.push(value.unwrap_or(f64::NAN));
            }
        }
        Ok(Self {
            path: path.to_owned(),
            columns,
        })
    }

    /// A column by its name.
    ///
    /// # Errors
    /// When there is none.
    pub fn column(&self, name: &str) -> Result<&Column, FileError> {
        let column = self.columns.iter().find(|column| column.name == name);
        column.ok_or_else(|| {
            let names = self.columns.iter().map(|column| column.name.as_str());
            let suggestion = did_you_mean(nearest(name, names));
            self.wrong(format!("there is no column `{name}`{suggestion}"))
        })
    }

    fn wrong(&self, message: String) -> FileError {
        FileError::new(&self.path, message)
    }

    /// The unit of a column: that of the settings, which the row of units must not contradict, or that row's.
    ///
    /// # Errors
    /// When the two contradict each other, and when there is none.
    pub fn unit(&self, name: &str, wanted: Option<&str>) -> Result<String, FileError> {
        let known = self.column(name)?.unit.as_deref();
        match (wanted, known) {
            (Some(wanted), Some(known)) if unit(wanted).replace('.', "") != known.replace('.', "") => {
                Err(self.wrong(format!(
                    "line 2: column `{name}` is in `{known}`, and the settings say `{wanted}`; correct one of them"
                )))
            }
            (Some(unit), _) | (None, Some(unit)) => Ok(unit.to_owned()),
            (None, None) => Err(self.wrong(format!(
                "column `{name}` has no unit; add `unit` to it in the settings or a row of units below the header"
            ))),
        }
    }
}

/// Seconds since the first time stamp of a column.
fn seconds(cell: &str, first: &mut Option<Stamp>) -> Result<f64, String> {
    let stamp = stamp(cell).ok_or_else(|| {
        format!("`{cell}` is neither a number nor a time such as 2026-11-22T13:15:07.250+01:00; correct the cell")
    })?;
    let first = first.get_or_insert(stamp);
    if first.has_zone != stamp.has_zone {
        return Err(format!(
            "some times have a zone and others, as `{cell}`, have none; write it to all or to none"
        ));
    }
    // The difference is exact; a recording is shorter than the 104 days up to which nanoseconds are.
    Ok((stamp.nanoseconds - first.nanoseconds) as f64 * 1e-9)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn time_stamps_are_understood() {
        let at = |cell: &str| stamp(cell).unwrap_or_else(|| panic!("{cell}"));
        let noon = at("2026-11-22T12:00:00Z");
        assert!(noon.has_zone);
        for same in [
            "2026-11-22T13:00:00+01:00",
            "2026-11-22 07:30:00-0430",
            "2026-11-22T13:00:00.000+01",
            "20261122T120000Z",
        ] {
            assert_eq!(at(same), noon, "{same}");
        }
        let later = at("2026-11-22T12:00:00,250000001Z");
        assert_eq!(later.nanoseconds - noon.nanoseconds, 250_000_001);
        assert!(!at("2026-11-22T12:00:00.25").has_zone);
        for none in [
            "",
            "12:00:00",
            "2026-11-22",
            "2026-13-01T00:00:00Z",
            "s",
            "1.5",
        ] {
            assert_eq!(stamp(none), None, "{none}");
        }
    }

    fn table(text: &str) -> (tempfile::TempDir, Result<RecordedTable, FileError>) {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("m.csv");
        std::fs::write(&path, text).unwrap();
        let table = RecordedTable::read(&path, "t");
        (folder, table)
    }

    #[test]
    fn units_and_time_stamps_of_a_table() {
        let text = "t;F;M\n[s];[kN];(Nm)\n2026-11-22T12:00:59,5Z;0,75;0,4\n2026-11-22T13:01:00.502+01:00;0,8;\n";
        let table = table(text).1.unwrap();
        let time = table.column("t").unwrap();
        assert!(time.stamps);
        assert_eq!(time.values.len(), 2);
        assert!(time.values[0] == 0.0 && (time.values[1] - 1.002).abs() < 1e-12);
        assert_eq!(table.column("F").unwrap().values, [0.75, 0.8]);
        assert!(table.column("M").unwrap().values[1].is_nan());
        assert_eq!(table.unit("F", None).unwrap(), "kN");
        assert_eq!(table.unit("M", Some("N.m")).unwrap(), "N.m");
        let error = table.unit("F", Some("N")).unwrap_err().to_string();
        assert!(
            error.contains("m.csv: line 2: column `F` is in `kN`"),
            "{error}"
        );
    }

    #[test]
    fn a_table_without_units_and_times_that_are_none() {
        let plain = table("t,F\n0,1\n1,2\n").1.unwrap();
        assert_eq!(plain.column("t").unwrap().values, [0.0, 1.0]);
        let error = plain.unit("F", None).unwrap_err().to_string();
        assert!(error.contains("`F` has no unit; add `unit`"), "{error}");
        for (text, expected) in [
            (
                "t,F\n0,1\nsoon,2\n",
                "line 3, column `t`: `soon` is neither",
            ),
            (
                "t,F\n2026-11-22T12:00:00Z,1\n2026-11-22T12:00:01,2\n",
                "line 3, column `t`: some times have a zone",
            ),
        ] {
            let error = table(text).1.err().unwrap().to_string();
            assert!(error.contains(expected), "{error}");
        }
    }
}
