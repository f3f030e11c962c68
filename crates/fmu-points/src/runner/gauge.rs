//! A variable that is read by itself while a point runs: one that is no real number, or any where a criterion has a window
//! of its own.

use super::collector::Collector;
use crate::notices::Replicates;
use crate::task::Probe;
use fmu_import::{Call, Instance};

/// A probe, and what it has seen so far.
#[derive(Debug)]
pub(super) struct Gauge {
    /// The number of the probe.
    pub(super) probe: usize,
    window: [f64; 2],
    pub(super) collector: Collector,
    /// When it looked first and last, s.
    seen: Option<[f64; 2]>,
}

impl Gauge {
    /// One for a probe that looks at the `usual` window where it has none of its own, s.
    pub(super) fn new(number: usize, probe: &Probe, usual: [f64; 2]) -> Self {
        Self {
            probe: number,
            window: probe.window.unwrap_or(usual),
            collector: Collector::new(probe),
            seen: None,
        }
    }

    /// Forgets all that it has seen.
    pub(super) fn restart(&mut self, probe: &Probe) {
        self.collector.restart(probe);
        self.seen = None;
    }

    /// Looks at the variable, if the time is in the window; rounding of times counts as nothing.
    pub(super) fn look(
        &mut self,
        probe: &Probe,
        time: f64,
        instance: &mut Instance,
    ) -> Result<(), Call> {
        let [from, to] = self.window;
        let rounding = 1e-9 * (from.abs() + to.abs());
        if time < from - rounding || time > to + rounding {
            return Ok(());
        }
        let [first, last] = self.seen.unwrap_or([time, time]);
        let value = probe.read(instance)?;
        match probe.companion() {
            Some(other) => {
                let other = instance.value(other)?.number();
                self.collector.add_beside(time - last, value, other);
            }
            None => self.collector.add(time, time - last, value),
        }
        self.seen = Some([first, time]);
        Ok(())
    }

    /// Whether it has looked at all.
    pub(super) fn has_seen(&self) -> bool {
        self.seen.is_some()
    }

    /// What came of it, with the draws of a measured curve to which it conforms. Without a value there is no result,
    /// which is found out by everyone who asks for one.
    pub(super) fn result(&mut self) -> (f64, Option<Replicates>) {
        let result = match self.seen {
            Some([first, last]) => self.collector.result(last - first),
            None => f64::NAN,
        };
        (result, self.collector.conforming())
    }
}
