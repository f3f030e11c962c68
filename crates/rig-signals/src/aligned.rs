//! The signals once they are aligned, and what follows from them.

use super::delay::Delay;
use super::holes::Holes;
use super::recording::{Accuracy, Channel, DerivedCriterion, RigRecording, Synchronised};
use super::signal::{Even, SignalError, Spline};
use super::spectrum::Noise;
use super::stationarity::{self, block_means, uncertainty_of_mean};
use super::uncertainty::{MeasuredValue, from_bound, of_product};
use sampling::statistics::moments::{mean, variance};

/// The aligned signals over their common time.
pub(crate) struct Aligned<'a> {
    recording: &'a RigRecording,
    /// What is known so far.
    result: Synchronised,
    /// Times without samples of the load, and of the torque as recorded.
    holes: [Holes; 2],
    step: f64,
    /// The time at which the common part of load and torque begins before the shift, s.
    first: f64,
    speed: Vec<f64>,
    /// Samples in a whole number of turns, about a thirtieth of the record.
    block: usize,
    /// Samples in one turn.
    turn: usize,
}

impl<'a> Aligned<'a> {
    pub(crate) fn new(
        recording: &'a RigRecording,
        (load_raw, torque_raw): (Even, Even),
        load: &Even,
        late: &Spline,
        speed: Even,
        (delay, holes): (Delay, [Holes; 2]),
    ) -> Self {
        let (start, end) = late.span();
        let shift = delay.shift();
        let times: Vec<f64> = load.times();
        let is_common = |&k: &usize| (start..=end).contains(&(times[k] + shift));
        let kept: Vec<usize> = (0..times.len()).filter(is_common).collect();
        let time: Vec<f64> = kept.iter().map(|&k| times[k]).collect();
        let at_these = |signal: &Even| -> Vec<f64> {
            let last = signal.values.len() - 1;
            kept.iter().map(|&k| signal.values[k.min(last)]).collect()
        };
        let n = time.len();
        let turn = recording.turn().map(|turn| (turn / load.step).round());
        // Without a turning shaft any block is as good as another.
        let turn = turn.filter(|turn| (1.0..n as f64 / 8.0).contains(turn));
        let turn = turn.map_or(1, |turn| turn as usize);
        let block = (n / 30 / turn).max(1) * turn;
        Self {
            recording,
            holes,
            step: load.step,
            first: load.start,
            speed: at_these(&speed),
            block,
            turn,
            result: Synchronised {
                block: block as f64 * load.step,
                load_raw: at_these(&load_raw),
                torque_raw: at_these(&torque_raw),
                load: at_these(load),
                torque_before: time.iter().map(|t| late.at(*t)).collect(),
                torque: time.iter().map(|t| late.at(t + shift)).collect(),
                time,
                delay,
                ..Synchronised::default()
            },
        }
    }

    pub(crate) fn finish(
        self,
        [load_noise, torque_noise]: [Option<Noise>; 2],
        even: impl Fn(&Channel) -> Result<(Vec<f64>, Holes, Option<Noise>), SignalError>,
    ) -> Result<Synchronised, SignalError> {
        let (recording, known) = (self.recording, &self.result);
        let half = recording.diameter / 2.0;
        let friction = |torque: &[f64]| -> Vec<f64> {
            let pairs = torque.iter().zip(&known.load);
            pairs.map(|(m, f)| m / (f * half)).collect()
        };
        let pairs = known.torque.iter().zip(&self.speed);
        let power: Vec<f64> = pairs.map(|(m, w)| m * w).collect();
        let relative = |channel: &Channel, values: &[f64]| match mean(values) {
            0.0 => 0.0,
            centre => channel.accuracy.standard(centre) / centre.abs(),
        };
        let of_load = relative(&recording.load, &known.load);
        let of_torque = relative(&recording.torque, &known.torque);
        let of_speed = relative(&recording.speed, &self.speed);
        let [load_holes, torque_holes] = &self.holes;
        let (start, shift) = (known.time[0], known.delay.shift());
        let turn_name = if self.turn > 1 { "turn" } else { "sample" };
        let mut lost = Vec::new();
        let mut of_channel =
            |channel: &Channel, values: &[f64], holes: &Holes, start: f64, noise| {
                let turns = holes.whole_turns(values, self.turn, [start, self.step]);
                lost.extend(turns.concern(&channel.name, turn_name));
                let sensor = |value| channel.accuracy.standard(value);
                let mean = self.mean(channel, &turns.values, sensor);
                DerivedCriterion { noise, ..mean }
            };
        let mut findings = vec![
            of_channel(&recording.load, &known.load, load_holes, start, load_noise),
            of_channel(
                &recording.torque,
                &known.torque,
                torque_holes,
                start + shift,
                torque_noise,
            ),
        ];
        // What follows from both lacks what either one lacks.
        let both = load_holes.and(torque_holes, shift);
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
            let product = |v| of_product(v, &[of_torque, of_speed]);
            findings.push(DerivedCriterion {
                from: Some([
                    recording.torque.name.clone(),
                    recording.speed.variable.clone(),
                ]),
                ..self.mean(&channel, &of_both(&power), product)
            });
        }
        for channel in &recording.others {
            let (values, holes, noise) = even(channel)?;
            findings.push(of_channel(channel, &values, &holes, self.first, noise));
        }
        findings.push(self.amplitude(&recording.load, &known.load));
        findings.push(self.amplitude(&recording.torque, &known.torque));
        let [friction_before, friction] =
            [&known.torque_before, &known.torque].map(|m| friction(m));
        let mean_friction = self.mean(&recording.torque, &of_both(&friction), |v| {
            of_product(v, &[of_load, of_torque])
        });
        let scatter = [&friction_before, &friction]
            .map(|values| variance(values, 0).sqrt() / mean(values).abs());
        let mut warnings = self.warnings(&findings, scatter);
        warnings.extend(lost);
        Ok(Synchronised {
            friction_before,
            friction,
            friction_scatter: scatter,
            power,
            mean_friction: mean_friction.measured,
            findings,
            warnings,
            ..self.result
        })
    }

    /// The mean of a signal's whole turns.
    fn mean(
        &self,
        channel: &Channel,
        whole: &[f64],
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
            noise: None,
            from: None,
            stationarity: stationarity::test(&blocks, self.recording.confidence),
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
        let half = |turn: &[f64]| {
            let low = turn.iter().copied().fold(f64::INFINITY, f64::min);
            let high = turn.iter().copied().fold(f64::NEG_INFINITY, f64::max);
            (high - low) / 2.0
        };
        let halves: Vec<f64> = values.chunks_exact(span).map(half).collect();
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
            noise: None,
            from: None,
            blocks: vec![],
            stationarity: None,
        }
    }

    fn warnings(&self, findings: &[DerivedCriterion], [before, after]: [f64; 2]) -> Vec<String> {
        let mut warnings = Vec::new();
        let delay = &self.result.delay;
        if delay.delay.is_none() {
            warnings.push(format!(
                "these signals are not related: chance alone explains how far the torque follows the load (probability \
                 {:.3}; below 0.005 they would count as related), so the torque is not shifted",
                delay.chance
            ));
        } else if delay.at_edge {
            warnings.push("the greatest correlation lies at the edge of the searched delays: it is no maximum; allow a longer delay".into());
        } else if let Some(disturbance) = &delay.disturbance {
            warnings.push(disturbance.clone());
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
                    self.step * self.result.time.len() as f64,
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
