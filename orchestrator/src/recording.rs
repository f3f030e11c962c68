//! The settings file of `synchronise`: the columns of recordings and their treatment.

use std::{
    ops::Range,
    path::{Path, PathBuf},
};

use serde::{Deserialize, Deserializer};
use toml::Spanned;

use fmu_import::{
    quantity::Quantity,
    units::{Conversion, known},
};
use fmu_points::names::behind;
use number_tables::{
    clocks,
    files::{self, FileError, Result},
    recorded::RecordedTable,
};
use result_document::format::number;
use rig_signals::{
    Accuracy, Bearing, Channel, Drop, RigRecording, Synchronised,
    case::{Drive, Driven},
    smooth::Smoothing,
};
use study::exactly_two;

/// The settings of a recording.
#[derive(Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct Settings {
    /// The file.
    #[serde(skip)]
    path: PathBuf,
    /// The time of each file that has none of its own.
    time: Option<TimeColumn>,
    /// The files, in the order of the command line.
    #[serde(default)]
    files: Vec<FileLayout>,
    /// The load on the bearing.
    load: Option<Signal>,
    /// The friction torque.
    torque: Option<Signal>,
    /// The shaft's speed: a column or a number.
    speed: Option<Signal>,
    /// Diameter of the bearing.
    diameter: Option<Quantity>,
    /// Further signals by the criteria's names.
    #[serde(default)]
    signals: indexmap::IndexMap<String, Signal>,
    /// Further columns that drive the model in a case, by the FMU's variables.
    #[serde(default)]
    inputs: indexmap::IndexMap<String, Signal>,
    /// The part of the record to use, s.
    #[serde(default, deserialize_with = "window")]
    window: Option<[f64; 2]>,
    /// When the model starts.
    start: Option<Spanned<Quantity>>,
    /// The line of `start`.
    #[serde(skip)]
    start_line: usize,
    /// Smoothing of load and torque.
    #[serde(default = "usual_smoothing")]
    smoothing: Smoothing,
    /// The longest delay to look for.
    longest_delay: Option<Quantity>,
    /// By how much the torque lags behind the load in the rig itself, for a case: the model has this lag, too.
    lag: Option<Quantity>,
    /// Confidence of the tests of stationarity.
    confidence: Option<f64>,
}

fn window<'de, D: Deserializer<'de>>(text: D) -> Result<Option<[f64; 2]>, D::Error> {
    exactly_two(text).map(Some)
}

/// The time of a file.
#[derive(Clone, Default, Deserialize)]
#[serde(deny_unknown_fields)]
struct TimeColumn {
    /// Where it is not named, the one that has a unit of time, or is called time, and rises.
    column: Option<String>,
    /// Of the rows, where there is no such column.
    rate: Option<Quantity>,
    unit: Option<String>,
    /// When the file's clock starts.
    offset: Option<Quantity>,
    /// Which of several rows with one time counts.
    repeated: Option<Repeated>,
}

/// Which of several rows with one time counts.
#[derive(Clone, Copy, Deserialize)]
#[serde(rename_all = "kebab-case")]
enum Repeated {
    First,
    Last,
}

/// Samples that may be none of the signal.
#[derive(PartialEq, Deserialize)]
#[serde(rename_all = "kebab-case")]
enum Doubtful {
    Clipped,
    Spikes,
}

/// How a file is written.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct FileLayout {
    time: Option<TimeColumn>,
}

/// A column of a file and its use.
#[derive(Default, Deserialize)]
#[serde(deny_unknown_fields)]
struct Signal {
    column: Option<String>,
    /// A number instead of a column.
    value: Option<f64>,
    /// The file, counted from 1; without it, the one that has the column.
    file: Option<usize>,
    /// The column of its times, where a file has several.
    time: Option<String>,
    /// The value in `unit` is the scale times the cell, plus the offset.
    scale: Option<f64>,
    offset: Option<Quantity>,
    #[serde(default, deserialize_with = "unit")]
    unit: Option<String>,
    /// Of its sensor.
    accuracy: Option<Quantity>,
    name: Option<String>,
    variable: Option<String>,
    /// How far the model may be from the true curve, in a case; of an input, how far its line may be from the samples.
    tolerance: Option<Quantity>,
    group: Option<String>,
    /// Cells that say that nothing was measured.
    #[serde(default)]
    missing: Vec<toml::Value>,
    /// Doubtful samples that do not count; an empty list says that all are right.
    drop: Option<Vec<Doubtful>>,
}

