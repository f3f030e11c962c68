//! Half the distance from the smallest to the largest value.

use super::collect::{Collect, Trend};
use super::max::Max;
use super::min::Min;

/// The smallest and the largest value so far.
#[derive(Clone, Copy, Debug, Default)]
pub struct Amplitude {
    min: Min,
    max: Max,
}

impl Collect for Amplitude {
    const LABEL: &'static str = "amplitude";
    const DIFFERENCE: bool = true;
    const TREND: Trend = Trend::OfExtremes;

    fn add_all(&mut self, values: impl Iterator<Item = (f64, f64)>) {
        for value in values {
            self.min.add_all(std::iter::once(value));
            self.max.add_all(std::iter::once(value));
        }
    }

    fn result(&self, span: f64) -> f64 {
        0.5 * (self.max.result(span) - self.min.result(span))
    }
}
