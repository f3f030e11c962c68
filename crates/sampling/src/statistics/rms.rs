//! The root of the mean square over time.

use super::collect::{Collect, Trend};
use super::mean::Mean;

/// The mean of the squares, and that of values in [`LARGE`] units: the squares of large ones are beyond all numbers.
#[derive(Clone, Copy, Debug, Default)]
pub struct Rms([Mean; 2]);

/// A power of two, so that no digit changes.
const LARGE: f64 = f64::from_bits((1023 + 600) << 52);

impl Collect for Rms {
    const LABEL: &'static str = "rms";
    const TREND: Trend = Trend::OfSignal;

    #[inline]
    fn add_all(&mut self, values: impl Iterator<Item = (f64, f64)>) {
        let Self([squares, large]) = self;
        for (elapsed, value) in values {
            squares.add_all(std::iter::once((elapsed, value * value)));
            large.add_all(std::iter::once((elapsed, (value / LARGE).powi(2))));
        }
    }

    fn result(&self, span: f64) -> f64 {
        let [squares, large] = self.0.map(|mean| mean.result(span).sqrt());
        if squares.is_finite() {
            squares
        } else {
            LARGE * large
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn large_values_have_a_root_of_their_mean_square() {
        for value in [1e160, -1e308, f64::MAX] {
            let mut rms = Rms::default();
            rms.add_all([(0.0, value), (1.0, 0.0), (1.0, 0.0), (1.0, value)].into_iter());
            let expected = (1.0_f64 / 3.0).sqrt();
            let found = rms.result(3.0) / value.abs();
            assert!((found - expected).abs() < 1e-12, "{value}: {found}");
        }
        let mut rms = Rms::default();
        rms.add_all([(0.0, 1.0), (1.0, f64::NAN)].into_iter());
        assert!(rms.result(1.0).is_nan());
    }
}
