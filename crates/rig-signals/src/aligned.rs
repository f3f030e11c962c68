//! The signals once they are aligned, and what follows from them.

use super::delay::Delay;
use super::holes::Holes;
use super::recording::{Accuracy, Channel, DerivedCriterion, RigRecording, Synchronised, turn};
use super::signal::{Even, SignalError, Spline};
use super::stationarity::{self, block_means, uncertainty_of_mean};
use super::uncertainty::{MeasuredValue, from_bound, of_product};
use sampling::statistics::moments::{mean, variance};

/// The aligned signals over their common time.
pub(crate) struct Aligned {
    delay: Delay,
    /// Times without samples of the load, and of the torque as recorded.
    holes: [Holes; 2],
    step: f64,
    /// The time at which the common part of load and torque begins before the shift, s.
    first: f64,
    time: Vec<f64>,
    load_raw: Vec<f64>,
    torque_raw: Vec<f64>,
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
    pub(crate) fn new(
        recording: &RigRecording,
        (load_raw, torque_raw): (Even, Even),
        load: &Even,
        late: &Spline,
        speed: Even,
        (delay, holes): (Delay, [Holes; 2]),
    ) -> Self {
        let (start, end) = late.span();
        let shift = delay.shift();
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
        let turn = turn(recording).map_or(f64::NAN, |turn| (turn / load.step).round());
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
            first: load.start,
            load_raw: kept.iter().map(|&k| load_raw.values[k]).collect(),
            torque_raw: kept
                .iter()
                .map(|&k| torque_raw.values[k.min(torque_raw.values.len() - 1)])
                .collect(),
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
            holes,
        }
    }

    pub(crate) fn finish(
        self,
        recording: &RigRecording,
        even: impl Fn(&Channel) -> Result<(Vec<f64>, Holes), SignalError>,
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
        let [load_holes, torque_holes] = &self.holes;
        let (start, late) = (self.time[0], self.time[0] + self.delay.shift());
        let mut lost = Vec::new();
        let mut findings = Vec::new();
        for (channel, values, holes, start) in [
            (&recording.load, &self.load, load_holes, start),
            (&recording.torque, &self.torque, torque_holes, late),
        ] {
            let turns = holes.whole_turns(values, self.turn, [start, self.step]);
            lost.extend(turns.concern(&channel.name, self.turn_name()));
            findings.push(self.mean(channel, &turns.values, recording, |v| {
                channel.accuracy.standard(v)
            }));
        }
        // What follows from both lacks what either one lacks.
        let both = load_holes.and(torque_holes, self.delay.shift());
        let of_both = |values: &[f64]| {
            both.whole_turns(values, self.turn, [start, self.step])
                .values
        };
        if let Some(derived) = &recording.power {
            let channel = Channel {
                name: derived.name.clone(),
                variable: derived.variable.clone(),
                unit: "W".into(),
                group: derived.group.clone(),
                ..recording.torque.clone()
            };
            findings.push(self.mean(&channel, &of_both(&power), recording, |v| {
                of_product(v, &[parts.1, parts.2])
            }));
        }
        for channel in &recording.others {
            let (values, holes) = even(channel)?;
            let turns = holes.whole_turns(&values, self.turn, [self.first, self.step]);
            lost.extend(turns.concern(&channel.name, self.turn_name()));
            findings.push(self.mean(channel, &turns.values, recording, |v| {
                channel.accuracy.standard(v)
            }));
        }
        findings.push(self.amplitude(&recording.load, &self.load));
        findings.push(self.amplitude(&recording.torque, &self.torque));
        let coefficient = friction(&self.torque);
        let mean_friction = self
            .mean(&recording.torque, &of_both(&coefficient), recording, |v| {
                of_product(v, &[parts.0, parts.1])
            })
            .measured;
        let friction_before = friction(&self.torque_before);
        let scatter = [&friction_before, &coefficient]
            .map(|values| variance(values, 0).sqrt() / mean(values).abs());
        let mut warnings = self.warnings(&findings, scatter);
        warnings.extend(lost);
        Ok(Synchronised {
            friction_before,
            friction_scatter: scatter,
            friction: coefficient,
            power,
            mean_friction,
            findings,
            warnings,
            block: self.block as f64 * self.step,
            delay: self.delay,
            time: self.time,
            load_raw: self.load_raw,
            torque_raw: self.torque_raw,
            load: self.load,
            torque_before: self.torque_before,
            torque: self.torque,
        })
    }

    fn turn_name(&self) -> &'static str {
        if self.turn > 1 { "turn" } else { "sample" }
    }

    /// The mean of a signal's whole turns.
    fn mean(
        &self,
        channel: &Channel,
        whole: &[f64],
        recording: &RigRecording,
        sensor: impl Fn(f64) -> f64,
    ) -> DerivedCriterion {
        let blocks = block_means(whole, self.block);
        let value = mean(whole);
        DerivedCriterion {
            name: channel.name.clone(),
            variable: channel.variable.clone(),
            statistic: "mean",
            unit: channel.unit.clone(),
            group: channel.group.clone(),
            measured: MeasuredValue {
                value,
                scatter: uncertainty_of_mean(&blocks),
                sensor: sensor(value),
            },
            stationarity: stationarity::test(&blocks, recording.confidence),
            blocks,
        }
    }

    /// Half the distance between least and greatest value of a turn, over all turns.
    fn amplitude(&self, channel: &Channel, values: &[f64]) -> DerivedCriterion {
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
        DerivedCriterion {
            name: format!("{}_amplitude", channel.name),
            variable: channel.variable.clone(),
            statistic: "amplitude",
            unit: channel.unit.clone(),
            group: channel.group.clone(),
            measured: MeasuredValue {
                value,
                scatter: uncertainty_of_mean(&halves),
                sensor: from_bound(gain * value),
            },
            blocks: vec![],
            stationarity: None,
        }
    }

    fn warnings(&self, findings: &[DerivedCriterion], [before, after]: [f64; 2]) -> Vec<String> {
        let mut warnings = Vec::new();
        let delay = &self.delay;
        if delay.delay.is_none() {
            warnings.push(format!(
                "these signals are not related: chance alone explains how far the torque follows the load (probability \
                 {:.3}; below 0.005 they would count as related), so the torque is not shifted",
                delay.chance
            ));
        } else if delay.at_edge {
            warnings.push("the greatest correlation lies at the edge of the searched delays: it is no maximum; allow a longer delay".into());
        } else if after > 0.9 * before {
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
