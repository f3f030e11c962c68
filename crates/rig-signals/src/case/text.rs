//! A case as text: the section of a study, and its tables.

use super::{
    super::{
        delay::Delay,
        recording::{Account, Accuracy, Channel, EARLY, behind},
        spectrum::Noise,
        uncertainty::from_bound,
    },
    Case, CaseCurve, Driven, Frame, Input, at,
};
use sampling::statistics::moments::sorted;

/// The file of the inputs.
const INPUTS: &str = "case-inputs.csv";

impl Case<'_> {
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
        let head = |names: &mut dyn Iterator<Item = &str>| {
            let mut csv = csv::Writer::from_writer(Vec::new());
            csv.write_record(["time"].into_iter().chain(names)).expect("memory takes all");
            String::from_utf8(csv.into_inner().expect("memory takes all")).expect("names are text")
        };
        let mut files = Vec::new();
        for (place, table) in self.tables.iter().enumerate() {
            let curves: Vec<_> = self.curves.iter().filter(|curve| curve.table == place).collect();
            let mut text = head(&mut curves.iter().map(|curve| &*curve.channel.name));
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
            let mut text = head(&mut self.inputs.iter().map(|input| &*input.drive.variable));
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
    fn late(&self, curve: &CaseCurve, frame: &Frame) -> f64 {
        let late = match curve.delay.and_then(|delay| delay.delay) {
            Some(delay) => delay.value - frame.lag,
            None => 0.0,
        };
        // As it is written.
        (late * 1e7).round() / 1e7
    }

    /// By how much a curve may be later than it is taken to be, to either side, s. Its standard uncertainty comes from few
    /// blocks, so the range is wide; a delay without an interval may be any that was searched.
    fn reach(&self, curve: &CaseCurve) -> f64 {
        const DEVIATIONS: f64 = 10.0;
        let Some(delay) = curve.delay.filter(|delay| delay.delay.is_some()) else {
            return 0.0;
        };
        let longest = self.recording.bearing.as_ref().map_or(0.0, |bearing| bearing.longest_delay);
        let reach = delay.uncertainty().map_or(longest, |one| (DEVIATIONS * one).min(longest));
        // As it is written.
        (reach * 1e7).round() / 1e7
    }

    fn criterion(&self, curve: &CaseCurve, frame: &Frame) -> String {
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

impl Input<'_> {
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

/// A time in whole microseconds, the next ones unless the last are nearer than a nanosecond, which is rounding; 0 has no sign.
fn up(time: f64) -> f64 {
    (time * 1e6 - 1e-3).ceil() / 1e6 + 0.0
}
