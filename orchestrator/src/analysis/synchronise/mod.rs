//! From measured time series to criteria: resample, smooth, align, test, and state the result with
//! its uncertainty (section 5.1 of Vrublevskyi & Skonieczna, and beyond it).

pub mod criteria;
pub mod delay;
pub mod signal;
pub mod smooth;
pub mod stationarity;
pub mod uncertainty;

use crate::analysis::sensitivity::stats::mean;
use delay::Delay;
use signal::{Even, SignalError, Spline};
use smooth::Smoothing;
use stationarity::{Stationarity, block_means, uncertainty_of_mean};
use uncertainty::{Measured, from_bound, of_product};

/// How accurate a sensor is: every error up to plus or minus this much is equally likely.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Accuracy {
    /// In the signal's unit.
    Absolute(f64),
    /// As a fraction of the value.
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
    /// The FMU variable that it is compared with.
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

/// A recording and what to do with it.
#[derive(Clone, Debug, PartialEq)]
pub struct Recording {
    /// Times of the samples, s.
    pub time: Vec<f64>,
    /// The load on the bearing, N.
    pub load: Channel,
    /// The friction torque, N.m.
    pub torque: Channel,
    /// The shaft's speed, rad/s.
    pub speed: Channel,
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

/// One criterion from the record.
#[derive(Clone, Debug, PartialEq)]
pub struct Finding {
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
    pub measured: Measured,
    /// The tests of the block means; `None` where the window is too short for them.
    pub stationarity: Option<Stationarity>,
}

/// What became of a recording.
#[derive(Clone, Debug, PartialEq)]
pub struct Synchronised {
    /// The delay between torque and load.
    pub delay: Delay,
    /// Times of the aligned signals, s.
    pub time: Vec<f64>,
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
    /// The friction coefficient as a measured quantity.
    pub mean_friction: Measured,
    /// The criteria: means first, then amplitudes.
    pub findings: Vec<Finding>,
    /// What a careful reader should know.
    pub warnings: Vec<String>,
}

/// A gap in the record may be this many times as long as a step.
const LONGEST_GAP: f64 = 10.0;

/// Aligns a recording and derives the criteria.
pub fn synchronise(recording: &Recording) -> Result<Synchronised, SignalError> {
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
    let smooth = |spline: &Spline| -> Result<Even, SignalError> {
        let raw = even(spline);
        Ok(Even {
            values: recording.smoothing.apply(&raw.values, step)?,
            ..raw
        })
    };
    let (load, torque) = (smooth(&load)?, smooth(&torque)?);
    let late = Spline::new(
        &recording.torque.name,
        &torque.times(),
        &torque.values,
        LONGEST_GAP,
    )?;
    let delay = delay::find(&load, &late, recording.longest_delay)?;
    Aligned::new(recording, &load, &late, even(&speed), delay)
        .finish(recording, |c| Ok(even(&spline(c)?)))
}

fn check(recording: &Recording) -> Result<(), SignalError> {
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

fn window(recording: &Recording) -> Vec<usize> {
    let [from, to] = recording
        .window
        .unwrap_or([f64::NEG_INFINITY, f64::INFINITY]);
    (0..recording.time.len())
        .filter(|&k| recording.time[k] >= from && recording.time[k] <= to)
        .collect()
}

/// The aligned signals over their common time.
struct Aligned {
    delay: Delay,
    step: f64,
    time: Vec<f64>,
    load: Vec<f64>,
    torque_before: Vec<f64>,
    torque: Vec<f64>,
    speed: Vec<f64>,
    /// Samples in a whole number of turns, about a thirtieth of the record.
    block: usize,
    /// Samples in one turn.
    turn: usize,
}

impl Aligned {
    fn new(recording: &Recording, load: &Even, late: &Spline, speed: Even, delay: Delay) -> Self {
        let (start, end) = late.span();
        let shift = delay.delay.value;
        let kept: Vec<usize> = (0..load.values.len())
            .filter(|&k| {
                let t = load.start + k as f64 * load.step + shift;
                t >= start && t <= end
            })
            .collect();
        let time: Vec<f64> = kept
            .iter()
            .map(|&k| load.start + k as f64 * load.step)
            .collect();
        let turn = mean(
            &recording
                .speed
                .values
                .iter()
                .copied()
                .filter(|v| v.is_finite())
                .collect::<Vec<_>>(),
        );
        let turn = (std::f64::consts::TAU / turn.abs() / load.step).round();
        let n = time.len();
        // Without a turning shaft any block is as good as another.
        let turn = if turn.is_finite() && turn >= 1.0 && turn < n as f64 / 8.0 {
            turn as usize
        } else {
            1
        };
        let turns = (n / 30 / turn).max(1);
        Self {
            step: load.step,
            load: kept.iter().map(|&k| load.values[k]).collect(),
            torque_before: time.iter().map(|t| late.at(*t)).collect(),
            torque: time.iter().map(|t| late.at(t + shift)).collect(),
            speed: kept
                .iter()
                .map(|&k| speed.values[k.min(speed.values.len() - 1)])
                .collect(),
            block: turns * turn,
            turn,
            time,
            delay,
        }
    }

    fn finish(
        self,
        recording: &Recording,
        even: impl Fn(&Channel) -> Result<Even, SignalError>,
    ) -> Result<Synchronised, SignalError> {
        let half = recording.diameter / 2.0;
        let friction = |torque: &[f64]| -> Vec<f64> {
            torque
                .iter()
                .zip(&self.load)
                .map(|(m, f)| m / (f * half))
                .collect()
        };
        let power: Vec<f64> = self
            .torque
            .iter()
            .zip(&self.speed)
            .map(|(m, w)| m * w)
            .collect();
        let relative = |channel: &Channel, values: &[f64]| {
            let centre = mean(values);
            if centre == 0.0 {
                0.0
            } else {
                channel.accuracy.standard(centre) / centre.abs()
            }
        };
        let parts = (
            relative(&recording.load, &self.load),
            relative(&recording.torque, &self.torque),
            relative(&recording.speed, &self.speed),
        );
        let mut findings = vec![
            self.mean(&recording.load, &self.load, recording, |v| {
                recording.load.accuracy.standard(v)
            }),
            self.mean(&recording.torque, &self.torque, recording, |v| {
                recording.torque.accuracy.standard(v)
            }),
        ];
        let power_channel = Channel {
            name: "P_fr".into(),
            variable: "sensor.frictionPower".into(),
            unit: "W".into(),
            ..recording.torque.clone()
        };
        findings.push(self.mean(&power_channel, &power, recording, |v| {
            of_product(v, &[parts.1, parts.2])
        }));
        for channel in &recording.others {
            let values = even(channel)?.values;
            findings.push(self.mean(channel, &values, recording, |v| {
                channel.accuracy.standard(v)
            }));
        }
        findings.push(self.amplitude(&recording.load, &self.load));
        findings.push(self.amplitude(&recording.torque, &self.torque));
        let coefficient = friction(&self.torque);
        let mean_friction = self
            .mean(&recording.torque, &coefficient, recording, |v| {
                of_product(v, &[parts.0, parts.1])
            })
            .measured;
        let warnings = self.warnings(&findings);
        Ok(Synchronised {
            friction_before: friction(&self.torque_before),
            friction: coefficient,
            power,
            mean_friction,
            findings,
            warnings,
            delay: self.delay,
            time: self.time,
            load: self.load,
            torque_before: self.torque_before,
            torque: self.torque,
        })
    }

    fn mean(
        &self,
        channel: &Channel,
        values: &[f64],
        recording: &Recording,
        sensor: impl Fn(f64) -> f64,
    ) -> Finding {
        // Whole turns only: a part of one would shift the mean.
        let whole = &values[..values.len() / self.turn * self.turn];
        let blocks = block_means(whole, self.block);
        let value = mean(whole);
        Finding {
            name: channel.name.clone(),
            variable: channel.variable.clone(),
            statistic: "mean",
            unit: channel.unit.clone(),
            group: channel.group.clone(),
            measured: Measured {
                value,
                scatter: uncertainty_of_mean(&blocks),
                sensor: sensor(value),
            },
            stationarity: stationarity::test(&blocks, recording.confidence),
        }
    }

    /// Half the distance between least and greatest value of a turn, over all turns.
    fn amplitude(&self, channel: &Channel, values: &[f64]) -> Finding {
        let span = if self.turn > 1 {
            self.turn
        } else {
            values.len()
        };
        let halves: Vec<f64> = values
            .chunks_exact(span)
            .map(|turn| {
                let (low, high) = turn
                    .iter()
                    .fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| {
                        (l.min(*v), h.max(*v))
                    });
                (high - low) / 2.0
            })
            .collect();
        let value = mean(&halves);
        // An offset of the sensor does not change an amplitude; a wrong gain does.
        let gain = match channel.accuracy {
            Accuracy::Relative(part) => part,
            Accuracy::Absolute(bound) => bound / mean(values).abs(),
        };
        Finding {
            name: format!("{}_amplitude", channel.name),
            variable: channel.variable.clone(),
            statistic: "amplitude",
            unit: channel.unit.clone(),
            group: channel.group.clone(),
            measured: Measured {
                value,
                scatter: uncertainty_of_mean(&halves),
                sensor: from_bound(gain * value),
            },
            stationarity: None,
        }
    }

    fn warnings(&self, findings: &[Finding]) -> Vec<String> {
        let mut warnings = Vec::new();
        if self.delay.at_edge {
            warnings.push("the least variance lies at the edge of the searched delays: it is no minimum; allow a longer delay".into());
        }
        if self.delay.after > 0.9 * self.delay.before {
            warnings.push("the shift hardly reduces the variance of the friction coefficient: the record tells little about the delay".into());
        }
        for finding in findings.iter().filter(|f| f.statistic == "mean") {
            match &finding.stationarity {
                None => warnings.push(format!(
                    "{}: the window is too short to test whether it is steady",
                    finding.name
                )),
                Some(s) if s.trend => warnings.push(format!(
                    "{} is drifting: {:.3} {} over the window of {:.1} s (chance {:.1e})",
                    finding.name,
                    s.change.value,
                    finding.unit,
                    self.step * self.time.len() as f64,
                    s.trend_chance
                )),
                Some(s) if s.drift => warnings.push(format!(
                    "{} wanders over the window (chance {:.1e})",
                    finding.name, s.wander_chance
                )),
                Some(_) => {}
            }
        }
        warnings
    }
}

#[cfg(test)]
mod tests;
