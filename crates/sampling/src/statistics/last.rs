//! The last value.

use super::collect::{Collect, Trend};

/// The last value so far.
#[derive(Clone, Copy, Debug, Default)]
pub struct Last {
    last: f64,
}

impl Collect for Last {
    const LABEL: &'static str = "final value";
    const TREND: Trend = Trend::OfSignal;

    fn add_all(&mut self, values: impl Iterator<Item = (f64, f64)>) {
        self.last = values.last().map_or(self.last, |(_, value)| value);
    }

    fn result(&self, _: f64) -> f64 {
        self.last
    }
}
