//! Recorded signals, and the results from them.

use super::{
    clean::{Cleaned, Drop, clean},
    delay::Delay,
    smooth::Smoothing,
    spectrum::Noise,
    stationarity::Stationarity,
    uncertainty::{MeasuredValue, from_bound},
};
use sampling::statistics::moments::mean;

/// A unit behind a number: nothing of one without a unit.
pub fn behind(unit: &str) -> String {
    match unit {
        "1" => String::new(),
        unit => format!(" {unit}"),
    }
}

/// How accurate a sensor is: every error up to plus or minus this much is equally likely.
#[derive(Clone, Copy, Debug)]
pub enum Accuracy {
    /// Absolute accuracy, in the signal's unit.
    Absolute(f64),
    /// Relative accuracy: a fraction of the value.
    Relative(f64),
}

impl Accuracy {
    /// The standard uncertainty of a value.
    pub(crate) fn standard(self, value: f64) -> f64 {
        from_bound(match self {
            Self::Absolute(bound) => bound,
            Self::Relative(part) => part * value.abs(),
        })
    }
}

/// One recorded signal.
#[derive(Clone, Debug)]
pub struct Channel {
    /// The criterion's name.
    pub name: String,
    /// The FMU variable that it is compared with; empty for a signal that becomes no criterion.
    pub variable: String,
    /// The unit of the values.
    pub unit: String,
    /// Times of the samples, s.
    pub time: Vec<f64>,
    /// The samples, as recorded.
    pub values: Vec<f64>,
    /// What gives the times: channels of one clock may share rows.
    pub clock: usize,
    /// How many rows of the recording gave no sample, and why.
    pub lost: Vec<(usize, &'static str)>,
    /// Which doubtful samples do not count.
    pub drop: Drop,
    /// The sensor's accuracy.
    pub accuracy: Accuracy,
    /// The group of criteria that it is counted with.
    pub group: Option<String>,
}

impl Channel {
    /// Samples of it, without those that the user does not want.
    pub(crate) fn clean(&self, values: &[f64]) -> Cleaned {
        clean(values, self.drop)
    }

