//! The interface of a statistic of a signal.

/// How a statistic of a signal changes when the signal moves on after the statistic's window.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Trend {
    /// As the signal does.
    OfSignal,
    /// Only when a value goes beyond the extreme ones.
    OfExtremes,
    /// Nothing simple can be said.
    Unknown,
}

/// Collects what a statistic of a signal needs, value by value; in constant memory where that is possible.
pub trait Collect: Default {
    /// The statistic's name in a sentence.
    const LABEL: &'static str;

    /// Whether it is a difference of two values, which has no offset when units convert.
    const DIFFERENCE: bool = false;

    /// Its unit, where that does not follow from the signal's.
    const UNIT: Option<&'static str> = None;

    /// Whether it is the time since the first value.
    const SINCE_FIRST: bool = false;

    /// Whether it means nothing for a variable that jumps between whole numbers.
    const NEEDS_LINES: bool = false;

    /// How it changes when the signal moves on after the last value.
    const TREND: Trend = Trend::Unknown;

    /// Takes values one after another, each with the time since the one before (zero for the first one). A NaN must
    /// show in the result.
    fn add_all(&mut self, values: impl Iterator<Item = (f64, f64)>);

    /// The statistic of the values so far, of which there must be one, over `span` seconds.
    fn result(&self, span: f64) -> f64;
}

/// Collects a statistic that grows as its values do, from the values as they are and in [`LARGE`] units: sums, squares and
/// differences of large values are beyond all numbers, where the statistic is not.
#[derive(Clone, Copy, Debug, Default)]
pub struct Scaled<C>([C; 2]);

/// A power of two, so that no digit changes.
pub const LARGE: f64 = f64::from_bits((1023 + 600) << 52);

impl<C: Collect> Collect for Scaled<C> {
    const LABEL: &'static str = C::LABEL;
    const DIFFERENCE: bool = C::DIFFERENCE;
    const TREND: Trend = C::TREND;

    #[inline]
    fn add_all(&mut self, values: impl Iterator<Item = (f64, f64)>) {
        let Self([plain, scaled]) = self;
        for (elapsed, value) in values {
            plain.add_all(std::iter::once((elapsed, value)));
            scaled.add_all(std::iter::once((elapsed, value / LARGE)));
        }
    }

    fn result(&self, span: f64) -> f64 {
        let Self([plain, scaled]) = self;
        let result = plain.result(span);
        if result.is_finite() { result } else { LARGE * scaled.result(span) }
    }
}
