//! The columns of recordings: their files, times and values.

use std::path::PathBuf;

use super::{Repeated, Settings, Signal, TimeColumn, conversion};
use fmu_import::{
    quantity::Quantity,
    units::{Conversion, known},
};
use number_tables::{
    clocks,
    files::{self, FileError, Result},
    recorded::RecordedTable,
};
use rig_signals::{Accuracy, Channel};

impl Settings {
    /// Reads the files.
    ///
    /// # Errors
    /// When one cannot be read, or its times are none.
    pub fn files(&self, measured: &[PathBuf]) -> Result<RecordedFiles<'_>> {
        if self.files.len() > measured.len() {
            let (known, given) = (self.files.len(), measured.len());
            return Err(self.wrong(format!(
                "files: {known} are described and {given} given; give them in this order on the command line"
            )));
        }
        let mut tables = Vec::new();
        for (place, path) in measured.iter().enumerate() {
            let time = self
                .files
                .get(place)
                .and_then(|file| file.time.as_ref())
                .or(self.time.as_ref())
                .cloned()
                .unwrap_or_default();
            tables.push((RecordedTable::read(path)?, time));
        }
        Ok(RecordedFiles { settings: self, tables })
    }
}

/// The files of a recording, read.
pub struct RecordedFiles<'a> {
    pub settings: &'a Settings,
    tables: Vec<(RecordedTable, TimeColumn)>,
}

