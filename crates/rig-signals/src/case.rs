//! A case of a study from a recording: what drove the rig as inputs, what was measured as curves with their uncertainty.

use super::{
    delay::Delay,
    holes::Holes,
    recording::{Account, Accuracy, Channel, EARLY, RigRecording, Synchronised, behind},
    signal::SignalError,
    spectrum::Noise,
    thin::{Polyline, polyline},
    uncertainty::from_bound,
};
use sampling::statistics::moments::sorted;

/// Settings by which a recording becomes a case.
pub struct Frame<'a> {
    /// The case's name.
    pub name: &'a str,
    /// Whether it is judged and never fitted.
    pub held_out: bool,
    /// The folder of the tables, as the study names it.
    pub folder: &'a str,
    /// How far the model may be off, by criteria's names, as the settings say it.
    pub tolerances: &'a [(String, String)],
    /// By how much the torque lags behind the load in the rig itself, and so in the model, s.
    pub lag: f64,
}

/// A variable of the FMU that is driven as it was recorded.
#[derive(Debug)]
pub struct Drive {
    /// The variable.
    pub variable: String,
    /// Its unit.
    pub unit: String,
    /// How far the input may deviate from the recording, beyond the noise, in its unit.
    pub tolerance: Option<f64>,
    /// Its values.
    pub values: Driven,
}

/// The values of an input.
#[derive(Debug)]
pub enum Driven {
    /// One for the whole run.
    Constant(f64),
    /// As recorded.
    Recorded(Channel),
}

fn stated(key: &str, text: &str) -> String {
    format!(", {key} = {}", quoted(text))
}

/// The expanded uncertainty (k = 2) that follows from the limit of a sensor's error, which all rows share.
fn known(channel: &Channel) -> String {
    let expanded = |bound: f64| 2.0 * from_bound(bound);
    match channel.accuracy {
        // Of a sensor without errors there is nothing to state.
        Accuracy::Absolute(0.0) | Accuracy::Relative(0.0) => String::new(),
        Accuracy::Absolute(bound) => stated("uncertainty", &format!("{:.4e} {}", expanded(bound), channel.unit)),
        Accuracy::Relative(part) => stated("gain-uncertainty", &format!("{:.4} %", 100.0 * expanded(part))),
    }
}

