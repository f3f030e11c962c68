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
use number_tables::files::{self, FileError, Result};
use rig_signals::{Drop, smooth::Smoothing};
use study::exactly_two;

pub mod columns;
mod rig;

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
pub struct Signal {
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

    fn needed<'a, T>(&self, what: &'a Option<T>, of: &str, key: &str) -> Result<&'a T> {
        what.as_ref().ok_or_else(|| self.wrong(format!("{of}: `{key}` is missing; add it")))
    }
}

/// The way from one unit to another one.
fn conversion(unit: &str, to: &str) -> Result<Conversion, String> {
    known::between(unit, to).ok_or_else(|| format!("unit `{unit}` does not fit; use {}", known::alike(to).join(", ")))
}
