//! Real variables whose statistics are taken while a point runs.

use crate::task::Task;
use fmu_import::{Call, Instance, Step};
use sampling::statistics::Accumulator;

/// Real variables that are read in one call.
#[derive(Debug)]
pub(super) struct Watched {
    pub(super) references: Vec<u32>,
    /// The values of some steps, those of a step side by side.
    pub(super) values: Vec<f64>,
    /// Those steps.
    pub(super) steps: Vec<Step>,
    pub(super) accumulators: Vec<Accumulator>,
    /// The numbers of the probes.
    pub(super) probes: Vec<usize>,
}

impl Watched {
    /// How many values are gathered, and from how many steps at the most, before they are looked at: so few
    /// that the processor begins the next steps while it still adds.
    const GATHERED: (usize, usize) = (1024, 8);

    pub(super) fn new(task: &Task, probes: Vec<usize>) -> Self {
        let observed = || probes.iter().map(|&index| &task.observed[index]);
        let (values, steps) = Self::GATHERED;
        let steps = (values / probes.len().max(1)).clamp(1, steps);
        Self {
            references: observed().map(|probe| probe.handle.reference).collect(),
            values: vec![0.0; steps * probes.len()],
            steps: vec![Step::default(); steps],
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
            self.steps[0].size = elapsed;
            self.take(1);
        }
        Ok(())
    }

    /// Adds what has been gathered from some steps to the statistics.
    pub(super) fn take(&mut self, steps: usize) {
        let elapsed = self.steps[..steps].iter().map(|step| step.size);
        if let [accumulator] = &mut self.accumulators[..] {
            accumulator.add_all(elapsed.zip(self.values.iter().copied()));
            return;
        }
        let count = self.accumulators.len();
        for (number, accumulator) in self.accumulators.iter_mut().enumerate() {
            let values = self.values[number..].iter().step_by(count).copied();
            accumulator.add_all(elapsed.clone().zip(values));
        }
    }
}
