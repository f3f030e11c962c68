//! The slope of the straight line of least squares.

use super::collect::Collect;

/// The slope of a signal, from the integral of its distance from its first value, and the first moment of that.
#[derive(Clone, Copy, Debug, Default)]
pub struct Slope {
    first: Option<f64>,
    last: f64,
    /// Time since the first value.
    time: f64,
    integral: f64,
    moment: f64,
}

impl Collect for Slope {
    const LABEL: &'static str = "slope";
    const DIFFERENCE: bool = true;

    fn add_all(&mut self, values: impl Iterator<Item = (f64, f64)>) {
        for (elapsed, value) in values {
            let rise = value - *self.first.get_or_insert(value);
            // Straight lines times time are parabolas, which Simpson's rule integrates exactly.
            let middle = 0.5 * (self.last + rise);
            self.integral += elapsed * middle;
            let ends = self.time * self.last + (self.time + elapsed) * rise;
            self.moment += elapsed * (ends + 4.0 * (self.time + 0.5 * elapsed) * middle) / 6.0;
            self.time += elapsed;
            self.last = rise;
        }
    }

    /// The line a + b t for which the integral of (y - a - b t)^2 is least has
    /// b = 12 / T^3 times the integral of (t - T / 2) y over the span T.
    fn result(&self, _: f64) -> f64 {
        let span = self.time;
        12.0 * (self.moment - 0.5 * span * self.integral) / span.powi(3)
    }
}
