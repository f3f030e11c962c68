//! A variable that is read by itself while a point runs: one that is no real number, or any where a criterion has a window
//! of its own.

use std::ops::Range;

use super::collector::Collector;
use crate::{notices::Replicates, task::Probe};
use fmu_import::{Called, Instance};

/// A probe, and what it has seen so far.
#[derive(Debug)]
pub struct Gauge {
    /// The numbers of its probes.
    pub probes: Range<usize>,
    window: [f64; 2],
    pub collector: Collector,
    /// When it looked first and last, s.
    pub seen: Option<[f64; 2]>,
}

impl Gauge {
    /// One for probes that look at the `usual` window where they have none of their own, s.
    pub fn new(numbers: Range<usize>, observed: &[Probe], usual: [f64; 2]) -> Self {
        let probes = &observed[numbers.clone()];
        Self {
            window: probes[0].window.unwrap_or(usual),
            collector: Collector::new(probes),
            probes: numbers,
            seen: None,
        }
    }

    /// Forgets all that it has seen.
    pub fn restart(&mut self, observed: &[Probe]) {
        self.collector.restart(&observed[self.probes.clone()]);
        self.seen = None;
    }

    /// Looks at the variable, if the time is in the window; rounding of times counts as nothing.
    pub fn look(&mut self, observed: &[Probe], time: f64, instance: &mut Instance) -> Called {
        let probe = &observed[self.probes.start];
        let [from, to] = self.window;
        let rounding = 1e-9 * (from.abs() + to.abs());
        if time < from - rounding || time > to + rounding {
            return Ok(());
        }
        let [first, last] = self.seen.unwrap_or([time, time]);
        let value = probe.read(instance)?;
        match probe.measure.companion() {
            Some(other) => {
                let other = instance.value(other)?.number();
                self.collector.add_beside(time - last, value, other);
            }
            None => self.collector.add(time, time - last, value),
        }
        self.seen = Some([first, time]);
        Ok(())
    }

    /// Puts down what came of it; the draws of a measured curve to which it conforms. Without a value there is no result,
    /// which is found out by everyone who asks for one.
    pub fn finish(&mut self, results: &mut [f64]) -> Option<Replicates> {
        let results = &mut results[self.probes.clone()];
        match self.seen {
            Some([first, last]) => self.collector.results(last - first, results),
            None => results.fill(f64::NAN),
        }
        self.collector.conforming()
    }
}
