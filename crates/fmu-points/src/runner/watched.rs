//! Real variables that are read at every communication point while a point runs.

use std::ops::Range;

use super::{collector::Collector, together::Together};
use crate::task::Task;
use fmu_import::{Called, Instance};

/// Real variables that are read in one call.
#[derive(Debug)]
pub struct Watched {
    pub references: Vec<u32>,
    /// The values of some steps, those of a step side by side.
    pub values: Vec<f64>,
    /// Those steps.
    pub steps: Together,
    /// How many of them there may be.
    pub most: usize,
    pub collectors: Vec<Collector>,
    /// The numbers of each collector's probes.
    pub probes: Vec<Range<usize>>,
}

impl Watched {
    /// How many values are gathered at the most before they are looked at: so few that the nearest cache holds them.
    const GATHERED: usize = 1024;

    pub fn new(task: &Task, probes: Vec<Range<usize>>) -> Self {
        let observed = || probes.iter().map(|probes| &task.observed[probes.clone()]);
        let most = (Self::GATHERED / probes.len().max(1)).clamp(1, Together::MOST);
        Self {
            references: observed().map(|probes| probes[0].handle.reference).collect(),
            values: vec![0.0; most * probes.len()],
            steps: Together::default(),
            most,
            collectors: observed().map(Collector::new).collect(),
            probes,
        }
    }

    /// Reads the values at one communication point.
    pub fn read(&mut self, instance: &mut Instance, last: f64, elapsed: f64) -> Called {
        if !self.probes.is_empty() {
            instance.reals(&self.references, &mut self.values[..self.probes.len()])?;
            self.steps.begins[0] = last;
            self.steps.sizes[0] = elapsed;
            self.take(1);
        }
        Ok(())
    }

    /// Hands over what has been gathered from some steps.
    #[inline]
    pub fn take(&mut self, steps: usize) {
        let (begins, sizes) = self.steps.first(steps);
        match &mut self.collectors[..] {
            [Collector::Statistic(accumulator)] => {
                accumulator.add_all(sizes.iter().copied().zip(self.values.iter().copied()));
            }
            several => take_columns(several, begins, sizes, &self.values),
        }
    }
}

/// The same for several variables, one after another, and for curves.
#[inline(never)]
fn take_columns(collectors: &mut [Collector], begins: &[f64], sizes: &[f64], values: &[f64]) {
    let count = collectors.len();
    for (number, collector) in collectors.iter_mut().enumerate() {
        let column = || sizes.iter().copied().zip(values[number..].iter().step_by(count).copied());
        match collector {
            Collector::Statistic(accumulator) => accumulator.add_all(column()),
            Collector::Event(accumulator, first) => {
                if let ([begin, ..], [size, ..]) = (begins, sizes) {
                    first.get_or_insert(begin + size);
                }
                accumulator.add_all(column());
            }
            // They need another variable, which a gauge reads, too.
            Collector::Turns(_) => {}
            Collector::Curve(comparison) => {
                comparison.add_steps(begins, sizes, &values[number..], count);
            }
            Collector::Value(sampler) | Collector::Rows(sampler, _) => {
                sampler.add_steps(begins, sizes, &values[number..], count);
            }
        }
    }
}
