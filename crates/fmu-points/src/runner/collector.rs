//! Collects one variable while a point runs.

use super::resampled::Draws;
use crate::{
    notices::Replicates,
    task::{Measure, MeasuredCurve, Probe},
};
use curves::{Pair, Sampler};
use sampling::statistics::{Accumulator, MeanOverTurns};

/// Gathers what a probe asks for, value by value.
#[derive(Debug)]
pub enum Collector {
    Statistic(Accumulator),
    /// A time since the first value, and when that was.
    Event(Accumulator, Option<f64>),
    /// The mean over whole turns of an angle.
    Turns(MeanOverTurns),
    Curve(Box<Comparison>),
    /// The value at a time between communication points.
    Value(Sampler),
    /// Those at the rows of a curve, each the result of a probe, and their conversion: a factor and an offset.
    Rows(Sampler, [f64; 2]),
}

impl Collector {
    /// One for a probe, or for several that read a curve row by row.
    pub fn new(probes: &[Probe]) -> Self {
        let probe = &probes[0];
        match &probe.measure {
            Measure::Statistic(statistic) if statistic.is_since_first() => {
                Self::Event(Accumulator::new(*statistic), None)
            }
            Measure::Statistic(statistic) => Self::Statistic(Accumulator::new(*statistic)),
            Measure::Percentile(percent) => Self::Statistic(Accumulator::percentile(*percent)),
            Measure::At(time) => Self::Value(Sampler::new(vec![*time])),
            Measure::Crossing { level, direction } => Self::Event(Accumulator::crossing(*level, *direction), None),
            Measure::MeanOverTurns { turn, .. } => Self::Turns(MeanOverTurns::new(*turn)),
            Measure::Curve(curve) => Self::Curve(Box::new(Comparison::new(curve))),
            Measure::Row { factor, offset, .. } => {
                let times = probes.iter().filter_map(|probe| match probe.measure {
                    Measure::Row { time, .. } => Some(time),
                    _ => None,
                });
                Self::Rows(Sampler::new(times.collect()), [*factor, *offset])
            }
        }
    }

    /// Forgets all values.
    pub fn restart(&mut self, probes: &[Probe]) {
        match self {
            Self::Statistic(_) | Self::Event(..) | Self::Turns(_) => *self = Self::new(probes),
            Self::Curve(comparison) => comparison.restart(),
            Self::Value(sampler) | Self::Rows(sampler, _) => sampler.restart(),
        }
    }

    /// Takes a value at a time, `elapsed` after the one before.
    pub fn add(&mut self, time: f64, elapsed: f64, value: f64) {
        match self {
            Self::Statistic(accumulator) => accumulator.add(elapsed, value),
            Self::Event(accumulator, first) => {
                first.get_or_insert(time);
                accumulator.add(elapsed, value);
            }
            // The angle beside a value comes through `add_beside`.
            Self::Turns(mean) => mean.add(elapsed, value, f64::NAN),
            Self::Curve(comparison) => comparison.add(time, value),
            Self::Value(sampler) | Self::Rows(sampler, _) => sampler.add(time, value),
        }
    }

    /// Takes a value with the angle that stands beside it.
    pub fn add_beside(&mut self, elapsed: f64, value: f64, angle: f64) {
        if let Self::Turns(mean) = self {
            mean.add(elapsed, value, angle);
        }
    }

    /// The result of the values for each of its probes, over `span` seconds; not a number where a curve was not reached to its
    /// end, or a value not at all.
    pub fn results(&mut self, span: f64, results: &mut [f64]) {
        let Self::Rows(sampler, [factor, offset]) = self else {
            results[0] = self.result(span);
            return;
        };
        results.fill(f64::NAN);
        let values = sampler.finish().unwrap_or_default();
        for (result, value) in results.iter_mut().zip(values) {
            *result = *factor * value + *offset;
        }
    }

    fn result(&mut self, span: f64) -> f64 {
        match self {
            Self::Statistic(accumulator) => accumulator.result(span),
            Self::Event(accumulator, first) => first.unwrap_or(f64::NAN) + accumulator.result(span),
            Self::Turns(mean) => mean.result(),
            Self::Curve(comparison) => comparison.result(),
            Self::Value(sampler) | Self::Rows(sampler, _) => sampler.finish().map_or(f64::NAN, |values| values[0]),
        }
    }

    /// The range of a signal that never crossed the level whose crossing is asked for.
    pub fn uncrossed(&self) -> Option<[f64; 2]> {
        match self {
            Self::Event(accumulator, _) => accumulator.uncrossed(),
            _ => None,
        }
    }

    /// To which draws of the measured curve the last result conforms; none where that was not asked.
    pub fn conforming(&mut self) -> Option<Replicates> {
        match self {
            Self::Curve(comparison) => comparison.conforming.take(),
            _ => None,
        }
    }
}

