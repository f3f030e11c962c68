//! The largest value.

use super::collect::{Collect, Trend};

/// The largest value so far.
#[derive(Clone, Copy, Debug)]
pub struct Max(f64);

impl Default for Max {
    fn default() -> Self {
        Self(f64::NEG_INFINITY)
    }
}

impl Collect for Max {
    const LABEL: &'static str = "greatest";
    const TREND: Trend = Trend::OfExtremes;

    fn add_all(&mut self, values: impl Iterator<Item = (f64, f64)>) {
        for (_, value) in values {
            if value > self.0 || value.is_nan() {
                self.0 = value;
            }
        }
    }

    fn result(&self, _: f64) -> f64 {
        self.0
    }
}
