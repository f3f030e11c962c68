//! The settings file of `synchronise`: the columns of a recording and their treatment.

use std::path::{Path, PathBuf};

use serde::Deserialize;
use thiserror::Error;

use crate::analysis::synchronise::signal::SignalError;
use crate::analysis::synchronise::smooth::Smoothing;
use crate::analysis::synchronise::{Accuracy, Channel, Derived, RigRecording};
use crate::names::{did_you_mean, nearest};
use crate::study::Quantity;
use crate::table::csv_file::{self, CsvFile, reason};

/// Why a recording cannot be used.
#[derive(Debug, Error)]
pub enum SettingsError {
    /// A file cannot be read.
    #[error("{path}: {}", crate::files::reason(path, .source))]
    Io {
        /// The file.
        path: PathBuf,
        /// The operating system's message.
        source: std::io::Error,
    },
    /// The settings are no TOML, or not these settings.
    #[error("{path}: {message}")]
    Toml {
        /// The file.
        path: PathBuf,
        /// The problem, with line and column.
        message: String,
    },
    /// The recording is no table.
    #[error("{path}: {}", reason(path, .source))]
    Csv {
        /// The file.
        path: PathBuf,
        /// The problem.
        source: csv::Error,
    },
    /// A column, a unit or a number does not fit.
    #[error("{path}: {message}")]
    Content {
        /// The file.
        path: PathBuf,
        /// The problem.
        message: String,
    },
    /// The signals cannot be used.
    #[error("{path}: {source}")]
    Signal {
        /// The recording.
        path: PathBuf,
        /// The problem.
        source: SignalError,
    },
}

