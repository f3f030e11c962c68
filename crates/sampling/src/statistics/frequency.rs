//! The frequency of the strongest oscillation.

use super::collect::Collect;
use super::oscillation::Recording;

/// The signal's values, of which the spectrum is taken at the end.
#[derive(Clone, Debug, Default)]
pub struct Frequency(Recording);

impl Collect for Frequency {
    const LABEL: &'static str = "frequency";
    const UNIT: Option<&'static str> = Some("Hz");
    const NEEDS_LINES: bool = true;

    fn add_all(&mut self, values: impl Iterator<Item = (f64, f64)>) {
        self.0.add_all(values);
    }

    /// Not a number where no oscillation stands out.
    fn result(&self, _: f64) -> f64 {
        let strongest = self.0.strongest();
        strongest.map_or(f64::NAN, |oscillation| oscillation.frequency)
    }
}