/// A measured curve: its samples without those that the user does not want.
struct Measured<'a> {
    channel: &'a Channel,
    time: Vec<f64>,
    values: Vec<f64>,
    early: usize,
    dropped: [(usize, &'static str); 2],
    /// By how much it is late.
    delay: Option<&'a Delay>,
    /// The number of its table.
    table: usize,
}

/// An input as it is written.
struct Input<'a> {
    channel: &'a Channel,
    drive: &'a Drive,
    line: Polyline,
    /// What was left out, and how many samples.
    lost: [(usize, &'static str); 3],
    /// What stays and may be none of the input.
    doubts: Vec<String>,
    /// The longest time without samples.
    hole: Option<[f64; 2]>,
}

/// Rows with a sample of each of some curves.
struct Rows {
    clock: usize,
    time: Vec<f64>,
}

/// What a recording gives for a case of a study.
pub struct Case<'a> {
    recording: &'a RigRecording,
    result: &'a Synchronised,
    drives: &'a [Drive],
    tables: Vec<Rows>,
    curves: Vec<Measured<'a>>,
    inputs: Vec<Input<'a>>,
    /// When the model starts.
    begin: f64,
}

/// The times that are in both of two growing lists.
fn common(one: &[f64], other: &[f64]) -> Vec<f64> {
    one.iter().filter(|time| other.binary_search_by(|known| known.total_cmp(time)).is_ok()).copied().collect()
}

/// The value of a polyline at a time; its ends are held.
fn at(line: &Polyline, time: f64) -> f64 {
    let next = line.time.partition_point(|known| *known < time);
    match (next.checked_sub(1), line.values.get(next)) {
        (Some(last), Some(value)) => {
            let [from, to] = [line.time[last], line.time[next]];
            let part = (time - from) / (to - from);
            line.values[last] + part * (value - line.values[last])
        }
        (None, Some(value)) => *value,
        (last, None) => line.values[last.unwrap_or(0)],
    }
}

impl<'a> Case<'a> {
    /// The case of a synchronised recording.
    pub fn new(recording: &'a RigRecording, result: &'a Synchronised, drives: &'a [Drive]) -> Self {
        /// Curves share a table where that costs no more of their rows.
        const SHARED: f64 = 0.99;
        let torque = recording.bearing.as_ref().map(|bearing| &bearing.torque);
        let mut tables: Vec<Rows> = Vec::new();
        let mut curves = Vec::new();
        for channel in recording.signals() {
            let (time, values) = channel.within([recording.begin(), f64::INFINITY]);
            let early = channel.time.len() - time.len();
            let cleaned = channel.clean(&values);
            let (time, values): (Vec<f64>, Vec<f64>) =
                time.iter().zip(&cleaned.values).filter(|(_, value)| value.is_finite()).unzip();
            let shared = tables.iter().position(|table| {
                let both = common(&table.time, &time).len() as f64;
                table.clock == channel.clock && both >= SHARED * table.time.len().max(time.len()) as f64
            });
            match shared {
                Some(place) => tables[place].time = common(&tables[place].time, &time),
                None => tables.push(Rows { clock: channel.clock, time: time.clone() }),
            }
            curves.push(Measured {
                channel,
                early,
                dropped: channel.dropped(&cleaned),
                time,
                values,
                delay: torque.filter(|torque| std::ptr::eq(*torque, channel)).map(|_| &result.delay),
                table: shared.unwrap_or(tables.len() - 1),
            });
        }
        let inputs: Vec<Input<'a>> = drives
            .iter()
            .filter_map(|drive| match &drive.values {
                Driven::Constant(_) => None,
                Driven::Recorded(channel) => Some(Input::new(channel, drive, recording.begin())),
            })
            .collect();
        let firsts = curves
            .iter()
            .map(|curve| curve.channel)
            .chain(inputs.iter().map(|input| input.channel))
            .filter_map(|channel| channel.time.first().copied());
        Self {
            begin: recording.start.unwrap_or_else(|| firsts.fold(f64::INFINITY, f64::min)),
            recording,
            result,
            drives,
            tables,
            curves,
            inputs,
        }
    }

    /// The first and the last time of a table; times count from the model's start.
    fn span(&self, table: usize) -> [f64; 2] {
        let time = &self.tables[table].time;
        [time.first(), time.last()].map(|end| end.map_or(0.0, |time| time - self.begin))
    }

    /// When the inputs end, where there are recorded ones.
    fn inputs_end(&self) -> f64 {
        self.inputs
            .iter()
            .filter_map(|input| input.line.time.last())
            .fold(f64::INFINITY, |end, time| end.min(time - self.begin))
    }

    /// Refuses an input that has no time in common with what was measured.
    ///
    /// # Errors
    /// With the times of both.
    pub fn check(&self) -> Result<(), SignalError> {
        let spans = || (0..self.tables.len()).map(|table| self.span(table));
        let begin = spans().map(|[from, _]| from).fold(f64::INFINITY, f64::min);
        let end = spans().map(|[_, to]| to).fold(f64::NEG_INFINITY, f64::max);
        for Input { drive, line, .. } in &self.inputs {
            let name = &drive.variable;
            let [Some(first), Some(last)] = [line.time.first(), line.time.last()] else {
                return Err(SignalError::Setting(format!(
                    "input {name}: its column holds no numbers; name another one"
                )));
            };
            let [first, last] = [first, last].map(|time| time - self.begin);
            if first > end || last < begin {
                return Err(SignalError::Setting(format!(
                    "input {name} was recorded from {first:.3} s to {last:.3} s and the signals from {begin:.3} s to {end:.3} s: \
                     correct the `offset` of a file's time"
                )));
            }
        }
        Ok(())
    }

    /// What the reader must know of an input's times.
    fn times_of(&self, input: &Input) -> Vec<String> {
        let name = &input.drive.variable;
        let first = input.line.time.first().map_or(0.0, |first| first - self.begin);
        let late = (first > 0.0 && (0..self.tables.len()).any(|table| self.span(table)[0] < first - input.step()))
            .then(|| format!("input {name} begins at {first:.6} s, and before that has its first value"));
        let hole = input.hole.map(|ends| {
            let [from, to] = ends.map(|end| end - self.begin);
            format!("input {name} has no samples from {from:.6} s to {to:.6} s, and there follows a straight line")
        });
        late.into_iter().chain(hole).collect()
    }

    /// The name of a table's file.
    fn file(table: usize) -> String {
        match table {
            0 => "case.csv".to_owned(),
            _ => format!("case-{}.csv", table + 1),
        }
    }

    /// The files of the case with their texts: curves whose rows belong together in one each, and the inputs.
    pub fn tables(&self) -> Vec<(String, String)> {
        let line = |time: f64, cells: &mut dyn Iterator<Item = f64>| {
            let cells: String = cells.map(|value| format!(",{value:.8e}")).collect();
            format!("{:.9}{cells}\n", time - self.begin)
        };
        let head = |names: Vec<String>| format!("time,{}\n", names.join(","));
        let mut files = Vec::new();
        for (place, table) in self.tables.iter().enumerate() {
            let curves: Vec<_> = self.curves.iter().filter(|curve| curve.table == place).collect();
            let mut text = head(curves.iter().map(|curve| cell(&curve.channel.name)).collect());
            for time in &table.time {
                text += &line(
                    *time,
                    &mut curves.iter().map(|curve| {
                        let known = curve.time.binary_search_by(|known| known.total_cmp(time));
                        curve.values[known.expect("a row of a table is in each of its curves")]
                    }),
                );
            }
            files.push((Self::file(place), text));
        }
        let mut times = sorted(self.inputs.iter().flat_map(|input| input.line.time.clone()).collect());
        times.dedup();
        if !times.is_empty() {
            let mut text = head(self.inputs.iter().map(|input| cell(&input.drive.variable)).collect());
            text.extend(
                times.iter().map(|&time| line(time, &mut self.inputs.iter().map(|input| at(&input.line, time)))),
            );
            files.push((INPUTS.to_owned(), text));
        }
        files
    }

    /// What became of the rows of each curve.
    pub fn accounts(&self) -> Vec<Account> {
        self.curves
            .iter()
            .map(|curve| {
                let beside = curve.time.len() - self.tables[curve.table].time.len();
                let [spikes, clipped] = curve.dropped;
                curve.channel.account(&[
                    (curve.early, EARLY),
                    spikes,
                    clipped,
                    (beside, "in rows where another signal has none"),
                ])
            })
            .collect()
    }

    /// The case as TOML. The tolerances are the user's to add, where the settings have none: no recording knows how far the
    /// model may be off.
    pub fn to_toml(&self, frame: &Frame) -> String {
        let mut out = match self.recording.start {
            None => "# Times count from the first row of the recording.\n".to_owned(),
            Some(start) => format!("# The model starts at {start} s of the recording.\n"),
        };
        for (curve, account) in self.curves.iter().zip(self.accounts()) {
            let file = Self::file(curve.table);
            out += &format!("# {file}, {account}.\n");
        }
        out.extend(self.inputs.iter().map(Input::comment));
        out.extend(self.result.warnings.iter().map(|warning| format!("# Note: {warning}.\n")));
        let inputs = self.inputs.iter().flat_map(|input| self.times_of(input));
        out.extend(inputs.map(|note| format!("# Note: {note}.\n")));
        let late = self.curves.iter().map(|curve| self.late(curve, frame));
        let early = late.map(|late| -late).fold(0.0, f64::max);
        let last = (0..self.tables.len()).map(|table| self.span(table)[1]).fold(0.0, f64::max);
        // What is judged ends with the window.
        let last = last.min(self.recording.window()[1] - self.begin);
        let end = self.inputs_end();
        if end < last {
            out += &format!("# Note: an input ends at {end:.6} s, so what was measured later is not judged.\n");
        }
        let of_inputs = self.inputs.iter().flat_map(|input| &input.doubts);
        let doubts: Vec<String> = self.result.doubts.iter().chain(of_inputs).cloned().collect();
        out += &format!(
            "[[cases]]\nname = {}\n{}{}simulation = {{ stop = {} }}\n",
            quoted(frame.name),
            if doubts.is_empty() { String::new() } else { format!("concerns = {}\n", toml::Value::from(doubts)) },
            if frame.held_out { "held-out = true\n" } else { "" },
            up(last.min(end) + early)
        );
        for drive in self.drives {
            let (name, unit) = (quoted(&drive.variable), quoted(&drive.unit));
            out += &match &drive.values {
                Driven::Constant(value) => {
                    let value = quoted(&format!("{value} {}", drive.unit));
                    format!("fixed.{name} = {value}\n")
                }
                Driven::Recorded(channel) => {
                    let stated = known(channel);
                    let first = self.inputs.iter().filter_map(|input| input.line.time.first());
                    let first = first.fold(f64::INFINITY, |first, time| first.min(*time));
                    // The model runs from the first row, whole or not, and on until the last curve that is ahead of it.
                    let ends = if first > self.begin || early > 0.0 { ", extrapolate = \"hold\"" } else { "" };
                    format!(
                        "inputs.{name} = {{ file = {}, time = \"time\", column = {name}, unit = {unit}{stated}{ends} }}\n",
                        quoted(&format!("{}/{INPUTS}", frame.folder))
                    )
                }
            };
        }
        out.extend(self.curves.iter().map(|curve| self.criterion(curve, frame)));
        out
    }

    /// By how much a curve is late, s.
    fn late(&self, curve: &Measured, frame: &Frame) -> f64 {
        let late = match curve.delay.and_then(|delay| delay.delay) {
            Some(delay) => delay.value - frame.lag,
            None => 0.0,
        };
        // As it is written.
        (late * 1e7).round() / 1e7
    }

    /// By how much a curve may be later than it is taken to be, to either side, s. Its standard uncertainty comes from few
    /// blocks, so the range is wide; a delay without an interval may be any that was searched.
    fn reach(&self, curve: &Measured) -> f64 {
        const DEVIATIONS: f64 = 10.0;
        let Some(delay) = curve.delay.filter(|delay| delay.delay.is_some()) else {
            return 0.0;
        };
        let longest = self.recording.bearing.as_ref().map_or(0.0, |bearing| bearing.longest_delay);
        let reach = delay.uncertainty().map_or(longest, |one| (DEVIATIONS * one).min(longest));
        // As it is written.
        (reach * 1e7).round() / 1e7
    }

    fn criterion(&self, curve: &Measured, frame: &Frame) -> String {
        let channel = curve.channel;
        let (name, unit) = (quoted(&channel.name), quoted(&channel.unit));
        let criterion = self.result.findings.iter().find(|c| c.name == channel.name);
        let steady = criterion
            .and_then(|criterion| criterion.stationarity.as_ref())
            .map(|s| format!("{}\n", s.comment("drifting", &channel.unit)))
            .unwrap_or_default();
        let mut uncertainty = known(channel);
        let noise = criterion.and_then(|criterion| criterion.noise);
        let about_noise = noise
            .map(|noise| {
                uncertainty += &stated("noise", &format!("{:.2e} {}", noise.stated(), channel.unit));
                uncertainty += &format!(
                    ", noise-estimate = {{ freedom = {:.0}, correlation = {:.2}, rows = {:.2} }}",
                    noise.freedom,
                    noise.correlation.clamp(-1.0, 1.0),
                    noise.rows()
                );
                about(noise, &channel.unit)
            })
            .unwrap_or_default();
        let (late, reach) = (self.late(curve, frame), self.reach(curve));
        let words = curve.delay.and_then(Delay::words);
        let delay = words
            .map(|words| {
                let whose = match frame.lag {
                    0.0 => "all of which is taken for the sensor's".to_owned(),
                    lag => format!("of which {:.3} ms are the rig's own", 1e3 * lag),
                };
                format!(
                    "# late after the load by {words}, {whose}\n\
                 delay = \"{:.4} ms\"\n{}",
                    1e3 * late,
                    if reach > 0.0 {
                        format!(
                            "# identify finds the rest with the parameters: both follow from the same rows\n\
                         lag = {{ min = \"{0:.4} ms\", max = \"{1:.4} ms\" }}\n",
                            -1e3 * reach,
                            1e3 * reach
                        )
                    } else {
                        String::new()
                    }
                )
            })
            .unwrap_or_default();
        let [first, last] = self.span(curve.table);
        let [from, to] = self.recording.window();
        let to = to.min(self.inputs_end() + self.begin);
        let from = (from - self.begin).max(first + (late + reach).max(0.0));
        let to = (to - self.begin).min(last + (late - reach).min(0.0));
        let window = if from > first || to < last {
            format!("window = {{ from = {}, to = {} }}\n", up(from), up(to))
        } else {
            String::new()
        };
        let mut tolerances = frame.tolerances.iter();
        let tolerance = match tolerances.find(|(name, _)| *name == channel.name) {
            Some((_, tolerance)) => format!("tolerance = {}", quoted(tolerance)),
            None => format!("# tolerance = \"... {}\"   # how far the model may be from the true curve", channel.unit),
        };
        let group = channel.group.as_ref();
        let group = group.map(|group| format!("group = {}\n", quoted(group))).unwrap_or_default();
        format!(
            "\n[cases.criteria.{name}]\n{steady}{about_noise}variable = {}\n\
             reference = {{ file = {}, time = \"time\", column = {name}, unit = {unit}{uncertainty} }}\n\
             metric = \"rmse\"\n{delay}{window}{tolerance}\nunit = {unit}\n{group}",
            quoted(&channel.variable),
            quoted(&format!("{}/{}", frame.folder, Self::file(curve.table)))
        )
    }
}

/// The file of the inputs.
const INPUTS: &str = "case-inputs.csv";

impl<'a> Input<'a> {
    /// An input from the model's start on, when it has the value between its rows.
    fn new(channel: &'a Channel, drive: &'a Drive, start: f64) -> Self {
        let early = channel.before(start).saturating_sub(1);
        let (all, cleaned) = (&channel.time[early..], channel.clean(&channel.values[early..]));
        let (time, values): (Vec<f64>, Vec<f64>) =
            all.iter().zip(&cleaned.values).filter(|(_, value)| value.is_finite()).unzip();
        let mut line = polyline(&time, &values, drive.tolerance);
        let value = line.time.first().map(|_| at(&line, start));
        if let (Some(first), Some(value)) = (line.time.first_mut().filter(|first| **first < start), value) {
            (*first, line.values[0]) = (start, value);
        }
        Self {
            channel,
            drive,
            line,
            lost: {
                let [spikes, clipped] = channel.dropped(&cleaned);
                [(early, EARLY), spikes, clipped]
            },
            doubts: if channel.drop.is_stated { Vec::new() } else { super::concerns(channel, &cleaned) },
            hole: Holes::of(all, &cleaned).longest(),
        }
    }

    /// The mean time between samples, s.
    fn step(&self) -> f64 {
        let time = &self.channel.time;
        let span = time.last().zip(time.first()).map_or(0.0, |(last, first)| last - first);
        span / time.len().max(1) as f64
    }

    /// A comment that says how it was thinned.
    fn comment(&self) -> String {
        let (account, line, unit) = (self.channel.account(&self.lost), &self.line, &self.drive.unit);
        let noise = line.noise.map(|noise| format!(" (noise of a row {noise:.2e})")).unwrap_or_default();
        format!(
            "# {INPUTS}, {account} for a line with {} corners; it leaves out {:.2e} {unit} rms{noise}, tolerance {:.2e}.\n",
            line.time.len(),
            line.left,
            line.tolerance
        )
    }
}

/// A comment that says of what the stated noise consists.
fn about(noise: Noise, unit: &str) -> String {
    let Noise { row, equivalent, .. } = noise;
    let mut parts = format!("# noise: {row:.2e}{} in a row as recorded", behind(unit));
    if noise.is_shared() {
        parts += &format!(
            "; neighbouring rows share it, so a row counts as one with an independent noise of {equivalent:.2e}"
        );
    }
    parts + "\n"
}

/// A text of TOML.
pub fn quoted(text: &str) -> String {
    toml::Value::String(text.to_owned()).to_string()
}

/// A time in whole microseconds, not before the time itself; 0 has no sign.
fn up(time: f64) -> f64 {
    (time * 1e6 - 1e-3).ceil() / 1e6 + 0.0
}

/// A name as a cell of csv.
fn cell(name: &str) -> String {
    if name.contains([',', '"', '\n']) { format!("\"{}\"", name.replace('"', "\"\"")) } else { name.to_owned() }
}