impl RecordedFiles<'_> {
    /// What was left out of each file, for the reader.
    pub fn notes(&self) -> Vec<String> {
        let plain = self.settings.plain().filter_map(|(key, signal)| {
            let column = signal.column.as_deref()?;
            let unit = self.tables.iter().find_map(|(table, _)| table.get(column))?.unit.as_deref()?;
            Some(format!("{key}: the model has no unit, so the values are those in `{unit}`, as they are"))
        });
        let skipped = self.tables.iter().filter_map(|(table, _)| {
            let ((count, first), name) = (table.skipped?, files::name(table.path()));
            Some(format!(
                "{name}: {count} blank lines or comments between rows are no rows, line {first} first: if values are missing \
                 there, write nan"
            ))
        });
        (0..self.tables.len()).filter_map(|file| self.about_time(file)).chain(skipped).chain(plain).collect()
    }

    /// Which column the times of a file are, and their range.
    fn about_time(&self, file: usize) -> Option<String> {
        let (table, time) = &self.tables[file];
        if time.rate.is_some() {
            return None;
        }
        let name = self.time_name(file, None).ok()?;
        let times = self.times(file, &Signal::default()).ok()?;
        let known = || times.iter().copied().filter(|value| value.is_finite());
        // To the nanosecond: sums of decimals end otherwise.
        let [from, to] = [known().fold(f64::INFINITY, f64::min), known().fold(f64::NEG_INFINITY, f64::max)]
            .map(|time| (time * 1e9).round() / 1e9);
        let has_unit = time.unit.is_some() || table.get(name)?.unit.is_some();
        let unit = if has_unit { "" } else { ", which has no unit and is read as s" };
        Some(format!("{}: time: `{name}`{unit}, {from} .. {to} s", files::name(table.path())))
    }

    /// The name of the column of a file's times.
    fn time_name<'b>(&'b self, file: usize, signal: Option<&'b Signal>) -> Result<&'b str> {
        let (table, time) = &self.tables[file];
        let remedy = "say time = { column = \"...\" }, `time` under each signal, or time = { rate = \"... Hz\" }";
        signal
            .and_then(|signal| signal.time.as_deref())
            .or(time.column.as_deref())
            .map_or_else(|| table.time(&|_| true, remedy), Ok)
    }

    /// The times of a file's rows, s.
    fn times(&self, file: usize, signal: &Signal) -> Result<Vec<f64>> {
        let ((table, time), settings) = (&self.tables[file], self.settings);
        let start = time.offset.as_ref().map_or(Ok(0.0), |offset| settings.si("time: offset", offset, "s"))?;
        if let Some(rate) = &time.rate {
            let rate = settings.si("time: rate", rate, "Hz")?;
            return Ok((0..table.rows).map(|row| start + row as f64 / rate).collect());
        }
        let name = self.time_name(file, Some(signal))?;
        let (values, _) = table.values(name, &[])?;
        let unit = match (&time.unit, &table.column(name)?.unit) {
            (None, None) => {
                let units = "say time = { unit = \"ms\" }";
                let doubt = clocks::doubt(table.path(), name, &values, table.has_days(), units);
                doubt.map_or(Ok("s".to_owned()), |message| Err(settings.wrong(message)))?
            }
            (unit, _) => table.unit(name, unit.as_deref())?,
        };
        let way = conversion(&unit, "s").map_err(|message| settings.wrong(format!("time: {message}")))?;
        Ok(values.iter().map(|time| start + way.value(*time)).collect())
    }

    /// Which rows count where several have one time, and how many do not.
    ///
    /// # Errors
    /// When times fall, or come again and no one says which row counts.
    fn in_order(&self, file: usize, name: &str, rows: &mut Vec<(f64, f64)>) -> Result<usize> {
        let (table, time) = &self.tables[file];
        let wrong = |message| FileError::new(table.path(), format!("time `{name}`: {message}"));
        if let Some(pair) = rows.windows(2).find(|pair| pair[1].0 < pair[0].0) {
            return Err(wrong(format!(
                "the clock jumps back from {} s to {} s: cut the file there",
                pair[0].0, pair[1].0
            )));
        }
        let all = rows.len();
        let again = || rows.windows(2).filter(|pair| pair[1].0 == pair[0].0);
        let (count, first) = (again().count(), again().next().map(|pair| pair[0].0));
        match (first, time.repeated) {
            (None, _) => {}
            (Some(first), None) => {
                return Err(wrong(format!(
                    "{count} of {all} rows have the time of the row before, first {first} s; say time = {{ repeated = \"first\" }} \
                     or \"last\" for the row that counts; where the times are coarser than the rows, time = {{ rate = \"... Hz\" }}"
                )));
            }
            (Some(_), Some(Repeated::First)) => rows.dedup_by(|next, kept| next.0 == kept.0),
            (Some(_), Some(Repeated::Last)) => {
                rows.reverse();
                rows.dedup_by(|next, kept| next.0 == kept.0);
                rows.reverse();
            }
        }
        Ok(all - rows.len())
    }

    /// A channel in its own unit, or in `si`.
    pub fn channel(&self, key: &str, signal: &Signal, name: &str, si: Option<&str>) -> Result<Channel> {
        let settings = self.settings;
        let wrong = |message| settings.wrong(format!("{key}: {message}"));
        let column = settings.needed(&signal.column, key, "column")?;
        let file = self.file_of(key, signal, column)?;
        let table = &self.tables[file].0;
        let unit = table.unit(column, signal.unit.as_deref().filter(|_| signal.scale.is_none()));
        // Of volts the settings say what they mean.
        let unit = match (&signal.scale, &signal.unit) {
            (Some(_), Some(unit)) => known::usual(unit).unwrap_or(unit).to_owned(),
            _ if signal.is_plain() => "1".to_owned(),
            _ => unit?,
        };
        let way = match si {
            Some(si) => conversion(&unit, si).map_err(wrong)?,
            None => Conversion::IDENTITY,
        };
        let offset = match &signal.offset {
            Some(Quantity { number, unit: Some(own) }) => {
                conversion(own, &unit).map_err(|message| wrong(format!("offset: {message}")))?.difference(*number)
            }
            plain => plain.as_ref().map_or(0.0, |offset| offset.number),
        };
        let scaled = Conversion { factor: signal.scale.unwrap_or(1.0), offset };
        let to_unit = scaled.then(way);
        let marks = signal.missing.iter().map(|mark| mark.as_str().map_or_else(|| mark.to_string(), str::to_owned));
        let (cells, missing) = table.values(column, &marks.collect::<Vec<_>>())?;
        let mut rows: Vec<(f64, f64)> = self
            .times(file, signal)?
            .iter()
            .zip(&cells)
            .filter(|(time, value)| time.is_finite() && value.is_finite())
            .map(|(time, value)| (*time, to_unit.value(*value)))
            .collect();
        let empty = table.column(column)?.empty;
        let timeless = table.rows - rows.len() - empty - missing;
        let (time_column, repeated) = match self.tables[file].1.rate {
            Some(_) => (table.width(), 0),
            None => {
                let name = self.time_name(file, Some(signal))?;
                (table.place(name), self.in_order(file, name, &mut rows)?)
            }
        };
        let (time, values) = rows.into_iter().unzip();
        let zero = Quantity::from(0.0);
        let accuracy = accuracy(signal.accuracy.as_ref().unwrap_or(&zero), &unit, way.factor).map_err(wrong)?;
        Ok(Channel {
            name: signal.name.clone().unwrap_or_else(|| name.to_owned()),
            variable: signal.variable.clone().unwrap_or_default(),
            unit: si.map_or(unit, str::to_owned),
            clock: self.tables[..file].iter().map(|(table, _)| table.width() + 1).sum::<usize>() + time_column,
            lost: vec![
                (empty, "empty"),
                (missing, "missing"),
                (timeless, "without a time"),
                (repeated, "with the time of another row"),
            ],
            drop: signal.dropped(),
            time,
            values,
            accuracy,
            group: signal.group.clone(),
        })
    }

    /// The file that has a signal's column.
    fn file_of(&self, key: &str, signal: &Signal, column: &str) -> Result<usize> {
        let settings = self.settings;
        if let Some(file) = signal.file {
            return file.checked_sub(1).filter(|place| *place < self.tables.len()).ok_or_else(|| {
                settings.wrong(format!("{key}: there is no file {file}; {} were given", self.tables.len()))
            });
        }
        let having: Vec<usize> =
            (0..self.tables.len()).filter(|file| self.tables[*file].0.get(column).is_some()).collect();
        match having.as_slice() {
            [file] => Ok(*file),
            [] => {
                let tables: Vec<_> = self.tables.iter().map(|(table, _)| table).collect();
                Err(RecordedTable::none_has(&tables, column))
            }
            _ => Err(settings
                .wrong(format!("{key}: several files have a column `{column}`; add `file`, which counts from 1"))),
        }
    }
}

