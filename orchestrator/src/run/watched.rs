//! Real variables whose statistics are taken while a point runs.

use super::steps::Together;
use crate::task::Task;
use fmu_import::{Call, Instance};
use sampling::statistics::Accumulator;

/// Real variables that are read in one call.
#[derive(Debug)]
pub(super) struct Watched {
    pub(super) references: Vec<u32>,
    /// The values of some steps, those of a step side by side.
    pub(super) values: Vec<f64>,
    /// Those steps.
    pub(super) steps: Together,
    /// How many of them there may be.
    pub(super) most: usize,
    pub(super) accumulators: Vec<Accumulator>,
    /// The numbers of the probes.
    pub(super) probes: Vec<usize>,
}

impl Watched {
    /// How many values are gathered at the most before they are looked at: so few that the nearest cache holds them.
    const GATHERED: usize = 1024;

    pub(super) fn new(task: &Task, probes: Vec<usize>) -> Self {
        let observed = || probes.iter().map(|&index| &task.observed[index]);
        let most = (Self::GATHERED / probes.len().max(1)).clamp(1, Together::MOST);
        Self {
            references: observed().map(|probe| probe.handle.reference).collect(),
            values: vec![0.0; most * probes.len()],
            steps: Together::default(),
            most,
            accumulators: observed()
                .map(|probe| Accumulator::new(probe.statistic))
                .collect(),
            probes,
        }
    }

    /// Reads the values at one communication point.
    pub(super) fn read(&mut self, instance: &mut Instance, elapsed: f64) -> Result<(), Call> {
        if !self.probes.is_empty() {
            instance.reals(&self.references, &mut self.values[..self.probes.len()])?;
            self.steps.sizes[0] = elapsed;
            self.take(1);
        }
        Ok(())
    }

    /// Adds what has been gathered from some steps to the statistics.
    #[inline]
    pub(super) fn take(&mut self, steps: usize) {
        let sizes = &self.steps.sizes[..steps];
        match &mut self.accumulators[..] {
            [accumulator] => {
                let values = self.values.iter().copied();
                accumulator.add_all(sizes.iter().copied().zip(values));
            }
            several => take_columns(several, sizes, &self.values),
        }
    }
}

/// The same for several statistics, one after another.
#[inline(never)]
fn take_columns(accumulators: &mut [Accumulator], sizes: &[f64], values: &[f64]) {
    let count = accumulators.len();
    for (number, accumulator) in accumulators.iter_mut().enumerate() {
        let column = values[number..].iter().step_by(count).copied();
        accumulator.add_all(sizes.iter().copied().zip(column));
    }
}
