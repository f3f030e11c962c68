//! A simulation in which criteria look at different parts of the run.

use super::collector::Collector;
use super::{Runner, before_the_window, start, step};
use crate::task::Probe;
use fmu_import::{Call, Instance};

/// A probe with what it has seen so far.
struct Gauge<'a> {
    probe: &'a Probe,
    window: [f64; 2],
    collector: Collector,
    /// When it looked first and last, s.
    seen: Option<[f64; 2]>,
}

impl Gauge<'_> {
    /// Looks at the variable, if the time is in the window; rounding of times counts as nothing.
    fn look(&mut self, time: f64, instance: &mut Instance) -> Result<(), Call> {
        let [from, to] = self.window;
        let rounding = 1e-9 * (from.abs() + to.abs());
        if time < from - rounding || time > to + rounding {
            return Ok(());
        }
        let [first, last] = self.seen.unwrap_or([time, time]);
        let value = self.probe.read(instance)?;
        match self.probe.companion() {
            Some(other) => {
                let other = instance.value(other)?.number();
                self.collector.add_beside(time - last, value, other);
            }
            None => self.collector.add(time, time - last, value),
        }
        self.seen = Some([first, time]);
        Ok(())
    }
}

impl Runner {
    /// Whether a criterion has a window of its own, or looks at another variable, too.
    pub(super) fn has_windows(&self) -> bool {
        self.scene
            .task
            .observed
            .iter()
            .any(|probe| probe.window.is_some() || probe.companion().is_some())
    }

    /// Simulates a point and takes each statistic over its own window.
    pub(super) fn simulate_windows(
        &mut self,
        instance: &mut Instance,
        values: &[f64],
    ) -> Result<(), Call> {
        let task = self.scene.task.clone();
        let points = task.schedule.points();
        let mut gauges: Vec<Gauge<'_>> = task
            .observed
            .iter()
            .map(|probe| Gauge {
                probe,
                window: probe
                    .window
                    .unwrap_or([task.schedule.window_start, task.schedule.stop]),
                collector: Collector::new(probe),
                seen: None,
            })
            .collect();
        start(&task, instance, values)?;
        let look = |gauges: &mut [Gauge<'_>], time: f64, instance: &mut Instance| {
            gauges
                .iter_mut()
                .try_for_each(|gauge| gauge.look(time, instance))
        };
        look(&mut gauges, points.at(0), instance)?;
        for index in 0..points.steps {
            let (time, next) = (points.at(index), points.at(index + 1));
            let Err(call) = step(&task, &self.scene.stops, instance, [time, next]) else {
                look(&mut gauges, next, instance)?;
                continue;
            };
            // An end that the FMU chose is no failure, unless it comes before a window.
            let Some(end) = call.ended else {
                return Err(call);
            };
            look(&mut gauges, end.at, instance)?;
            if gauges.iter().any(|gauge| gauge.seen.is_none()) {
                return Err(before_the_window(call));
            }
            self.until_its_end(Err(call))?;
            break;
        }
        for (gauge, result) in gauges.iter_mut().zip(&mut self.scene.results) {
            let span = gauge.seen.map_or(f64::NAN, |[first, last]| last - first);
            // Without a value there is no result, which is found out by everyone who asks for one.
            *result = if span.is_nan() {
                span
            } else {
                gauge.collector.result(span)
            };
            self.notices.conforming.extend(gauge.collector.conforming());
        }
        Ok(())
    }
}
