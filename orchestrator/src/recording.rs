//! The settings file of `synchronise`: the columns of a recording and their treatment.

use std::path::{Path, PathBuf};

use serde::{Deserialize, Deserializer};

use crate::study::exactly_two;
use fmu_import::quantity::Quantity;
use number_tables::files::FileError;
use number_tables::recorded::RecordedTable;
use rig_signals::case::{Drive, Driven};
use rig_signals::smooth::Smoothing;
use rig_signals::{Accuracy, Channel, Derived, RigRecording};

/// The settings of a recording.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct Settings {
    /// The file.
    #[serde(skip)]
    path: PathBuf,
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
    /// Further columns that drive the model in a case, by the FMU's variables.
    #[serde(default)]
    inputs: indexmap::IndexMap<String, InputColumn>,
    /// The part of the record to use, s.
    #[serde(default, deserialize_with = "window")]
    window: Option<[f64; 2]>,
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
    /// How far the model may be from the true curve, in a case.
    tolerance: Option<Quantity>,
    group: Option<String>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct InputColumn {
    column: String,
    unit: Option<String>,
    /// Of its sensor.
    accuracy: Option<Quantity>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Speed {
    /// The FMU's variable that it drives in a case.
    variable: Option<String>,
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
    /// Reads the settings file.
    ///
    /// # Errors
    /// With file and line, when it cannot be read or says something else.
    pub fn read(path: &Path) -> Result<Self, FileError> {
        let text = number_tables::files::text(path)?;
        let settings = toml::from_str(&text).map_err(|error| {
            let line = error
                .span()
                .map_or(1, |span| text[..span.start].matches('\n').count() + 1);
            FileError::new(path, format!("line {line}: {}", error.message()))
        })?;
        Ok(Self {
            path: path.to_owned(),
            ..settings
        })
    }

    fn wrong(&self, message: impl Into<String>) -> FileError {
        FileError::new(&self.path, message)
    }

    /// The signals that drive the model in a case: the speed, where its variable is named, and the further inputs.
    pub fn drives(&self, measured: &Path) -> Result<Vec<Drive>, FileError> {
        let table = RecordedTable::read(measured, &self.time.column)?;
        let recorded =
            |variable: &String, column: &str, unit: Option<&str>, accuracy: Option<&Quantity>| {
                let unit = table.unit(column, unit)?;
                let accuracy = accuracy.map(|stated| of_zero(stated, &unit));
                let accuracy = accuracy
                    .transpose()
                    .map_err(|message| self.wrong(message))?;
                Ok::<_, FileError>(Drive {
                    variable: variable.clone(),
                    unit,
                    accuracy: accuracy.flatten(),
                    values: Driven::Recorded(table.column(column)?.values.clone()),
                })
            };
        let mut drives = Vec::new();
        let Speed {
            variable,
            column,
            value,
            unit,
            accuracy,
        } = &self.speed;
        match (variable, column, value) {
            (Some(variable), Some(column), _) => {
                drives.push(recorded(variable, column, unit.as_deref(), Some(accuracy))?);
            }
            (Some(variable), None, Some(value)) => drives.push(Drive {
                variable: variable.clone(),
                unit: unit.clone().unwrap_or_default(),
                accuracy: None,
                values: Driven::Constant(*value),
            }),
            _ => {}
        }
        for (variable, input) in &self.inputs {
            let InputColumn {
                column,
                unit,
                accuracy,
            } = input;
            drives.push(recorded(
                variable,
                column,
                unit.as_deref(),
                accuracy.as_ref(),
            )?);
        }
        if drives.is_empty() {
            let message = "nothing drives the model in a case: add the FMU's variable to the speed, speed = { variable = \
                           \"drive.speed\", ... }, or inputs.\"VARIABLE\" = { column = \"...\" }";
            return Err(self.wrong(message));
        }
        Ok(drives)
    }

    /// By how much the torque lags behind the load in the rig itself, s.
    pub fn lag(&self) -> Result<f64, FileError> {
        let Some(lag) = &self.lag else { return Ok(0.0) };
        let factor = scale(lag.unit.as_deref().unwrap_or("s"), TIME);
        let lag = factor.map(|factor| factor * lag.number);
        lag.map_err(|message| self.wrong(format!("lag: {message}")))
    }

    /// How far the model may be off, by criteria's names.
    pub fn tolerances(&self) -> Vec<(String, String)> {
        let named = |signal: &Signal, name: &str| {
            let name = signal.name.clone().unwrap_or_else(|| name.to_owned());
            Some((name, signal.tolerance.as_ref()?.to_string()))
        };
        let both = [named(&self.load, "F_N"), named(&self.torque, "M")];
        let others = self
            .signals
            .iter()
            .map(|(name, signal)| named(signal, name));
        both.into_iter().chain(others).flatten().collect()
    }

    /// Refuses what no case can be called, and tolerances that are no errors of a curve.
    pub fn check_case(&self, name: &str) -> Result<(), FileError> {
        if name.is_empty() || name.contains('/') {
            return Err(self.wrong(format!(
                "--case {name}: the name of a case must not be empty and has no `/`"
            )));
        }
        let tolerances = self.tolerances();
        match tolerances
            .iter()
            .find(|(_, tolerance)| tolerance.ends_with('%'))
        {
            Some((signal, tolerance)) => Err(self.wrong(format!(
                "{signal}: the tolerance {tolerance} of a curve is not a part of anything; give it with a unit"
            ))),
            None => Ok(()),
        }
    }

    /// Reads the recording's columns in SI units.
    pub fn recording(&self, measured: &Path) -> Result<RigRecording, FileError> {
        let table = RecordedTable::read(measured, &self.time.column)?;
        let wrong = |message: String| self.wrong(message);
        let time = self.times(&table)?;
        let rows = time.len();
        let signal = |signal: &Signal, name: &str, known: &[(&str, f64)], si: Option<&str>| {
            let unit = table.unit(&signal.column, signal.unit.as_deref())?;
            let factor = if si.is_some() {
                scale(&unit, known).map_err(wrong)?
            } else {
                1.0
            };
            let values = table.column(&signal.column)?.values.iter();
            Ok::<_, FileError>(Channel {
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
                variable: self.speed.variable.clone().unwrap_or_default(),
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
    fn times(&self, table: &RecordedTable) -> Result<Vec<f64>, FileError> {
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
        let factor = scale(&unit, TIME).map_err(|message| self.wrong(message))?;
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
    let entry = known.iter().find(|(name, _)| *name == unit);
    entry.map(|(_, factor)| *factor).ok_or_else(|| {
        let names: Vec<&str> = known.iter().map(|(name, _)| *name).collect();
        format!("unit `{unit}` does not fit; use {}", names.join(", "))
    })
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
        Some("%") => Ok(Accuracy::Relative(quantity.number / 100.0)),
        None => Ok(Accuracy::Absolute(quantity.number * factor)),
        Some(given) if given == unit => Ok(Accuracy::Absolute(quantity.number * factor)),
        Some(given) => Err(format!(
            "the accuracy `{quantity}` must be in {unit} or %, not in {given}"
        )),
    }
}
