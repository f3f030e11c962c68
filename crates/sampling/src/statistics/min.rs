//! The smallest value.

use super::collect::{Collect, Trend};

/// The smallest value so far.
#[derive(Clone, Copy, Debug)]
pub struct Min(f64);

impl Default for Min {
    fn default() -> Self {
        Self(f64::INFINITY)
    }
}

impl Collect for Min {
    const LABEL: &'static str = "least";
    const TREND: Trend = Trend::OfExtremes;

    fn add_all(&mut self, values: impl Iterator<Item = (f64, f64)>) {
        for (_, value) in values {
            if value < self.0 || value.is_nan() {
                self.0 = value;
            }
        }
    }

    fn result(&self, _: f64) -> f64 {
        self.0
    }
}
