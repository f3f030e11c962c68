//! The amplitude of the strongest oscillation.

use super::collect::Collect;
use super::oscillation::Recording;

/// The signal's values, of which the spectrum is taken at the end.
#[derive(Clone, Debug, Default)]
pub struct OscillationAmplitude(Recording);

impl Collect for OscillationAmplitude {
    const LABEL: &'static str = "amplitude of the strongest oscillation";
    const DIFFERENCE: bool = true;
    const NEEDS_LINES: bool = true;

    fn add_all(&mut self, values: impl Iterator<Item = (f64, f64)>) {
        self.0.add_all(values);
    }

    /// Zero where the signal is a straight line; not a number where no oscillation stands out.
    fn result(&self, _: f64) -> f64 {
        if self.0.is_straight() {
            return 0.0;
        }
        let strongest = self.0.strongest();
        strongest.map_or(f64::NAN, |oscillation| oscillation.amplitude)
    }
}
