//! From measured time series to criteria: resample, smooth, align, test, and state the result with
//! its uncertainty (section 5.1 of Vrublevskyi & Skonieczna, and beyond it).

mod aligned;
pub mod criteria;
pub mod delay;
pub mod signal;
pub mod smooth;
pub mod stationarity;
pub mod uncertainty;

use aligned::Aligned;
use delay::Delay;
use signal::{Even, SignalError, Spline};
use smooth::Smoothing;
use stationarity::Stationarity;
use uncertainty::{MeasuredValue, from_bound};

/// How accurate a sensor is: every error up to plus or minus this much is equally likely.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Accuracy {
    /// Absolute accuracy, in the signal's unit.
    Absolute(f64),
    /// Relative accuracy: a fraction of the value.
    Relative(f64),
}

impl Accuracy {
    /// The standard uncertainty of a value.
    fn standard(self, value: f64) -> f64 {
        from_bound(match self {
            Self::Absolute(bound) => bound,
            Self::Relative(part) => part * value.abs(),
        })
    }
}

/// One recorded signal.
#[derive(Clone, Debug, PartialEq)]
pub struct Channel {
    /// The criterion's name.
    pub name: String,
    /// The FMU variable that it is compared with; empty for a signal that becomes no criterion.
    pub variable: String,
    /// The unit of the values.
    pub unit: String,
    /// The samples, as recorded.
    pub values: Vec<f64>,
    /// The sensor's accuracy.
    pub accuracy: Accuracy,
    /// The group of criteria that it is counted with.
    pub group: Option<String>,
}

/// What a quantity that follows from several signals is compared with.
#[derive(Clone, Debug, PartialEq)]
pub struct Derived {
    /// The criterion's name.
    pub name: String,
    /// The FMU variable that it is compared with.
    pub variable: String,
    /// The group of criteria that it is counted with.
    pub group: Option<String>,
}

/// A recording and what to do with it.
#[derive(Clone, Debug, PartialEq)]
pub struct RigRecording {
    /// Times of the samples, s.
    pub time: Vec<f64>,
    /// The load on the bearing, N.
    pub load: Channel,
    /// The friction torque, N.m.
    pub torque: Channel,
    /// The shaft's speed, rad/s.
    pub speed: Channel,
    /// The friction power, torque times speed, where that becomes a criterion.
    pub power: Option<Derived>,
    /// Further signals of which the mean becomes a criterion, such as temperatures.
    pub others: Vec<Channel>,
    /// Diameter of the bearing, m.
    pub diameter: f64,
    /// The part of the record to use, s.
    pub window: Option<[f64; 2]>,
    /// Smoothing of load and torque.
    pub smoothing: Smoothing,
    /// The longest delay to look for, s.
    pub longest_delay: f64,
    /// Confidence of the tests of stationarity, such as 0.99.
    pub confidence: f64,
}

/// A criterion derived from the record.
#[derive(Clone, Debug, PartialEq)]
pub struct DerivedCriterion {
    /// The criterion's name.
    pub name: String,
    /// The FMU variable.
    pub variable: String,
    /// The statistic: `mean` or `amplitude`.
    pub statistic: &'static str,
    /// The unit of the numbers.
    pub unit: String,
    /// The group of criteria.
    pub group: Option<String>,
    /// The value with its uncertainty.
    pub measured: MeasuredValue,
    /// Means of blocks of whole turns, evenly over the window; empty for an amplitude.
    pub blocks: Vec<f64>,
    /// The tests of the block means; `None` where the window is too short for them.
    pub stationarity: Option<Stationarity>,
}

/// Result of synchronising a recording.
#[derive(Clone, Debug, PartialEq)]
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
    /// The friction coefficient before the shift.
    pub friction_before: Vec<f64>,
    /// The friction coefficient after the shift.
    pub friction: Vec<f64>,
    /// The friction power, W.
    pub power: Vec<f64>,
    /// The duration of a block of the tests of stationarity, s.
    pub block: f64,
    /// The friction coefficient as a measured quantity.
    pub mean_friction: MeasuredValue,
    /// The criteria: means first, then amplitudes.
    pub findings: Vec<DerivedCriterion>,
    /// Caveats for the reader.
    pub warnings: Vec<String>,
}

/// A gap in the record may be this many times as long as a step.
const LONGEST_GAP: f64 = 10.0;

/// Aligns a recording and derives the criteria.
pub fn synchronise(recording: &RigRecording) -> Result<Synchronised, SignalError> {
    check(recording)?;
    let kept = window(recording);
    let time: Vec<f64> = kept.iter().map(|&k| recording.time[k]).collect();
    let spline = |channel: &Channel| {
        let values: Vec<f64> = kept.iter().map(|&k| channel.values[k]).collect();
        Spline::new(&channel.name, &time, &values, LONGEST_GAP)
    };
    let (load, torque, speed) = (
        spline(&recording.load)?,
        spline(&recording.torque)?,
        spline(&recording.speed)?,
    );
    let start = load.span().0.max(torque.span().0);
    let end = load.span().1.min(torque.span().1);
    let step = load.step();
    let even = |spline: &Spline| Even::from_spline(spline, start, end, step);
    let smooth = |raw: &Even| -> Result<Even, SignalError> {
        Ok(Even {
            values: recording.smoothing.apply(&raw.values, step)?,
            ..raw.clone()
        })
    };
    let raw = (even(&load), even(&torque));
    let (load, torque) = (smooth(&raw.0)?, smooth(&raw.1)?);
    let late = Spline::new(
        &recording.torque.name,
        &torque.times(),
        &torque.values,
        LONGEST_GAP,
    )?;
    let delay = delay::find(&load, &late, recording.longest_delay)?;
    Aligned::new(recording, raw, &load, &late, even(&speed), delay)
        .finish(recording, |c| Ok(even(&spline(c)?)))
}

fn check(recording: &RigRecording) -> Result<(), SignalError> {
    let wrong = |text: String| Err(SignalError::Setting(text));
    if !(recording.diameter.is_finite() && recording.diameter > 0.0) {
        return wrong(format!(
            "the bearing's diameter must be positive, not {} m",
            recording.diameter
        ));
    }
    if !(recording.longest_delay.is_finite() && recording.longest_delay > 0.0) {
        return wrong(format!(
            "the longest delay must be positive, not {} s",
            recording.longest_delay
        ));
    }
    if !(recording.confidence > 0.5 && recording.confidence < 1.0) {
        return wrong(format!(
            "the confidence must lie between 0.5 and 1, not at {}",
            recording.confidence
        ));
    }
    let channels = [&recording.load, &recording.torque, &recording.speed];
    match channels
        .into_iter()
        .chain(&recording.others)
        .find(|c| c.values.len() != recording.time.len())
    {
        Some(c) => wrong(format!(
            "signal '{}' has {} rows, the time has {}",
            c.name,
            c.values.len(),
            recording.time.len()
        )),
        None => Ok(()),
    }
}

fn window(recording: &RigRecording) -> Vec<usize> {
    let [from, to] = recording
        .window
        .unwrap_or([f64::NEG_INFINITY, f64::INFINITY]);
    (0..recording.time.len())
        .filter(|&k| recording.time[k] >= from && recording.time[k] <= to)
        .collect()
}

#[cfg(test)]
mod tests;
