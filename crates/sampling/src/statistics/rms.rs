//! The root of the mean square over time.

use super::{
    collect::{Collect, Trend},
    mean::Mean,
};

/// The mean of the squares.
#[derive(Clone, Copy, Debug, Default)]
pub struct Rms(Mean);

impl Collect for Rms {
    const LABEL: &'static str = "rms";
    const TREND: Trend = Trend::OfSignal;

    #[inline]
    fn add_all(&mut self, values: impl Iterator<Item = (f64, f64)>) {
        self.0.add_all(values.map(|(elapsed, value)| (elapsed, value * value)));
    }

    fn result(&self, span: f64) -> f64 {
        self.0.result(span).sqrt()
    }
}