/// Compares a variable with a measured curve.
#[derive(Debug)]
pub struct Comparison {
    measured: MeasuredCurve,
    /// The variable's values at the measurement's times.
    samples: Sampler,
    /// The curves that the measured one may truly have been.
    draws: Option<Draws>,
    conforming: Option<Replicates>,
}

impl Comparison {
    fn new(measured: &MeasuredCurve) -> Self {
        Self {
            draws: measured.resampling.as_ref().map(Draws::new),
            conforming: None,
            samples: Sampler::new(measured.shown_times().collect()),
            measured: measured.clone(),
        }
    }

    fn restart(&mut self) {
        self.conforming = None;
        self.samples.restart();
    }

    fn add(&mut self, time: f64, value: f64) {
        self.add_steps(&[time], &[0.0], &[value], 1);
    }

    /// Takes the values at the ends of steps: every `stride`th one.
    pub fn add_steps(&mut self, begins: &[f64], sizes: &[f64], values: &[f64], stride: usize) {
        self.samples.add_steps(begins, sizes, values, stride);
    }

    fn result(&mut self) -> f64 {
        let measured = &self.measured;
        let Ok(samples) = self.samples.finish() else { return f64::NAN };
        let model: Vec<f64> = samples.iter().map(|value| measured.factor * value + measured.offset).collect();
        let pair =
            Pair { band: &measured.band, normaliser: measured.normaliser, ..Pair::new(&measured.values, &model) };
        self.conforming = self.draws.as_mut().map(|draws| draws.conforming(measured.metric, &pair));
        measured.metric.compare(&pair)
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::super::scene::together;
    use super::*;
    use curves::Metric;
    use fmu_import::{Content, Handle};

    fn probe(delay: f64) -> Probe {
        let curve = MeasuredCurve {
            metric: Metric::MaxError,
            times: vec![1.0, 2.5, 3.0],
            values: vec![10.0, 25.0, 31.0],
            band: Vec::new(),
            errors: None,
            resampling: None,
            normaliser: 1.0,
            delay,
            factor: 10.0,
            offset: 0.0,
        };
        Probe {
            name: "y".to_owned(),
            handle: Handle { reference: 0, content: Content::Real },
            measure: Measure::Curve(Arc::new(curve)),
            window: None,
            unit: None,
            product: None,
        }
    }

    /// The model is t in its own unit, in steps of a second.
    fn error(probe: &Probe, until: i32) -> f64 {
        let probes = std::slice::from_ref(probe);
        let mut collector = Collector::new(probes);
        for _ in 0..2 {
            collector.restart(probes);
            for time in (0..=until).map(f64::from) {
                collector.add(time, 1.0, time);
            }
        }
        collector.result(f64::NAN)
    }

    #[test]
    fn the_model_is_compared_at_the_measured_times() {
        assert_eq!(error(&probe(0.0), 3), 1.0);
        assert!(error(&probe(0.0), 2).is_nan());
        assert_eq!(error(&probe(0.5), 3), 6.0);
    }

    /// The model is t squared in uneven steps; between them it is a straight line.
    #[test]
    fn a_value_is_taken_between_communication_points() {
        let at = |time: f64| {
            let probe = Probe { measure: Measure::At(time), ..probe(0.0) };
            let probes = [probe];
            let mut collector = Collector::new(&probes);
            for _ in 0..2 {
                collector.restart(&probes);
                for time in [0.0, 0.5, 2.0] {
                    collector.add(time, f64::NAN, time * time);
                }
            }
            collector.result(f64::NAN)
        };
        assert_eq!(at(0.0), 0.0);
        assert_eq!(at(0.5), 0.25);
        assert_eq!(at(1.5), 0.25 + 3.75 / 1.5);
        assert_eq!(at(2.0), 4.0);
        assert!(at(2.1).is_nan());
    }

    /// Rows of one curve are read by one look, whose values are those of a look each.
    #[test]
    fn rows_are_read_together() {
        let whole = probe(0.0);
        let curve = whole.measure.curve().unwrap();
        let mut rows: Vec<Probe> = [0.5, 1.25, 3.0].map(|at| whole.at_row(curve, at)).into();
        rows.push(whole.at_row(curve, 2.0));
        rows.push(whole.clone());
        assert_eq!(together(&rows, 0..5), [0..3, 3..4, 4..5]);
        assert_eq!(together(&rows, [0, 2].into_iter()), [0..1, 2..3]);
        let mut collector = Collector::new(&rows[..3]);
        for until in [4, 2] {
            collector.restart(&rows[..3]);
            for time in (0..=until).map(f64::from) {
                collector.add(time, 1.0, time * time);
            }
            let mut results = [0.0; 3];
            collector.results(f64::NAN, &mut results);
            match until {
                4 => assert_eq!(results, [5.0, 17.5, 90.0]),
                _ => assert!(results.iter().all(|value| value.is_nan())),
            }
        }
    }
}
