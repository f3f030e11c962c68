//! A case of a study from a recording: what drove the rig as inputs, what was measured as curves with their uncertainty.

use super::{
    delay::Delay,
    holes::Holes,
    recording::{Channel, EARLY, RigRecording, Synchronised},
    signal::SignalError,
    thin::{Polyline, polyline},
};

pub mod text;

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

/// A measured curve: its samples without those that the user does not want.
struct CaseCurve<'a> {
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
    curves: Vec<CaseCurve<'a>>,
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
            curves.push(CaseCurve {
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
}

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
}
