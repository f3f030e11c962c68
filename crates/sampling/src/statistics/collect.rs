//! The interface of a statistic of a signal.

/// Collects what a statistic of a signal needs, value by value; in constant memory where that is possible.
pub(super) trait Collect: Default {
    /// The statistic's name in a sentence.
    const LABEL: &'static str;

    /// Whether it is a difference of two values, which has no offset when units convert.
    const DIFFERENCE: bool = false;

    /// Its unit, where that does not follow from the signal's.
    const UNIT: Option<&'static str> = None;

    /// Whether it is the time since the first value.
    const SINCE_FIRST: bool = false;

    /// Takes values one after another, each with the time since the one before (zero for the first one). A NaN must
    /// show in the result.
    fn add_all(&mut self, values: impl Iterator<Item = (f64, f64)>);

    /// The statistic of the values so far, of which there must be one, over `span` seconds.
    fn result(&self, span: f64) -> f64;
}
