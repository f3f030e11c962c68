//! The settings file of `synchronise`: the columns of a recording and their treatment.

use std::path::Path;

use serde::Deserialize;

use crate::analysis::synchronise::smooth::Smoothing;
use crate::analysis::synchronise::{Accuracy, Channel, Derived, RigRecording};
use crate::study::Quantity;

use super::mistake::SettingsError;
use super::recorded::RecordedTable;

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
    unit: Option<String>,
    accuracy: Quantity,
    group: Option<String>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Speed {
    column: Option<String>,
    value: Option<f64>,
    unit: Option<String>,
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
        let table = RecordedTable::read(measured, &self.time.column)?;
        let wrong = |message: String| SettingsError::Content {
            path: own.to_owned(),
            message,
        };
        let time = self.times(&table, own)?;
        let rows = time.len();
        let signal = |signal: &Signal, name: &str, known: &[(&str, f64)], si: Option<&str>| {
            let unit = table.unit(&signal.column, signal.unit.as_deref())?;
            let factor = if si.is_some() {
                scale(&unit, known).map_err(wrong)?
            } else {
                1.0
            };
            let values = table.column(&signal.column)?.values.iter();
            Ok::<_, SettingsError>(Channel {
                name: signal.name.clone().unwrap_or_else(|| name.to_owned()),
                variable: signal.variable.clone(),
                values: values.map(|v| v * factor).collect(),
                accuracy: accuracy(&signal.accuracy, &unit, factor).map_err(wrong)?,
                unit: si.map_or(unit, str::to_owned),
                group: signal.group.clone(),
            })
        };
        let own_unit = self.speed.unit.as_deref();
        let (unit, values) = match (&self.speed.column, self.speed.value) {
            (Some(name), None) => (
                table.unit(name, own_unit)?,
                table.column(name)?.values.clone(),
            ),
            (None, Some(value)) => {
                let missing = || wrong("[speed] needs the `unit` of its value".to_owned());
                (own_unit.ok_or_else(missing)?.to_owned(), vec![value; rows])
            }
            _ => return Err(wrong("[speed] needs either a column or a value".to_owned())),
        };
        let turns = scale(&unit, SPEED).map_err(wrong)?;
        let speed: Vec<f64> = values.into_iter().map(|v| v * turns).collect();
        let speed_accuracy = accuracy(&self.speed.accuracy, &unit, turns).map_err(wrong)?;
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
                accuracy: speed_accuracy,
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

    /// The times of the rows, s; time stamps count from the first one.
    fn times(&self, table: &RecordedTable, own: &Path) -> Result<Vec<f64>, SettingsError> {
        let name = &self.time.column;
        let column = table.column(name)?;
        if column.stamps {
            return Ok(column.values.clone());
        }
        let wanted = self.time.unit.as_deref();
        let unit = match (wanted, &column.unit) {
            (None, None) => "s".to_owned(),
            _ => table.unit(name, wanted)?,
        };
        let factor = scale(&unit, TIME).map_err(|message| SettingsError::Content {
            path: own.to_owned(),
            message,
        })?;
        Ok(column.values.iter().map(|t| t * factor).collect())
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
