//! The smallest value, the largest one, and half the distance between them.

use super::collect::{Collect, Trend};

/// The value that is farthest to one side so far.
#[derive(Clone, Copy, Debug)]
pub struct Extreme<const LARGEST: bool>(f64);

/// The smallest value.
pub type Min = Extreme<false>;

/// The largest value.
pub type Max = Extreme<true>;

impl<const LARGEST: bool> Default for Extreme<LARGEST> {
    fn default() -> Self {
        Self(if LARGEST { f64::NEG_INFINITY } else { f64::INFINITY })
    }
}

impl<const LARGEST: bool> Collect for Extreme<LARGEST> {
    const LABEL: &'static str = if LARGEST { "greatest" } else { "least" };
    const TREND: Trend = Trend::OfExtremes;

    fn add_all(&mut self, values: impl Iterator<Item = (f64, f64)>) {
        for (_, value) in values {
            let is_beyond = if LARGEST { value > self.0 } else { value < self.0 };
            if is_beyond || value.is_nan() {
                self.0 = value;
            }
        }
    }

    fn result(&self, _: f64) -> f64 {
        self.0
    }
}

/// Half the distance from the smallest to the largest value.
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
        0.5 * self.max.result(span) - 0.5 * self.min.result(span)
    }
}