/// The limit of a zero error; none where the accuracy is a part of the value.
pub fn of_zero(quantity: &Quantity, unit: &str) -> Result<Option<f64>, String> {
    Ok(match accuracy(quantity, unit, 1.0)? {
        Accuracy::Absolute(limit) => Some(limit),
        Accuracy::Relative(_) => None,
    })
}

pub fn accuracy(quantity: &Quantity, unit: &str, factor: f64) -> Result<Accuracy, String> {
    match quantity.unit.as_deref() {
        _ if quantity.number < 0.0 || !quantity.number.is_finite() => {
            Err(format!("the accuracy `{quantity}` must not be negative"))
        }
        Some("%") if unit == "%" => Err(format!(
            "the accuracy `{quantity}` may be {0} points or a part of the value; write {0} without a unit for the points, or give the \
             signal in unit `1` with `scale = 0.01` for a part",
            quantity.number
        )),
        Some("%") => Ok(Accuracy::Relative(quantity.number / 100.0)),
        // Where the model has no unit, the recording's is not converted.
        Some(given) if given != unit && unit != "1" => {
            let way = known::between(given, unit)
                .ok_or_else(|| format!("the accuracy `{quantity}` must be in {unit} or %, not in {given}"))?;
            Ok(Accuracy::Absolute(way.difference(quantity.number) * factor))
        }
        _ => Ok(Accuracy::Absolute(quantity.number * factor)),
    }
}
