//! A measured curve with which a variable is compared.

use serde::{Deserialize, Serialize};

use curves::Metric;

/// A measured curve in the criterion's unit, and the way to compare with it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct MeasuredCurve {
    /// Turns both curves into one number.
    pub metric: Metric,
    /// When it was measured, s, growing.
    pub times: Vec<f64>,
    /// The values then.
    pub values: Vec<f64>,
    /// The half width of the corridor at these times; empty for other metrics.
    pub band: Vec<f64>,
    /// The errors of the values; none where no uncertainty is stated.
    pub errors: Option<CurveErrors>,
    /// The true curves that its uncertainty allows, and when the model conforms to one; none where that is not asked.
    pub resampling: Option<Resampling>,
    /// By what a normalised metric divides.
    pub normaliser: f64,
    /// By how much the measurement is late, s: its value at `t` belongs to the model's at `t - delay`.
    pub delay: f64,
    /// From the FMU's unit to the criterion's: `factor * value + offset`.
    pub factor: f64,
    /// See `factor`.
    pub offset: f64,
}

/// The errors of a measured curve's values, in the criterion's unit: standard uncertainties by parts.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct CurveErrors {
    /// What one standard deviation of the error that all rows share changes in each.
    pub shared: Vec<f64>,
    /// The gain's, as a part of each value.
    pub gain: f64,
    /// That of each row's own error.
    pub own: Vec<f64>,
    /// How many standard deviations of the shared errors are stated as uncertainty; of a rectangular one the root of 3.
    pub coverage: [f64; 2],
    /// Whether all shared errors between limits are equally probable; they are normal otherwise.
    pub rectangular: bool,
}

/// How a measured curve is drawn anew within its uncertainty, and which of the draws the model conforms to.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Resampling {
    /// The errors of the values; none where they are not known, as between the rows of an uneven curve.
    pub errors: Option<CurveErrors>,
    /// 1, or -1 where the shared errors go against those of the curve whose seed it has.
    pub sign: f64,
    /// The seed of the errors: one for each recorded column.
    pub seed: u64,
    /// The row of the recording from which the values come first.
    pub first: u64,
    /// The metric's value of equal curves.
    pub ideal: f64,
    /// How far from it a metric's value may be.
    pub tolerance: f64,
}

impl MeasuredCurve {
    /// The times on the model's clock.
    pub fn shown_times(&self) -> impl Iterator<Item = f64> + '_ {
        self.times.iter().map(|time| time - self.delay)
    }

    /// The expanded uncertainty of a row, all parts of its error together; none where no uncertainty is stated.
    pub fn expanded(&self, row: usize) -> Option<f64> {
        let errors = self.errors.as_ref()?;
        let gain = errors.gain * self.values.get(row)?;
        let standard = errors.shared.get(row)?.hypot(gain).hypot(*errors.own.get(row)?);
        Some(errors.coverage[0] * standard)
    }

    /// The first and the last time at which the model's value is needed, s.
    pub fn needs(&self) -> [f64; 2] {
        [self.times.first(), self.times.last()].map(|time| *time.expect("a measured curve has samples") - self.delay)
    }
}