/// The settings of a recording.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub(super) struct Settings {
    /// The column of the time.
    time: TimeColumn,
    /// The load on the bearing.
    load: Signal,
    /// The friction torque.
    torque: Signal,
    /// The shaft's speed: a column or a number.
    speed: Speed,
    /// The friction power, torque times speed, where that becomes a criterion.
    power: Option<Power>,
    /// Diameter of the bearing.
    diameter: Quantity,
    /// Further signals by the criteria's names.
    #[serde(default)]
    signals: indexmap::IndexMap<String, Signal>,
    /// The part of the record to use, s.
    window: Option<[f64; 2]>,
    /// Smoothing of load and torque.
    #[serde(default = "usual_smoothing")]
    smoothing: Smoothing,
    /// The longest delay to look for.
    longest_delay: Option<Quantity>,
    /// Confidence of the tests of stationarity.
    confidence: Option<f64>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct TimeColumn {
    column: String,
    unit: Option<String>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Signal {
    column: String,
    name: Option<String>,
    variable: String,
    unit: String,
    accuracy: Quantity,
    group: Option<String>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Speed {
    column: Option<String>,
    value: Option<f64>,
    unit: String,
    accuracy: Quantity,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Power {
    name: Option<String>,
    variable: String,
    group: Option<String>,
}

/// Passes the turn's tenth harmonic at 300 rpm.
fn usual_smoothing() -> Smoothing {
    Smoothing::Butterworth {
        cutoff: 50.0,
        order: 4,
    }
}

impl Settings {
    pub(super) fn read(path: &Path) -> Result<Self, SettingsError> {
        let text = std::fs::read_to_string(path).map_err(|source| SettingsError::Io {
            path: path.to_owned(),
            source,
        })?;
        toml::from_str(&text).map_err(|error| {
            let line = error
                .span()
                .map_or(1, |span| text[..span.start].matches('\n').count() + 1);
            SettingsError::Toml {
                path: path.to_owned(),
                message: format!("line {line}: {}", error.message()),
            }
        })
    }

    /// Reads the recording's columns in SI units.
    pub(super) fn recording(
        &self,
        own: &Path,
        measured: &Path,
    ) -> Result<RigRecording, SettingsError> {
        let table = RecordedTable::read(measured)?;
        let wrong = |message: String| SettingsError::Content {
            path: own.to_owned(),
            message,
        };
        let column = |name: &str| table.column(name);
        let time_scale = scale(self.time.unit.as_deref().unwrap_or("s"), TIME).map_err(wrong)?;
        let time: Vec<f64> = column(&self.time.column)?
            .iter()
            .map(|t| t * time_scale)
            .collect();
        let rows = time.len();
        let signal = |signal: &Signal, name: &str, known: &[(&str, f64)], si: Option<&str>| {
            let factor = if si.is_some() {
                scale(&signal.unit, known).map_err(wrong)?
            } else {
                1.0
            };
            Ok::<_, SettingsError>(Channel {
                name: signal.name.clone().unwrap_or_else(|| name.to_owned()),
                variable: signal.variable.clone(),
                unit: si.map_or_else(|| signal.unit.clone(), str::to_owned),
                values: column(&signal.column)?.iter().map(|v| v * factor).collect(),
                accuracy: accuracy(&signal.accuracy, &signal.unit, factor).map_err(wrong)?,
                group: signal.group.clone(),
            })
        };
        let turns = scale(&self.speed.unit, SPEED).map_err(wrong)?;
        let speed = match (&self.speed.column, self.speed.value) {
            (Some(name), None) => column(name)?.iter().map(|v| v * turns).collect(),
            (None, Some(value)) => vec![value * turns; rows],
            _ => return Err(wrong("[speed] needs either a column or a value".to_owned())),
        };
        let others = self
            .signals
            .iter()
            .map(|(name, s)| signal(s, name, &[], None));
        let quantity = |q: &Quantity, known, usual: &str| {
            let unit = q.unit.as_deref().unwrap_or(usual);
            scale(unit, known)
                .map(|factor| q.number * factor)
                .map_err(wrong)
        };
        Ok(RigRecording {
            load: signal(&self.load, "F_N", FORCE, Some("N"))?,
            torque: signal(&self.torque, "M", TORQUE, Some("N.m"))?,
            speed: Channel {
                name: "speed".to_owned(),
                variable: String::new(),
                unit: "rad/s".to_owned(),
                values: speed,
                accuracy: accuracy(&self.speed.accuracy, &self.speed.unit, turns).map_err(wrong)?,
                group: None,
            },
            power: self.power.as_ref().map(|power| Derived {
                name: power.name.clone().unwrap_or_else(|| "P_fr".to_owned()),
                variable: power.variable.clone(),
                group: power.group.clone(),
            }),
            others: others.collect::<Result<_, _>>()?,
            diameter: quantity(&self.diameter, LENGTH, "m")?,
            window: self.window,
            smoothing: self.smoothing,
            longest_delay: match &self.longest_delay {
                Some(delay) => quantity(delay, TIME, "s")?,
                None => 0.05,
            },
            confidence: self.confidence.unwrap_or(0.99),
            time,
        })
    }
}

const TIME: &[(&str, f64)] = &[("s", 1.0), ("ms", 1e-3), ("us", 1e-6), ("min", 60.0)];
const FORCE: &[(&str, f64)] = &[("N", 1.0), ("kN", 1e3)];
const TORQUE: &[(&str, f64)] = &[
    ("N.m", 1.0),
    ("Nm", 1.0),
    ("N.mm", 1e-3),
    ("mN.m", 1e-3),
    ("N.cm", 1e-2),
];
const LENGTH: &[(&str, f64)] = &[("m", 1.0), ("mm", 1e-3), ("cm", 1e-2)];
const SPEED: &[(&str, f64)] = &[
    ("rad/s", 1.0),
    ("rpm", std::f64::consts::TAU / 60.0),
    ("1/min", std::f64::consts::TAU / 60.0),
    ("1/s", std::f64::consts::TAU),
];

/// The factor from a unit to SI.
fn scale(unit: &str, known: &[(&str, f64)]) -> Result<f64, String> {
    let found = known.iter().find(|(name, _)| *name == unit);
    found.map(|(_, factor)| *factor).ok_or_else(|| {
        let names: Vec<&str> = known.iter().map(|(name, _)| *name).collect();
        format!("unit `{unit}` does not fit; use {}", names.join(", "))
    })
}

fn accuracy(quantity: &Quantity, unit: &str, factor: f64) -> Result<Accuracy, String> {
    match quantity.unit.as_deref() {
        _ if quantity.number < 0.0 || !quantity.number.is_finite() => {
            Err(format!("the accuracy `{quantity}` must not be negative"))
        }
        Some("%") => Ok(Accuracy::Relative(quantity.number / 100.0)),
        None => Ok(Accuracy::Absolute(quantity.number * factor)),
        Some(own) if own == unit => Ok(Accuracy::Absolute(quantity.number * factor)),
        Some(own) => Err(format!(
            "the accuracy `{quantity}` must be in {unit} or %, not in {own}"
        )),
    }
}

/// A recording's columns by name.
struct RecordedTable {
    path: PathBuf,
    columns: Vec<(String, Vec<f64>)>,
}

impl RecordedTable {
    fn read(path: &Path) -> Result<Self, SettingsError> {
        let failed = |source| SettingsError::Csv {
            path: path.to_owned(),
            source,
        };
        let mut file = CsvFile::open(path, None).map_err(failed)?;
        let header = file.reader.headers().map_err(failed)?.clone();
        let mut columns: Vec<(String, Vec<f64>)> = header
            .iter()
            .map(|name| name.trim_start_matches('\u{feff}'))
            .map(|name| (csv_file::text(name).to_owned(), Vec::new()))
            .collect();
        let mut record = csv::StringRecord::new();
        while file.reader.read_record(&mut record).map_err(failed)? {
            for ((_, column), cell) in columns.iter_mut().zip(&record) {
                // An empty or unreadable cell is a sample that is missing.
                column.push(file.number(cell).unwrap_or(f64::NAN));
            }
        }
        Ok(Self {
            path: path.to_owned(),
            columns,
        })
    }

    fn column(&self, name: &str) -> Result<&[f64], SettingsError> {
        let found = self.columns.iter().find(|(known, _)| known == name);
        found.map(|(_, values)| values.as_slice()).ok_or_else(|| {
            let names = self.columns.iter().map(|(known, _)| known.as_str());
            SettingsError::Content {
                path: self.path.clone(),
                message: format!(
                    "there is no column `{name}`{}",
                    did_you_mean(nearest(name, names))
                ),
            }
        })
    }
}
