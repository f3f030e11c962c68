//! The mean over time.

use super::collect::{Collect, Trend};

/// The integral over time by the trapezoidal rule: over whole periods of a periodic signal it is exact to all
/// orders.
#[derive(Clone, Copy, Debug, Default)]
pub struct Mean {
    last: f64,
    /// Twice the integral.
    integral: f64,
}

impl Collect for Mean {
    const LABEL: &'static str = "mean";
    const TREND: Trend = Trend::OfSignal;

    #[inline]
    fn add_all(&mut self, values: impl Iterator<Item = (f64, f64)>) {
        let (mut integral, mut last) = (self.integral, self.last);
        for (elapsed, value) in values {
            integral += elapsed * (last + value);
            last = value;
        }
        (self.integral, self.last) = (integral, last);
    }

    fn result(&self, span: f64) -> f64 {
        if span > 0.0 { 0.5 * self.integral / span } else { self.last }
    }
}