impl Signal {
    /// Which doubtful samples do not count.
    fn dropped(&self) -> Drop {
        let has = |what| self.drop.as_ref().is_some_and(|drop| drop.contains(&what));
        Drop { is_stated: self.drop.is_some(), spikes: has(Doubtful::Spikes), clipped: has(Doubtful::Clipped) }
    }

    /// Whether the model has it without a unit: values, accuracy and tolerance are taken as they are.
    fn is_plain(&self) -> bool {
        self.scale.is_none() && self.unit.as_deref() == Some("1")
    }
}

/// A unit. `none` is what people write for 1, which studies know alone.
fn unit<'de, D: Deserializer<'de>>(text: D) -> Result<Option<String>, D::Error> {
    let unit: Option<String> = Deserialize::deserialize(text)?;
    Ok(unit.map(|unit| match unit.as_str() {
        "none" => "1".to_owned(),
        _ => unit,
    }))
}

/// Passes the turn's tenth harmonic at 300 rpm.
fn usual_smoothing() -> Smoothing {
    Smoothing::Butterworth { cutoff: 50.0, order: 4 }
}

impl Settings {
    /// Reads the settings file.
    ///
    /// # Errors
    /// With file and line, when it cannot be read or says something else.
    pub fn read(path: &Path) -> Result<Self> {
        let text = files::text(path)?;
        let line = |span: Range<usize>| text[..span.start].matches('\n').count() + 1;
        let settings: Self = toml::from_str(&text).map_err(|error| {
            let line = error.span().map_or(1, line);
            FileError::new(path, format!("line {line}: {}", error.message()))
        })?;
        let start = settings.start.as_ref().map(Spanned::span);
        Ok(Self { path: path.to_owned(), start_line: start.map_or(1, line), ..settings })
    }

    fn wrong(&self, message: impl Into<String>) -> FileError {
        FileError::new(&self.path, message)
    }

    /// Reads the files.
    ///
    /// # Errors
    /// When one cannot be read, or its times are none.
    pub fn files(&self, measured: &[PathBuf]) -> Result<Recorded<'_>> {
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
        Ok(Recorded { settings: self, tables })
    }

    /// By how much the torque lags behind the load in the rig itself, s.
    ///
    /// # Errors
    /// When it has no unit of time.
    pub fn lag(&self) -> Result<f64> {
        match &self.lag {
            Some(lag) => self.si("lag", lag, "s"),
            None => Ok(0.0),
        }
    }

    /// Signals and inputs that the model has without a unit, by their keys.
    fn plain(&self) -> impl Iterator<Item = (String, &Signal)> {
        let signals = self.signals.iter().map(|(name, signal)| (format!("signals.{name}"), signal));
        let inputs = self.inputs.iter().map(|(name, input)| (format!("inputs.{name}"), input));
        signals.chain(inputs).filter(|(_, signal)| signal.is_plain())
    }

    /// How far the model may be off, by criteria's names.
    pub fn tolerances(&self) -> Vec<(String, String)> {
        let named = |signal: &Signal, name: &str| {
            let name = signal.name.clone().unwrap_or_else(|| name.to_owned());
            let tolerance = signal.tolerance.as_ref()?;
            let text = if signal.is_plain() && tolerance.unit.as_deref() != Some("%") {
                tolerance.number.to_string()
            } else {
                tolerance.to_string()
            };
            Some((name, text))
        };
        let both = [(&self.load, "F_N"), (&self.torque, "M")]
            .into_iter()
            .filter_map(|(signal, name)| named(signal.as_ref()?, name));
        let others = self.signals.iter().filter_map(|(name, signal)| named(signal, name));
        both.chain(others).collect()
    }

    /// Refuses what no case can be called, and tolerances that are no errors of a curve.
    pub fn check_case(&self, name: &str) -> Result {
        if name.is_empty() || name.contains('/') {
            return Err(self.wrong(format!("--case {name}: the name of a case must not be empty and has no `/`")));
        }
        match self.tolerances().iter().find(|(_, tolerance)| tolerance.ends_with('%')) {
            Some((signal, tolerance)) => Err(self.wrong(format!(
                "{signal}: the tolerance {tolerance} of a curve is not a part of anything; give it with a unit"
            ))),
            None => Ok(()),
        }
    }

    /// A quantity in an SI unit.
    fn si(&self, key: &str, quantity: &Quantity, si_unit: &str) -> Result<f64> {
        let unit = quantity.unit.as_deref().unwrap_or(si_unit);
        Ok(conversion(unit, si_unit).map_err(|message| self.wrong(format!("{key}: {message}")))?.value(quantity.number))
    }

    fn needed<'a, T>(&self, what: Option<&'a T>, of: &str, key: &str) -> Result<&'a T> {
        what.ok_or_else(|| self.wrong(format!("{of}: `{key}` is missing; add it")))
    }
}

