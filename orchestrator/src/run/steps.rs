//! The steps of a simulation, and what is read between them.

use std::ops::Range;

use super::{Runner, feed, ramp};
use crate::task::CommunicationPoints;
use fmu_import::{Call, Instance, Step};

impl Runner {
    /// Takes some of the steps.
    pub(super) fn advance<const WATCH: bool>(
        &mut self,
        instance: &mut Instance,
        points: &CommunicationPoints,
        steps: Range<u64>,
    ) -> Result<(), Call> {
        if !self.task.inputs.is_empty() || WATCH && !self.slow.is_empty() {
            return self.advance_each::<WATCH>(instance, points, steps);
        }
        let [before, even, after] = points.parts(steps);
        self.advance_each::<WATCH>(instance, points, before)?;
        if WATCH {
            self.watch_evenly(instance, points, even)?;
        } else {
            advance_evenly(instance, points, even)?;
        }
        self.advance_each::<WATCH>(instance, points, after)
    }

    /// Takes any steps, with inputs and everything that is to be read.
    #[inline(never)]
    fn advance_each<const WATCH: bool>(
        &mut self,
        instance: &mut Instance,
        points: &CommunicationPoints,
        steps: Range<u64>,
    ) -> Result<(), Call> {
        for index in steps {
            let (time, next) = (points.at(index), points.at(index + 1));
            let step = next - time;
            feed(&self.task, instance, time)?;
            ramp(&self.task, instance, time, next)?;
            instance.step(time, step)?;
            if WATCH {
                self.watch(instance, step)?;
            }
        }
        Ok(())
    }

    /// Takes even steps without inputs and reads real variables. Their statistics follow some steps at a
    /// time: that takes less than to look at each value by itself.
    #[inline(never)]
    fn watch_evenly(
        &mut self,
        instance: &mut Instance,
        points: &CommunicationPoints,
        steps: Range<u64>,
    ) -> Result<(), Call> {
        let mut time = points.at(steps.start);
        let mut first = steps.start;
        while first < steps.end {
            let watched = &mut self.watched;
            let end = steps.end.min(first + watched.steps.len() as u64);
            let count = even_steps(points, first..end, &mut time, &mut watched.steps);
            let steps = &watched.steps[..count];
            let (done, outcome) = instance.steps(steps, &watched.references, &mut watched.values);
            // Where the FMU ends the simulation by itself, the steps before count.
            watched.take(done);
            outcome?;
            first = end;
        }
        Ok(())
    }

    /// Reads what has a statistic over time.
    pub(super) fn watch(&mut self, instance: &mut Instance, elapsed: f64) -> Result<(), Call> {
        self.watched.read(instance, elapsed)?;
        self.watch_others(instance, elapsed)
    }

    fn watch_others(&mut self, instance: &mut Instance, elapsed: f64) -> Result<(), Call> {
        for (index, accumulator) in &mut self.slow {
            accumulator.add(elapsed, self.task.observed[*index].read(instance)?);
        }
        Ok(())
    }
}

/// Takes even steps without inputs: by far the most, so they are handed over many at a time.
#[inline(never)]
fn advance_evenly(
    instance: &mut Instance,
    points: &CommunicationPoints,
    steps: Range<u64>,
) -> Result<(), Call> {
    // So few that the processor prepares the next ones while the FMU still computes.
    const TOGETHER: usize = 8;
    let mut together = [Step::default(); TOGETHER];
    let mut time = points.at(steps.start);
    let mut first = steps.start;
    while first < steps.end {
        let end = steps.end.min(first + TOGETHER as u64);
        let count = even_steps(points, first..end, &mut time, &mut together);
        instance.steps(&together[..count], &[], &mut []).1?;
        first = end;
    }
    Ok(())
}

/// Begin and size of even steps, as many as there is room for; `time` is where the first one begins, and moves on.
fn even_steps(
    points: &CommunicationPoints,
    steps: Range<u64>,
    time: &mut f64,
    into: &mut [Step],
) -> usize {
    let mut count = 0;
    for (next, step) in points.even_ends(steps).zip(into) {
        *step = Step {
            time: *time,
            size: next - *time,
        };
        *time = next;
        count += 1;
    }
    count
}
