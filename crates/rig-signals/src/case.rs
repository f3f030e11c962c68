//! A case of a study from a recording: what drove the rig as inputs, what was measured as curves with their uncertainty.

use std::fmt::Write as _;

use super::recording::{Accuracy, Channel, DerivedCriterion, RigRecording, Synchronised};
use super::uncertainty::from_bound;
use sampling::statistics::estimate::Estimate;

/// Settings by which a recording becomes a case.
#[derive(Clone, Debug)]
pub struct Frame<'a> {
    /// The case's name.
    pub name: &'a str,
    /// Whether it is judged and never fitted.
    pub held_out: bool,
    /// The file with the curves, as the study names it.
    pub file: &'a str,
    /// The signals that drove the rig.
    pub drives: &'a [Drive],
    /// How far the model may be off, by criteria's names, as the settings say it.
    pub tolerances: &'a [(String, String)],
    /// By how much the torque lags behind the load in the rig itself, and so in the model, s.
    pub lag: f64,
}

/// A variable of the FMU that is driven as it was recorded.
#[derive(Clone, Debug, PartialEq)]
pub struct Drive {
    /// The variable.
    pub variable: String,
    /// Its unit.
    pub unit: String,
    /// Its values.
    pub values: Driven,
}

/// The values of an input.
#[derive(Clone, Debug, PartialEq)]
pub enum Driven {
    /// One for the whole run.
    Constant(f64),
    /// One for each row of the recording.
    Recorded(Vec<f64>),
}

/// A measured curve.
struct Measured<'a> {
    channel: &'a Channel,
    values: Vec<f64>,
    /// By how much it is late.
    delay: Option<&'a Estimate>,
}

/// The rows of a recording in which all that the case needs was measured, without spikes.
pub struct Case<'a> {
    recording: &'a RigRecording,
    result: &'a Synchronised,
    /// The numbers of these rows.
    rows: Vec<usize>,
    curves: Vec<Measured<'a>>,
    /// The first time of the recording.
    begin: f64,
}

