//! A case as it is simulated: its settings and inputs, and what is gathered on the way.

use std::ops::Range;

use super::{gauge::Gauge, watched::Watched};
use crate::{
    names::behind,
    notices::Notices,
    task::{Measure, Probe, Product, SensorError, Slot, Task, place},
};
use fmu_import::{Called, Content, EarlyEnd, Instance};
use sampling::{
    random::{Purpose, Random},
    statistics::Direction,
};

/// A case, and what is gathered while it is simulated.
#[derive(Debug)]
pub struct Scene {
    /// The number of the case.
    pub number: usize,
    pub task: Task,
    /// The times between communication points to which the FMU takes a step, since a recorded input turns there.
    pub stops: Vec<f64>,
    /// The real variables that are read at every communication point.
    pub watched: Watched,
    /// The other probes that are read there: all of them where one has a window, or looks at another variable, too.
    pub gauges: Vec<Gauge>,
    pub has_windows: bool,
    /// The rows of each input as they were recorded, and how its sensor read in this point.
    recorded: Vec<(Vec<f64>, Reading)>,
    pub results: Vec<f64>,
}

/// How a sensor reads: a multiple of the true value, and a shift.
#[derive(Clone, Copy, Debug)]
struct Reading {
    factor: f64,
    shift: f64,
}

/// The numbers of probes in groups: those that read a curve row by row need one look for all rows.
pub fn together(observed: &[Probe], numbers: impl Iterator<Item = usize>) -> Vec<Range<usize>> {
    let mut groups: Vec<Range<usize>> = Vec::new();
    for number in numbers {
        match groups.last_mut() {
            Some(last) if last.end == number && observed[number - 1].is_followed_by(&observed[number]) => {
                last.end += 1;
            }
            _ => groups.push(number..number + 1),
        }
    }
    groups
}

/// Takes the errors that the sensors have in a point off the recorded inputs.
fn correct(task: &mut Task, recorded: &mut [(Vec<f64>, Reading)], values: &[f64]) {
    let Task { varied, inputs, .. } = task;
    for (series, (recorded, reading)) in inputs.iter_mut().zip(recorded) {
        let handle = series.slot.handle;
        let own = varied.iter().zip(values).filter(|(slot, _)| !slot.idle && slot.handle == handle);
        (reading.factor, reading.shift) = (1.0, 0.0);
        let mut noise = None;
        for (error, &value) in own.filter_map(|(slot, value)| Some((slot.error?, value))) {
            match error {
                SensorError::Offset => reading.shift += value,
                SensorError::Gain { about } => {
                    reading.factor = 1.0 + value;
                    reading.shift -= value * about;
                }
                SensorError::Noise { .. } if value == 0.0 => {}
                SensorError::Noise { deviation } => {
                    noise = Some((deviation, Random::new(value.to_bits(), Purpose::Row, handle.reference)));
                }
            }
        }
        for (value, row) in series.values.iter_mut().zip(recorded) {
            let of_row = noise.as_mut().map_or(0.0, |(deviation, random)| *deviation * random.normal());
            *value = (*row - reading.shift) / reading.factor - of_row;
        }
    }
}

impl Scene {
    pub fn new(number: usize, mut task: Task) -> Self {
        let exact = Reading { factor: 1.0, shift: 0.0 };
        let mut recorded: Vec<_> = task.inputs.iter().map(|series| (series.values.clone(), exact)).collect();
        // With noise every row is a turn.
        let has_noise = |slot: &Slot| matches!(slot.error, Some(SensorError::Noise { .. }));
        let noisy: Vec<f64> = task.varied.iter().map(|slot| f64::from(has_noise(slot))).collect();
        correct(&mut task, &mut recorded, &noisy);
        let stops = place(&mut task.inputs, &task.schedule);
        let has_windows =
            task.observed.iter().any(|probe| probe.window.is_some() || probe.measure.companion().is_some());
        let (probes, others): (Vec<_>, Vec<_>) = task
            .observed
            .iter()
            .enumerate()
            .filter(|(_, probe)| has_windows || !probe.measure.is_final())
            .partition(|(_, probe)| !has_windows && probe.handle.content == Content::Real);
        let [probes, others] =
            [probes, others].map(|of| together(&task.observed, of.iter().map(|(number, _)| *number)));
        let usual = [task.schedule.window_start, task.schedule.stop];
        let gauges = others.into_iter();
        Self {
            number,
            recorded,
            gauges: gauges.map(|probes| Gauge::new(probes, &task.observed, usual)).collect(),
            has_windows,
            watched: Watched::new(&task, probes),
            results: vec![0.0; task.observed.len()],
            stops,
            task,
        }
    }

