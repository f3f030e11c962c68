//! The signals once they are aligned, and what follows from them.

use super::{
    delay::Delay,
    holes::Holes,
    recording::{Bearing, Channel, DerivedCriterion, RigRecording, Synchronised},
    signal::{Even, SignalError, Spline},
    spectrum::Noise,
    stationarity::{self, block_means, uncertainty_of_mean},
    uncertainty::{MeasuredValue, of_product},
};
use sampling::statistics::moments::{mean, variance};

/// The aligned signals over their common time.
pub struct Aligned<'a> {
    recording: &'a RigRecording,
    bearing: &'a Bearing,
    /// What is known so far.
    result: Synchronised,
    /// Times without samples of the load, and of the torque as recorded.
    holes: [Holes; 2],
    step: f64,
    grid: Grid,
}

/// Turns and blocks of a signal at even times.
pub struct Grid {
    /// The first sample's time and the time between samples, s.
    pub time: [f64; 2],
    /// Samples in one turn.
    turn: usize,
    /// Samples in a whole number of turns, about a thirtieth of the record.
    block: usize,
    /// Confidence of the tests of stationarity.
    confidence: f64,
}

impl Grid {
    /// That of so many samples.
    pub fn new(recording: &RigRecording, time: [f64; 2], samples: usize) -> Self {
        let turn = recording.turn().map(|turn| (turn / time[1]).round());
        // Without a turning shaft any block is as good as another.
        let turn = turn.filter(|turn| (1.0..samples as f64 / 8.0).contains(turn));
        let turn = turn.map_or(1, |turn| turn as usize);
        Self { time, turn, block: (samples / 30 / turn).max(1) * turn, confidence: recording.confidence }
    }

    /// The mean of a channel's whole turns, and the concern about the others.
    pub fn mean_of(
        &self,
        channel: &Channel,
        values: &[f64],
        holes: &Holes,
        noise: Option<Noise>,
    ) -> (DerivedCriterion, Option<String>) {
        let turns = holes.whole_turns(values, self.turn, self.time);
        let name = if self.turn > 1 { "turn" } else { "sample" };
        let mean = self.mean(channel, &turns.values, |value| channel.accuracy.standard(value));
        (DerivedCriterion { noise, ..mean }, turns.concern(&channel.name, name))
    }

    /// The mean of a signal's whole turns.
    fn mean(&self, channel: &Channel, whole: &[f64], sensor: impl Fn(f64) -> f64) -> DerivedCriterion {
        let blocks = block_means(whole, self.block);
        let value = mean(whole);
        DerivedCriterion {
            name: channel.name.clone(),
            variable: channel.variable.clone(),
            unit: channel.unit.clone(),
            group: channel.group.clone(),
            measured: MeasuredValue { value, scatter: uncertainty_of_mean(&blocks), sensor: sensor(value) },
            stationarity: stationarity::test(&blocks, self.confidence),
            blocks,
            block: [self.time[0], self.block as f64 * self.time[1]],
            ..DerivedCriterion::default()
        }
    }
}

impl<'a> Aligned<'a> {
    pub fn new(
        (recording, bearing): (&'a RigRecording, &'a Bearing),
        (load_raw, torque_raw): (Even, Even),
        load: &Even,
        late: &Spline,
        (delay, holes): (Delay, [Holes; 2]),
    ) -> Self {
        let (start, end) = late.span();
        let shift = delay.shift();
        let times: Vec<f64> = load.times();
        let kept: Vec<usize> = (0..times.len()).filter(|&k| (start..=end).contains(&(times[k] + shift))).collect();
        let time: Vec<f64> = kept.iter().map(|&k| times[k]).collect();
        let at_these = |signal: &Even| -> Vec<f64> {
            let last = signal.values.len() - 1;
            kept.iter().map(|&k| signal.values[k.min(last)]).collect()
        };
        let start = time.first().copied().unwrap_or(load.start);
        Self {
            recording,
            bearing,
            grid: Grid::new(recording, [start, load.step], time.len()),
            holes,
            step: load.step,
            result: Synchronised {
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

    pub fn finish(
        self,
        [load_noise, torque_noise]: [Option<Noise>; 2],
        other: impl Fn(&Channel) -> Result<(DerivedCriterion, Option<String>), SignalError>,
    ) -> Result<Synchronised, SignalError> {
        let (bearing, known) = (self.bearing, &self.result);
        let half = bearing.diameter / 2.0;
        let friction =
            |torque: &[f64]| -> Vec<f64> { torque.iter().zip(&known.load).map(|(m, f)| m / (f * half)).collect() };
        let relative = |channel: &Channel, values: &[f64]| match mean(values) {
            0.0 => 0.0,
            centre => channel.accuracy.standard(centre) / centre.abs(),
        };
        let of_load = relative(&bearing.load, &known.load);
        let of_torque = relative(&bearing.torque, &known.torque);
        let [load_holes, torque_holes] = &self.holes;
        let (start, shift) = (known.time[0], known.delay.shift());
        let late = Grid { time: [start + shift, self.step], ..self.grid };
        let (mean_load, no_load) = self.grid.mean_of(&bearing.load, &known.load, load_holes, load_noise);
        let (mean_torque, no_torque) = late.mean_of(&bearing.torque, &known.torque, torque_holes, torque_noise);
        let mut lost: Vec<String> = no_load.into_iter().chain(no_torque).collect();
        let mut findings = vec![mean_load, mean_torque];
        // What follows from both lacks what either one lacks.
        let both = load_holes.and(torque_holes, shift);
        let of_both = |values: &[f64]| both.whole_turns(values, self.grid.turn, [start, self.step]).values;
        for channel in &self.recording.others {
            let (finding, concern) = other(channel)?;
            findings.push(finding);
            lost.extend(concern);
        }
        let [friction_before, friction] = [&known.torque_before, &known.torque].map(|m| friction(m));
        let mean_friction =
            self.grid.mean(&bearing.torque, &of_both(&friction), |v| of_product(v, &[of_load, of_torque]));
        let scatter = [&friction_before, &friction].map(|values| variance(values, 0).sqrt() / mean(values).abs());
        let warnings = self.warnings(&findings, scatter);
        Ok(Synchronised {
            friction_before,
            friction,
            friction_scatter: scatter,
            mean_friction: mean_friction.measured,
            findings,
            warnings,
            doubts: lost,
            ..self.result
        })
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
        warnings.extend(findings.iter().filter_map(unsteady));
        warnings
    }
}

/// The concern about a mean of what is not steady.
pub fn unsteady(finding: &DerivedCriterion) -> Option<String> {
    let name = &finding.name;
    Some(match &finding.stationarity {
        None => format!("{name}: the window is too short to test whether it is steady"),
        Some(s) if s.trend => format!(
            "{name} is drifting: {:.3} {} over the window of {:.1} s (chance {:.1e})",
            s.change.value,
            finding.unit,
            finding.block[1] * finding.blocks.len() as f64,
            s.trend_chance
        ),
        Some(s) if s.drift => format!("{name} wanders over the window (chance {:.1e})", s.wander_chance),
        Some(_) => return None,
    })
}
