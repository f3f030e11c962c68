//! A case of a study from a recording: what drove the rig as inputs, what was measured as curves with their uncertainty.

use super::delay::Delay;
use super::recording::{Accuracy, Channel, DerivedCriterion, RigRecording, Synchronised};
use super::spectrum::Noise;
use super::uncertainty::from_bound;

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
    /// How far all its values together may be off: the limit of the sensor's error, in its unit.
    pub accuracy: Option<f64>,
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

/// The expanded uncertainty (k = 2) that follows from a limit of error.
fn expanded(bound: f64) -> f64 {
    2.0 * from_bound(bound)
}

/// A measured curve.
struct Measured<'a> {
    channel: &'a Channel,
    values: Vec<f64>,
    /// By how much it is late.
    delay: Option<&'a Delay>,
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
            curve(&recording.torque, Some(&result.delay)),
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
        let line = |&row: &usize| {
            let cells = columns.iter();
            let cells = cells.map(|(_, values)| format!(",{:.8e}", values[row]));
            format!("{:.9}{}\n", self.time(row), cells.collect::<String>())
        };
        let lines: String = self.rows.iter().map(line).collect();
        format!("time,{}\n{lines}", names.join(","))
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
            out += &format!(
                "# {left} rows with a missing sample, a spike or a clipped sample were left out.\n"
            );
        }
        for warning in &self.result.warnings {
            out += &format!("# Note: {warning}.\n");
        }
        let late = self.curves.iter().map(|curve| self.late(curve, frame));
        let early = late.map(|late| -late).fold(0.0, f64::max);
        // The model runs from the first row, whole or not, and on until the last curve that is ahead of it.
        let ends = match first > 0.0 || early > 0.0 {
            true => ", extrapolate = \"hold\"",
            false => "",
        };
        out += &format!(
            "[[cases]]\nname = {}\n{}simulation = {{ stop = {} }}\n",
            quoted(frame.name),
            if frame.held_out {
                "held-out = true\n"
            } else {
                ""
            },
            up(last + early)
        );
        for drive in frame.drives {
            let (name, unit) = (quoted(&drive.variable), quoted(&drive.unit));
            out += &match &drive.values {
                Driven::Constant(value) => {
                    let value = quoted(&format!("{value} {}", drive.unit));
                    format!("fixed.{name} = {value}\n")
                }
                Driven::Recorded(_) => {
                    let accuracy = drive.accuracy.filter(|accuracy| *accuracy > 0.0);
                    let stated = accuracy.map_or_else(String::new, |bound| {
                        let expanded = format!("{:.4e} {}", expanded(bound), drive.unit);
                        format!(", uncertainty = {}", quoted(&expanded))
                    });
                    format!(
                        "inputs.{name} = {{ file = {}, time = \"time\", column = {name}, unit = {unit}{stated}{ends} }}\n",
                        quoted(frame.file)
                    )
                }
            };
        }
        out.extend(self.curves.iter().map(|curve| self.criterion(curve, frame)));
        out
    }

    /// By how much a curve is late, s.
    fn late(&self, curve: &Measured<'_>, frame: &Frame<'_>) -> f64 {
        let late = match curve.delay.and_then(|delay| delay.delay) {
            Some(delay) => delay.value - frame.lag,
            None => 0.0,
        };
        // As it is written.
        (late * 1e7).round() / 1e7
    }

    /// By how much a curve may be later than it is taken to be, to either side, s. Its standard uncertainty comes from few
    /// blocks, so the range is wide; a delay without an interval may be any that was searched.
    fn reach(&self, curve: &Measured<'_>) -> f64 {
        const DEVIATIONS: f64 = 10.0;
        let Some(delay) = curve.delay.filter(|delay| delay.delay.is_some()) else {
            return 0.0;
        };
        let longest = self.recording.longest_delay;
        let reach = delay.uncertainty();
        let reach = reach.map_or(longest, |one| (DEVIATIONS * one).min(longest));
        // As it is written.
        (reach * 1e7).round() / 1e7
    }

    fn criterion(&self, curve: &Measured<'_>, frame: &Frame<'_>) -> String {
        let channel = curve.channel;
        let (name, unit) = (quoted(&channel.name), quoted(&channel.unit));
        let is_mean = |c: &&DerivedCriterion| c.name == channel.name && c.statistic == "mean";
        let criterion = self.result.findings.iter().find(is_mean);
        let tested = criterion.and_then(|criterion| criterion.stationarity.as_ref());
        let steady = tested.map_or_else(String::new, |s| {
            let (word, change) = (if s.steady() { "steady" } else { "drifting" }, s.change);
            format!(
                "# {word}: change over the window {:.2e} ({:.2e} to {:.2e}) {}\n",
                change.value, change.low, change.high, channel.unit
            )
        });
        let stated = |key: &str, text: String| format!(", {key} = {}", quoted(&text));
        let mut uncertainty = match channel.accuracy {
            // Of a sensor without errors there is nothing to state.
            Accuracy::Absolute(0.0) | Accuracy::Relative(0.0) => String::new(),
            Accuracy::Absolute(bound) => stated(
                "uncertainty",
                format!("{:.4e} {}", expanded(bound), channel.unit),
            ),
            Accuracy::Relative(part) => stated(
                "gain-uncertainty",
                format!("{:.4} %", 100.0 * expanded(part)),
            ),
        };
        let noise = criterion.and_then(|criterion| criterion.noise);
        let about_noise = noise.map_or_else(String::new, |noise| {
            uncertainty += &stated("noise", format!("{:.2e} {}", noise.stated(), channel.unit));
            uncertainty += &format!(
                ", noise-estimate = {{ freedom = {:.0}, correlation = {:.2}, rows = {:.2} }}",
                noise.freedom,
                noise.correlation.clamp(-1.0, 1.0),
                noise.rows()
            );
            about(noise, &channel.unit)
        });
        let (late, reach) = (self.late(curve, frame), self.reach(curve));
        let words = curve.delay.and_then(Delay::words);
        let delay = words.map_or_else(String::new, |words| {
            let whose = match frame.lag {
                0.0 => "all of which is taken for the sensor's".to_owned(),
                lag => format!("of which {:.3} ms are the rig's own", 1e3 * lag),
            };
            format!(
                "# late after the load by {words}, {whose}\n\
                 delay = \"{:.4} ms\"\n{}",
                1e3 * late,
                match reach > 0.0 {
                    true => format!(
                        "# identify finds the rest with the parameters: both follow from the same rows\n\
                         lag = {{ min = \"{0:.4} ms\", max = \"{1:.4} ms\" }}\n",
                        -1e3 * reach,
                        1e3 * reach
                    ),
                    false => String::new(),
                }
            )
        });
        let [first, last] = self.span();
        let [from, to] = self.recording.window();
        let from = (from - self.begin).max(first + (late + reach).max(0.0));
        let to = (to - self.begin).min(last + (late - reach).min(0.0));
        let window = match from > first || to < last {
            true => format!("window = {{ from = {}, to = {} }}\n", up(from), up(to)),
            false => String::new(),
        };
        let mut tolerances = frame.tolerances.iter();
        let tolerance = match tolerances.find(|(name, _)| *name == channel.name) {
            Some((_, tolerance)) => format!("tolerance = {}", quoted(tolerance)),
            None => format!(
                "# tolerance = \"... {}\"   # how far the model may be from the true curve",
                channel.unit
            ),
        };
        let group = channel.group.as_ref();
        let group = group.map_or_else(String::new, |group| format!("group = {}\n", quoted(group)));
        format!(
            "\n[cases.criteria.{name}]\n{steady}{about_noise}variable = {}\n\
             reference = {{ file = {}, time = \"time\", column = {name}, unit = {unit}{uncertainty} }}\n\
             metric = \"rmse\"\n{delay}{window}{tolerance}\nunit = {unit}\n{group}",
            quoted(&channel.variable),
            quoted(frame.file)
        )
    }
}

/// A comment that says of what the stated noise consists.
fn about(noise: Noise, unit: &str) -> String {
    let Noise {
        row, equivalent, ..
    } = noise;
    let mut parts = format!("# noise: {row:.2e} {unit} in a row as recorded");
    if noise.is_shared() {
        parts += &format!(
            "; neighbouring rows share it, so a row counts as one with an independent noise of {equivalent:.2e}"
        );
    }
    parts + "\n"
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
