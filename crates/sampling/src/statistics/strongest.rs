//! Frequency and amplitude of the strongest oscillation.

use super::{collect::Collect, oscillation::Recording};

/// The signal's values, of which the spectrum is taken at the end.
#[derive(Clone, Debug, Default)]
pub struct Strongest<const AMPLITUDE: bool>(Recording);

/// The frequency of the strongest oscillation.
pub type Frequency = Strongest<false>;

/// The amplitude of the strongest oscillation.
pub type Amplitude = Strongest<true>;

impl<const AMPLITUDE: bool> Collect for Strongest<AMPLITUDE> {
    const LABEL: &'static str = if AMPLITUDE { "amplitude of the strongest oscillation" } else { "frequency" };
    const DIFFERENCE: bool = AMPLITUDE;
    const UNIT: Option<&'static str> = if AMPLITUDE { None } else { Some("Hz") };
    const NEEDS_LINES: bool = true;

    fn add_all(&mut self, values: impl Iterator<Item = (f64, f64)>) {
        self.0.add_all(values);
    }

    /// Not a number where no oscillation stands out; but the amplitude of a straight line is 0.
    fn result(&self, _: f64) -> f64 {
        match self.0.strongest() {
            Some(oscillation) if AMPLITUDE => oscillation.amplitude,
            Some(oscillation) => oscillation.frequency,
            None if AMPLITUDE && self.0.is_straight() => 0.0,
            None => f64::NAN,
        }
    }
}