    /// Sets the start values and initialises.
    pub fn start(&mut self, instance: &mut Instance, values: &[f64]) -> Called {
        correct(&mut self.task, &mut self.recorded, values);
        let (task, schedule) = (&self.task, &self.task.schedule);
        instance.setup_experiment(schedule.start, schedule.stop, schedule.tolerance)?;
        instance.resize(&task.sizes)?;
        for (reference, value) in &task.fixed {
            instance.set(*reference, value)?;
        }
        let taken = task.varied.iter().zip(values);
        for (slot, &value) in taken.filter(|(slot, _)| !slot.idle && slot.error.is_none()) {
            instance.set(slot.handle.reference, &slot.value(value))?;
        }
        self.feed(instance, schedule.start)?;
        instance.initialise()
    }

    /// Multiplies by what the sensors read where the rig did: a linear statistic of f (a i + b) is a times that of f i, and b
    /// times that of f.
    fn multiply_by_readings(&mut self) {
        for (number, probe) in self.task.observed.iter().enumerate() {
            let Some(Product { of, by, factor }) = probe.product else { continue };
            let mut inputs = self.task.inputs.iter().zip(&self.recorded);
            let reading = inputs.find(|(series, _)| series.slot.handle == by).map(|(_, (_, reading))| *reading);
            let mut probes = self.task.observed.iter();
            let other = probes.position(|other| other.handle == of && other.takes_same_statistic(probe));
            if let (Some(reading), Some(other)) = (reading, other) {
                self.results[number] =
                    reading.factor * self.results[number] + factor * reading.shift * self.results[other];
            }
        }
    }

    /// Sets the inputs that change over time.
    fn feed(&self, instance: &mut Instance, time: f64) -> Called {
        for series in &self.task.inputs {
            let value = series.slot.value(series.at(time));
            instance.set(series.slot.handle.reference, &value)?;
        }
        Ok(())
    }

    /// Goes from one communication point to the next, with a step to each time at which a recorded input turns.
    pub fn step(&self, instance: &mut Instance, [begin, end]: [f64; 2]) -> Called {
        let ahead = &self.stops[self.stops.partition_point(|&stop| stop <= begin)..];
        let between = ahead.iter().copied().take_while(|&stop| stop < end);
        let mut time = begin;
        for next in between.chain([end]) {
            self.feed(instance, time)?;
            // Some inputs vary within the step.
            for series in self.task.inputs.iter().filter(|series| series.ramp) {
                instance.set_slope(series.slot.handle.reference, series.slope(time, next))?;
            }
            instance.step(time, next - time).map_err(|mut call| {
                // What was read last is that of the communication point.
                call.ended = call.ended.map(|ended| EarlyEnd { from: begin, ..ended });
                call
            })?;
            time = next;
        }
        Ok(())
    }

    /// Why a result is no number, as far as that is known.
    pub fn why_none(&self, result: usize) -> Option<String> {
        let watched = &self.watched;
        let watched = watched.probes.iter().zip(&watched.collectors);
        let gauges = self.gauges.iter().map(|gauge| (&gauge.probes, &gauge.collector));
        let (_, collector) = watched.chain(gauges).find(|(probes, _)| probes.contains(&result))?;
        let probe = &self.task.observed[result];
        let (Measure::Crossing { level, direction }, [low, high]) = (&probe.measure, collector.uncrossed()?) else {
            return None;
        };
        let crosses = match direction {
            Direction::Either => "crosses",
            Direction::Rising => "rises to",
            Direction::Falling => "falls to",
        };
        let unit = behind(probe.unit.as_deref());
        let [low, high] = [low, high].map(|value| format!("{value:.5e}").parse().unwrap_or(value));
        Some(format!(" never {crosses} {level}{unit}, but stays within {low} .. {high}{unit}"))
    }

    /// Empties what is gathered.
    pub fn forget(&mut self) {
        let watched = &mut self.watched;
        for (probes, collector) in watched.probes.iter().zip(&mut watched.collectors) {
            collector.restart(&self.task.observed[probes.clone()]);
        }
        for gauge in &mut self.gauges {
            gauge.restart(&self.task.observed);
        }
    }

    /// The results, with the statistics of most variables taken over `span` seconds.
    pub fn finish(&mut self, instance: &mut Instance, span: f64, notices: &mut Notices) -> Called {
        let watched = &mut self.watched;
        for (probes, collector) in watched.probes.iter().zip(&mut watched.collectors) {
            collector.results(span, &mut self.results[probes.clone()]);
            notices.conforming.extend(collector.conforming());
        }
        for gauge in &mut self.gauges {
            notices.conforming.extend(gauge.finish(&mut self.results));
        }
        if !self.has_windows {
            let finals = self.task.observed.iter().zip(&mut self.results);
            for (probe, result) in finals.filter(|(probe, _)| probe.measure.is_final()) {
                *result = probe.read(instance)?;
            }
        }
        self.multiply_by_readings();
        Ok(())
    }
}