/// The files of a recording, read.
pub struct Recorded<'a> {
    settings: &'a Settings,
    tables: Vec<(RecordedTable, TimeColumn)>,
}

impl Recorded<'_> {
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

    /// How far the noise of a row alone is beyond the tolerance of a curve.
    pub fn too_tight(&self, recorded: &RigRecording, result: &Synchronised) -> Vec<String> {
        let settings = self.settings;
        let both = [("F_N", &settings.load), ("M", &settings.torque)]
            .into_iter()
            .filter_map(|(name, signal)| Some((name, signal.as_ref()?)));
        let signals = settings.signals.iter().map(|(name, signal)| (name.as_str(), signal));
        both.chain(signals).filter_map(|(name, signal)| {
            let name = signal.name.as_deref().unwrap_or(name);
            let channel = recorded.signals().find(|channel| channel.name == name)?;
            let mut means = result.findings.iter().filter(|f| f.name == name);
            let row = means.next()?.noise?.row;
            let tolerance = of_zero(signal.tolerance.as_ref()?, &channel.unit).ok()??;
            (row > tolerance).then(|| format!(
                "{name}: the rows' noise alone ({}{unit}) is more than the tolerance ({tolerance}{unit}), so a right model \
                 fails; use a larger one, or the mean in criteria.toml",
                number(row, 3),
                unit = behind(Some(channel.unit.as_str()).filter(|unit| *unit != "1"))
            ))
        }).collect()
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

    /// When the model starts, s.
    fn start(&self) -> Result<Option<f64>> {
        let settings = self.settings;
        let key = format!("line {}: start", settings.start_line);
        settings.start.as_ref().map(|start| settings.si(&key, start.get_ref(), "s")).transpose()
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
    fn channel(&self, key: &str, signal: &Signal, name: &str, si: Option<&str>) -> Result<Channel> {
        let settings = self.settings;
        let wrong = |message| settings.wrong(format!("{key}: {message}"));
        let column = settings.needed(signal.column.as_ref(), key, "column")?;
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

    /// The signals that drive the model in a case: the speed, where its variable is named, and the further inputs.
    ///
    /// # Errors
    /// When there are none, or a column or a unit does not fit.
    pub fn drives(&self) -> Result<Vec<Drive>> {
        let settings = self.settings;
        let speed = settings.speed.iter().filter_map(|speed| Some(("speed", speed.variable.clone()?, speed)));
        let inputs = settings.inputs.iter().map(|(variable, input)| ("inputs", variable.clone(), input));
        let mut drives = Vec::new();
        for (key, variable, input) in speed.chain(inputs) {
            let key = format!("{key}: {variable}");
            let (unit, values) = match (input.value, &input.column) {
                (Some(value), None) => (input.unit.clone().unwrap_or_default(), Driven::Constant(value)),
                _ => {
                    let channel = self.channel(&key, input, &variable, None)?;
                    (channel.unit.clone(), Driven::Recorded(channel))
                }
            };
            let wrong = |message| settings.wrong(format!("{key}: {message}"));
            let tolerance = match (&values, &input.tolerance) {
                (Driven::Recorded(_), Some(stated)) => of_zero(stated, &unit).map_err(wrong)?,
                _ => None,
            };
            drives.push(Drive { tolerance, variable, unit, values });
        }
        Ok(drives)
    }

    /// The recording's signals; load, torque and speed in SI units.
    ///
    /// # Errors
    /// When something is missing, or a column or a unit does not fit.
    pub fn recording(&self) -> Result<RigRecording> {
        let settings = self.settings;
        let mut others = Vec::new();
        for (name, signal) in &settings.signals {
            let key = format!("signals.{name}");
            settings.needed(signal.variable.as_ref(), &key, "variable")?;
            settings.needed(signal.accuracy.as_ref(), &key, "accuracy")?;
            others.push(self.channel(&key, signal, name, None)?);
        }
        let bearing = match (&settings.load, &settings.torque) {
            (None, None) => None,
            (Some(load), Some(torque)) => Some(self.bearing(load, torque)?),
            _ => {
                return Err(settings.wrong("load and torque go together; a single one is one of the `signals`"));
            }
        };
        if bearing.is_none() && others.is_empty() {
            return Err(settings
                .wrong("no signal is named; add signals.NAME = { column = ..., variable = ..., accuracy = ... }"));
        }
        let start = self.start()?;
        let recording = RigRecording {
            bearing,
            others,
            window: settings.window,
            start,
            confidence: settings.confidence.unwrap_or(0.99),
        };
        let end = recording
            .signals()
            .filter_map(|signal| signal.time.last())
            .copied()
            .chain(settings.window.map(|[_, to]| to))
            .fold(f64::INFINITY, f64::min);
        match start.filter(|start| start.is_nan() || *start >= end) {
            Some(start) => Err(settings.wrong(format!(
                "line {}: start: {start} s is not before {} s, where a signal or the window ends; give an earlier time",
                settings.start_line,
                number(end, 6)
            ))),
            None => Ok(recording),
        }
    }

    fn bearing(&self, load: &Signal, torque: &Signal) -> Result<Bearing> {
        let settings = self.settings;
        let speed = settings.needed(settings.speed.as_ref(), "load and torque", "speed")?;
        for (key, signal) in [("load", load), ("torque", torque)] {
            settings.needed(signal.variable.as_ref(), key, "variable")?;
        }
        for (key, signal) in [("load", load), ("torque", torque), ("speed", speed)] {
            settings.needed(signal.accuracy.as_ref(), key, "accuracy")?;
        }
        let load = self.channel("load", load, "F_N", Some("N"))?;
        let speed = match (&speed.column, speed.value) {
            (Some(_), None) => self.channel("speed", speed, "speed", Some("rad/s"))?,
            (None, Some(value)) => {
                let unit = settings.needed(speed.unit.as_ref(), "speed", "unit")?;
                let wrong = |message| settings.wrong(format!("speed: {message}"));
                let way = conversion(unit, "rad/s").map_err(wrong)?;
                let limit = settings.needed(speed.accuracy.as_ref(), "speed", "accuracy")?;
                Channel {
                    name: "speed".to_owned(),
                    variable: speed.variable.clone().unwrap_or_default(),
                    unit: "rad/s".to_owned(),
                    values: vec![way.value(value); load.time.len()],
                    accuracy: accuracy(limit, unit, way.factor).map_err(wrong)?,
                    group: None,
                    lost: Vec::new(),
                    ..load.clone()
                }
            }
            _ => return Err(settings.wrong("speed: it needs either a column or a value")),
        };
        let diameter = settings.needed(settings.diameter.as_ref(), "load and torque", "diameter")?;
        Ok(Bearing {
            torque: self.channel("torque", torque, "M", Some("N.m"))?,
            load,
            speed,
            diameter: settings.si("diameter", diameter, "m")?,
            smoothing: settings.smoothing,
            longest_delay: match &settings.longest_delay {
                Some(delay) => settings.si("longest-delay", delay, "s")?,
                None => 0.05,
            },
        })
    }
}

/// The way from one unit to another one.
fn conversion(unit: &str, to: &str) -> Result<Conversion, String> {
    known::between(unit, to).ok_or_else(|| format!("unit `{unit}` does not fit; use {}", known::alike(to).join(", ")))
}

/// The limit of a zero error; none where the accuracy is a part of the value.
fn of_zero(quantity: &Quantity, unit: &str) -> Result<Option<f64>, String> {
    Ok(match accuracy(quantity, unit, 1.0)? {
        Accuracy::Absolute(limit) => Some(limit),
        Accuracy::Relative(_) => None,
    })
}

fn accuracy(quantity: &Quantity, unit: &str, factor: f64) -> Result<Accuracy, String> {
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