impl<'a> Case<'a> {
    /// The case of a synchronised recording.
    pub fn new(recording: &'a RigRecording, result: &'a Synchronised, drives: &[Drive]) -> Self {
        let curve = |channel: &'a Channel, delay| {
            let cleaned = super::clean::clean(&channel.values);
            let samples = cleaned.values.into_iter().zip(cleaned.clipped);
            // Of a sample at the end of the sensor's range nobody knows the true value.
            let value = |(value, clipped)| if clipped { f64::NAN } else { value };
            Measured {
                channel,
                values: samples.map(value).collect(),
                delay,
            }
        };
        let mut curves = vec![
            curve(&recording.load, None),
            curve(&recording.torque, result.delay.delay.as_ref()),
        ];
        curves.extend(recording.others.iter().map(|other| curve(other, None)));
        let is_whole = |&row: &usize| {
            let driven = drives.iter().all(|drive| match &drive.values {
                Driven::Constant(_) => true,
                Driven::Recorded(values) => values[row].is_finite(),
            });
            let measured = curves.iter().all(|curve| curve.values[row].is_finite());
            driven && measured && recording.time[row].is_finite()
        };
        let times = recording.time.iter().copied();
        Self {
            // Those before the window, too: what drove the rig then has brought it to where the window begins.
            rows: (0..recording.time.len()).filter(is_whole).collect(),
            begin: times.fold(f64::INFINITY, f64::min),
            recording,
            result,
            curves,
        }
    }

    /// Times in the case: they count from the first row of the recording.
    fn time(&self, row: usize) -> f64 {
        self.recording.time[row] - self.begin
    }

    /// The first and the last time.
    fn span(&self) -> [f64; 2] {
        let end = |row: Option<&usize>| row.map_or(0.0, |&row| self.time(row));
        [end(self.rows.first()), end(self.rows.last())]
    }

    /// The curves and the recorded inputs as csv.
    pub fn table(&self, drives: &[Drive]) -> String {
        let recorded = drives.iter().filter_map(|drive| match &drive.values {
            Driven::Recorded(values) => Some((drive.variable.as_str(), values)),
            Driven::Constant(_) => None,
        });
        let curves = self.curves.iter();
        let curves = curves.map(|curve| (curve.channel.name.as_str(), &curve.values));
        let columns: Vec<(&str, &Vec<f64>)> = recorded.chain(curves).collect();
        let names: Vec<String> = columns.iter().map(|(name, _)| cell(name)).collect();
        let mut text = format!("time,{}\n", names.join(","));
        for &row in &self.rows {
            let _ = write!(text, "{:.9}", self.time(row));
            for (_, values) in &columns {
                let _ = write!(text, ",{:.8e}", values[row]);
            }
            text.push('\n');
        }
        text
    }

    /// The case as TOML. The tolerances are the user's to add, where the settings have none: no recording knows how far the
    /// model may be off.
    pub fn to_toml(&self, frame: &Frame<'_>) -> String {
        let [first, last] = self.span();
        let left = self.recording.time.len() - self.rows.len();
        let mut out = format!(
            "# {} rows from {first:.6} s to {last:.6} s; times count from the first row of the recording.\n",
            self.rows.len()
        );
        if left > 0 {
            let _ = writeln!(
                out,
                "# {left} rows with a missing sample, a spike or a clipped sample were left out."
            );
        }
        for warning in &self.result.warnings {
            let _ = writeln!(out, "# Note: {warning}.");
        }
        let late = self.curves.iter().map(|curve| self.late(curve, frame));
        let early = late.map(|late| -late).fold(0.0, f64::max);
        // The model runs from the first row, whole or not, and on until the last curve that is ahead of it.
        let ends = match first > 0.0 || early > 0.0 {
            true => ", extrapolate = \"hold\"",
            false => "",
        };
        let _ = writeln!(out, "[[cases]]\nname = {}", quoted(frame.name));
        if frame.held_out {
            out.push_str("held-out = true\n");
        }
        let _ = writeln!(out, "simulation = {{ stop = {} }}", up(last + early));
        for drive in frame.drives {
            let (name, unit) = (quoted(&drive.variable), quoted(&drive.unit));
            let _ = match &drive.values {
                Driven::Constant(value) => {
                    let value = quoted(&format!("{value} {}", drive.unit));
                    writeln!(out, "fixed.{name} = {value}")
                }
                Driven::Recorded(_) => writeln!(
                    out,
                    "inputs.{name} = {{ file = {}, time = \"time\", column = {name}, unit = {unit}{ends} }}",
                    quoted(frame.file)
                ),
            };
        }
        for curve in &self.curves {
            out.push_str(&self.criterion(curve, frame));
        }
        out
    }

    /// By how much a curve is late, s.
    fn late(&self, curve: &Measured<'_>, frame: &Frame<'_>) -> f64 {
        let found = curve.delay.map_or(0.0, |delay| delay.value - frame.lag);
        // As it is written.
        (found * 1e7).round() / 1e7
    }

    fn criterion(&self, curve: &Measured<'_>, frame: &Frame<'_>) -> String {
        let channel = curve.channel;
        let name = quoted(&channel.name);
        let mut out = format!("\n[cases.criteria.{name}]\n");
        let is_mean = |c: &&DerivedCriterion| c.name == channel.name && c.statistic == "mean";
        if let Some(criterion) = self.result.findings.iter().find(is_mean)
            && let Some(s) = &criterion.stationarity
        {
            let _ = writeln!(
                out,
                "# {}: change over the window {:.2e} ({:.2e} to {:.2e}) {}",
                if s.steady() { "steady" } else { "drifting" },
                s.change.value,
                s.change.low,
                s.change.high,
                channel.unit
            );
        }
        let expanded = 2.0 * from_bound(1.0);
        let stated = |text: String| format!(", uncertainty = {}", quoted(&text));
        let uncertainty = match channel.accuracy {
            // Of a sensor without errors there is nothing to state.
            Accuracy::Absolute(0.0) | Accuracy::Relative(0.0) => String::new(),
            Accuracy::Absolute(bound) => {
                stated(format!("{:.4e} {}", bound * expanded, channel.unit))
            }
            Accuracy::Relative(part) => stated(format!("{:.4} %", 100.0 * part * expanded)),
        };
        let _ = writeln!(
            out,
            "variable = {}\nreference = {{ file = {}, time = \"time\", column = {name}, unit = {}{uncertainty} }}\n\
             metric = \"rmse\"",
            quoted(&channel.variable),
            quoted(frame.file),
            quoted(&channel.unit)
        );
        let [first, last] = self.span();
        let late = self.late(curve, frame);
        if let Some(found) = curve.delay {
            let _ = write!(
                out,
                "# late by {:.3} ms after the load ({:.3} to {:.3} ms, 95 %)",
                1e3 * found.value,
                1e3 * found.low,
                1e3 * found.high
            );
            let _ = match frame.lag {
                0.0 => writeln!(out, ", all of which is taken for the sensor's"),
                lag => writeln!(out, ", of which {:.3} ms are the rig's own", 1e3 * lag),
            };
            let _ = writeln!(out, "delay = \"{:.4} ms\"", 1e3 * late);
        }
        let [from, to] = self.recording.window();
        let from = (from - self.begin).max(first + late.max(0.0));
        let to = (to - self.begin).min(last);
        if from > first || to < last {
            let _ = writeln!(out, "window = {{ from = {}, to = {} }}", up(from), up(to));
        }
        let mut tolerances = frame.tolerances.iter();
        let _ = match tolerances.find(|(name, _)| *name == channel.name) {
            Some((_, tolerance)) => writeln!(out, "tolerance = {}", quoted(tolerance)),
            None => writeln!(
                out,
                "# tolerance = \"... {}\"   # how far the model may be from the true curve",
                channel.unit
            ),
        };
        let _ = writeln!(out, "unit = {}", quoted(&channel.unit));
        if let Some(group) = &channel.group {
            let _ = writeln!(out, "group = {}", quoted(group));
        }
        out
    }
}

/// A text of TOML.
fn quoted(text: &str) -> String {
    toml::Value::String(text.to_owned()).to_string()
}

/// A time in whole microseconds, not before the time itself.
fn up(time: f64) -> f64 {
    (time * 1e6 - 1e-3).ceil() / 1e6
}

/// A name as a cell of csv.
fn cell(name: &str) -> String {
    match name.contains([',', '"', '\n']) {
        true => format!("\"{}\"", name.replace('"', "\"\"")),
        false => name.to_owned(),
    }
}