    /// How many samples were left out as the user wished, and why.
    pub(crate) fn dropped(&self, cleaned: &Cleaned) -> [(usize, &'static str); 2] {
        let left_out = |wanted: bool, count: usize| if wanted { count } else { 0 };
        // A sample is no spike and clipped at once: the range is that of the samples that are no spikes.
        [
            (left_out(self.drop.spikes, cleaned.spikes), "spikes"),
            (left_out(self.drop.clipped, cleaned.clipped_count()), "clipped"),
        ]
    }

    /// The samples at times within a window.
    pub(crate) fn within(&self, [from, to]: [f64; 2]) -> (Vec<f64>, Vec<f64>) {
        self.time.iter().zip(&self.values).filter(|(time, _)| (from..=to).contains(*time)).unzip()
    }

    /// How many samples are before a time.
    pub(crate) fn before(&self, time: f64) -> usize {
        self.time.iter().filter(|known| **known < time).count()
    }

    /// What became of its rows: those that were lost for these reasons, too, are not used.
    pub(crate) fn account(&self, reasons: &[(usize, &'static str)]) -> Account {
        let lost: Vec<_> = self.lost.iter().chain(reasons).filter(|(count, _)| *count > 0).copied().collect();
        let rows = self.values.len() + self.lost.iter().map(|(count, _)| count).sum::<usize>();
        Account { name: self.name.clone(), rows, used: rows - lost.iter().map(|(count, _)| count).sum::<usize>(), lost }
    }
}

/// Why rows before the model's start are not used.
pub const EARLY: &str = "before the model's start";

/// What became of the rows of a channel: those that are used and those that are not are all of them.
#[derive(Debug)]
pub struct Account {
    /// The channel.
    pub name: String,
    /// The rows of its file.
    pub rows: usize,
    /// Those that count.
    pub used: usize,
    /// How many do not, and why.
    pub lost: Vec<(usize, &'static str)>,
}

impl std::fmt::Display for Account {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        write!(f, "{}: {} rows, {} used", self.name, self.rows, self.used)?;
        self.lost.iter().try_for_each(|(count, why)| write!(f, ", {count} {why}"))
    }
}

/// Load and torque of a bearing, of which the torque is late.
#[derive(Debug)]
pub struct Bearing {
    /// The load on the bearing, N.
    pub load: Channel,
    /// The friction torque, N.m.
    pub torque: Channel,
    /// The shaft's speed, rad/s.
    pub speed: Channel,
    /// Diameter of the bearing, m.
    pub diameter: f64,
    /// Smoothing of load and torque.
    pub smoothing: Smoothing,
    /// The longest delay to look for, s.
    pub longest_delay: f64,
}

/// A recording and what to do with it.
#[derive(Debug)]
pub struct RigRecording {
    /// Load and torque, where it has them.
    pub bearing: Option<Bearing>,
    /// Further signals of which the mean becomes a criterion, such as temperatures.
    pub others: Vec<Channel>,
    /// The part of the record to use, s.
    pub window: Option<[f64; 2]>,
    /// When the model starts, s: earlier rows are not used. Without it, with the first row.
    pub start: Option<f64>,
    /// Confidence of the tests of stationarity, such as 0.99.
    pub confidence: f64,
}

impl RigRecording {
    /// The part of the record to use, s: all of it from the model's start on where the user names none.
    pub(crate) fn window(&self) -> [f64; 2] {
        let [from, to] = self.window.unwrap_or([f64::NEG_INFINITY, f64::INFINITY]);
        [from.max(self.begin()), to]
    }

    /// When the model starts, s, where the user says so.
    pub(crate) fn begin(&self) -> f64 {
        self.start.unwrap_or(f64::NEG_INFINITY)
    }

    /// The time of a turn of the shaft, s; `None` where it does not turn.
    pub(crate) fn turn(&self) -> Option<f64> {
        let turn = std::f64::consts::TAU / mean(&self.speeds()).abs();
        turn.is_finite().then_some(turn)
    }

    /// All that was measured: load and torque first.
    pub fn signals(&self) -> impl Iterator<Item = &Channel> {
        self.bearing.iter().flat_map(|bearing| [&bearing.load, &bearing.torque]).chain(&self.others)
    }

    fn speeds(&self) -> Vec<f64> {
        self.bearing.iter().flat_map(|bearing| bearing.speed.values.iter().copied()).filter(|v| v.is_finite()).collect()
    }

    /// By what part the speed strays to either side of its mean, apart from its noise.
    pub(crate) fn speed_spread(&self) -> f64 {
        let speed = self.speeds();
        speed
            .chunks((speed.len() / 16).max(1))
            .map(mean)
            .map(|part| (part / mean(&speed) - 1.0).abs())
            .fold(0.0, f64::max)
    }
}

/// A criterion derived from the record.
#[derive(Debug, Default)]
pub struct DerivedCriterion {
    /// The criterion's name.
    pub name: String,
    /// The FMU variable.
    pub variable: String,
    /// The unit of the numbers.
    pub unit: String,
    /// The group of criteria.
    pub group: Option<String>,
    /// The value with its uncertainty.
    pub measured: MeasuredValue,
    /// The noise of the channel's rows as recorded; `None` of what follows from several channels, and where the record is too short
    /// to tell.
    pub noise: Option<Noise>,
    /// Means of blocks of whole turns, evenly over the window.
    pub blocks: Vec<f64>,
    /// The first block's begin and the duration of each, s.
    pub block: [f64; 2],
    /// The tests of the block means; `None` where the window is too short for them.
    pub stationarity: Option<Stationarity>,
}

/// Result of synchronising a recording.
#[derive(Debug, Default)]
pub struct Synchronised {
    /// The delay between torque and load.
    pub delay: Delay,
    /// Times of the aligned signals, s.
    pub time: Vec<f64>,
    /// The load before smoothing, N.
    pub load_raw: Vec<f64>,
    /// The torque as recorded, before smoothing, N.m.
    pub torque_raw: Vec<f64>,
    /// The smoothed load, N.
    pub load: Vec<f64>,
    /// The smoothed torque as recorded, N.m.
    pub torque_before: Vec<f64>,
    /// The smoothed torque, shifted, N.m.
    pub torque: Vec<f64>,
    /// Relative standard deviation of the friction coefficient before the shift and after it.
    pub friction_scatter: [f64; 2],
    /// The friction coefficient before the shift.
    pub friction_before: Vec<f64>,
    /// The friction coefficient after the shift.
    pub friction: Vec<f64>,
    /// The friction coefficient as a measured quantity.
    pub mean_friction: MeasuredValue,
    /// The criteria.
    pub findings: Vec<DerivedCriterion>,
    /// Caveats for the reader.
    pub warnings: Vec<String>,
    /// What a verdict must say, too: a part of the curves is doubtful.
    pub doubts: Vec<String>,
    /// What became of the rows of each channel.
    pub accounts: Vec<Account>,
}
