//! The steps of a simulation, and what is read between them.

use std::ops::Range;

use super::{scene::Scene, together::Together};
use crate::task::CommunicationPoints;
use fmu_import::{Called, Instance};

impl Scene {
    /// Takes some of the steps.
    pub fn advance<const WATCH: bool>(
        &mut self,
        instance: &mut Instance,
        points: &CommunicationPoints,
        steps: Range<u64>,
    ) -> Called {
        if !self.task.inputs.is_empty() || WATCH && !self.gauges.is_empty() {
            return self.advance_each::<WATCH>(instance, points, steps);
        }
        let [before, even, after] = points.parts(steps);
        self.advance_each::<WATCH>(instance, points, before)?;
        self.advance_evenly::<WATCH>(instance, points, even)?;
        self.advance_each::<WATCH>(instance, points, after)
    }

    /// Takes any steps, with inputs and everything that is to be read.
    #[inline(never)]
    fn advance_each<const WATCH: bool>(
        &mut self,
        instance: &mut Instance,
        points: &CommunicationPoints,
        steps: Range<u64>,
    ) -> Called {
        for index in steps {
            let (time, next) = (points.at(index), points.at(index + 1));
            self.step(instance, [time, next])?;
            if WATCH {
                self.watch(instance, [time, next])?;
            }
        }
        Ok(())
    }

    /// Takes even steps without inputs and reads real variables: by far the most, so they are handed over many at a time.
    /// Statistics follow some steps at a time, too: that takes less than to look at each value by itself.
    #[inline(never)]
    fn advance_evenly<const WATCH: bool>(
        &mut self,
        instance: &mut Instance,
        points: &CommunicationPoints,
        steps: Range<u64>,
    ) -> Called {
        let watched = &mut self.watched;
        let most = if WATCH { watched.most } else { Together::MOST };
        let mut first = steps.start;
        while first < steps.end {
            let count = watched.steps.fill(points, first..steps.end, most);
            let (begins, sizes) = watched.steps.first(count);
            let (references, values) =
                if WATCH { (&watched.references[..], &mut watched.values[..]) } else { (&[][..], &mut [][..]) };
            let (done, outcome) = instance.steps(begins, sizes, references, values);
            if WATCH {
                // Where the FMU ends the simulation by itself, the steps before count.
                watched.take(done);
            }
            outcome?;
            first += count as u64;
        }
        Ok(())
    }

    /// Reads what is gathered over time, which was read `last` before.
    pub fn watch(&mut self, instance: &mut Instance, [last, time]: [f64; 2]) -> Called {
        self.watched.read(instance, last, time - last)?;
        let mut gauges = self.gauges.iter_mut();
        gauges.try_for_each(|gauge| gauge.look(&self.task.observed, time, instance))
    }
}
